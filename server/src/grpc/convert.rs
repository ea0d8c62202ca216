//! Rows of the store as messages.

use bendtwin_core::{ModelLoss, Progress, Stage};
use bendtwin_proto::{json::timestamp as time, v1};
use bendtwin_store::{
    Job, Key, Match, NewRule, Overview, OwnerUsage, PageRequest, Project, Quotas, Requirements,
    Rule, State, StoredBytes, Supplement, Trashed, Twin,
};
use jiff::Timestamp;

use crate::{
    access::{self, Scope},
    app::{Error, Result, WorkerView},
};

pub(super) fn page(size: u32, token: String) -> PageRequest {
    PageRequest { size, token }
}

pub(crate) fn capture(overview: Overview) -> v1::Capture {
    let Overview { capture, mut ingest, report, supplements, has_masks } = overview;
    v1::Capture {
        name: capture.id.to_string(),
        display_name: capture.labels.display_name,
        create_time: Some(time(capture.created)),
        size_bytes: capture.size_bytes,
        digest: capture.digest.to_hex().to_string(),
        ingest_requirements: requirements(std::mem::take(&mut ingest.requirements)),
        ingest: Some(job(ingest)),
        verdict: report.map(|r| r.verdict).unwrap_or_default(),
        note: capture.labels.note,
        tags: capture.labels.tags,
        owner: capture.owner,
        recorded_by: capture.recorded_by,
        supplements: supplements.into_iter().map(supplement).collect(),
        masks: has_masks,
    }
}

fn supplement(supplement: Supplement) -> v1::Supplement {
    v1::Supplement {
        kind: supplement.kind.to_string(),
        size_bytes: supplement.size_bytes,
        digest: supplement.digest.to_hex().to_string(),
        create_time: Some(time(supplement.created)),
    }
}

pub(crate) fn fit(mut fit: Job) -> v1::Fit {
    let labels = std::mem::take(&mut fit.labels);
    let owner = std::mem::take(&mut fit.owner);
    v1::Fit {
        owner,
        display_name: labels.display_name,
        note: labels.note,
        tags: labels.tags,
        error_m: fit.error_m,
        measure: fit.measure.map(|m| m.as_str().to_owned()).unwrap_or_default(),
        name: fit.id.to_string(),
        capture: fit.capture.to_string(),
        twin: fit.twin.map(|t| t.to_string()).unwrap_or_default(),
        priority: fit.priority,
        requirements: requirements(std::mem::take(&mut fit.requirements)),
        job: Some(job(fit)),
    }
}

fn requirements(of_job: Requirements) -> Option<v1::WorkerRequirements> {
    // The version follows from the settings, and `long` from attempts.
    let any = Requirements { long: false, ..of_job.clone() } == Requirements::default();
    let Requirements { backend, memory_bytes, labels, version: _, long: _ } = of_job;
    (!any).then_some(v1::WorkerRequirements { backend, memory_bytes, labels })
}

fn job(job: Job) -> v1::Job {
    v1::Job {
        state: state(job.state).into(),
        settings_json: job.settings,
        progress: job.progress.map(progress),
        fault: job.fault.as_ref().map(Into::into),
        attempt_faults: job.attempt_faults.iter().map(Into::into).collect(),
        attempts: job.attempts,
        worker: job.worker.map(|w| w.to_string()).unwrap_or_default(),
        cancel_requested: job.cancel_requested,
        create_time: Some(time(job.created)),
        start_time: job.started.map(time),
        end_time: job.ended.map(time),
        revision: job.revision,
        run_s: job.run.as_secs_f64(),
    }
}

/// The state that a list is filtered by; `None` without a filter.
pub(super) fn read_state(number: i32) -> Result<Option<State>> {
    use v1::job::State as Wire;
    let state =
        Wire::try_from(number).map_err(|_| Error::invalid("state", "is unknown to this server"))?;
    Ok(match state {
        Wire::Unspecified => None,
        Wire::Queued => Some(State::Queued),
        Wire::Running => Some(State::Running),
        Wire::Succeeded => Some(State::Succeeded),
        Wire::Failed => Some(State::Failed),
        Wire::Cancelled => Some(State::Cancelled),
    })
}

fn state(state: State) -> v1::job::State {
    match state {
        State::Queued => v1::job::State::Queued,
        State::Running => v1::job::State::Running,
        State::Succeeded => v1::job::State::Succeeded,
        State::Failed => v1::job::State::Failed,
        State::Cancelled => v1::job::State::Cancelled,
    }
}

fn progress(progress: Progress) -> v1::Progress {
    v1::Progress {
        stage: progress.stage.as_str().to_owned(),
        variant: progress.variant,
        iteration: progress.iteration,
        iterations: progress.iterations,
        fraction: progress.fraction,
        loss: progress.loss,
        best_loss: progress.best_loss,
        eta_s: progress.eta_s,
        note: progress.note.unwrap_or_default(),
        models: progress.models.into_iter().map(model_loss).collect(),
        error_m: progress.error_m,
    }
}

fn model_loss(loss: ModelLoss) -> v1::ModelLoss {
    v1::ModelLoss {
        stage: loss.stage.as_str().to_owned(),
        variant: loss.variant,
        iteration: loss.iteration,
        loss: loss.loss,
        best_loss: loss.best_loss,
        error_m: loss.error_m,
    }
}

/// Losses in their order as curves.
pub(super) fn losses(losses: Vec<ModelLoss>) -> v1::FitLosses {
    let mut curves: Vec<v1::fit_losses::LossCurve> = Vec::new();
    for loss in losses {
        let stage = loss.stage.as_str();
        let is_next = |c: &v1::fit_losses::LossCurve| c.stage == stage && c.variant == loss.variant;
        if !curves.last().is_some_and(is_next) {
            let (stage, variant) = (stage.to_owned(), loss.variant);
            curves.push(v1::fit_losses::LossCurve { stage, variant, ..Default::default() });
        }
        if let Some(curve) = curves.last_mut() {
            curve.iterations.push(loss.iteration);
            curve.losses.push(loss.loss.unwrap_or(f64::NAN));
            curve.best_losses.push(loss.best_loss.unwrap_or(f64::NAN));
            curve.errors_m.push(loss.error_m.unwrap_or(f64::NAN));
        }
    }
    v1::FitLosses { curves }
}

/// Progress as a worker reports it. Invalid numbers are left out.
pub(super) fn read_progress(message: v1::Progress) -> Result<Progress> {
    const LONGEST_NOTE: usize = 2000;
    // One for each start of each model.
    const MOST_MODELS: usize = 128;
    let stage = Stage::parse(&message.stage);
    let models = message.models.into_iter().take(MOST_MODELS).map(read_loss);
    Ok(Progress {
        stage: stage.ok_or_else(|| {
            Error::invalid("progress.stage", "must be one of ingest, search, refine, evaluate")
        })?,
        variant: short(&message.variant),
        iteration: message.iteration,
        iterations: message.iterations,
        fraction: if message.fraction.is_finite() { message.fraction.clamp(0.0, 1.0) } else { 0.0 },
        loss: finite(message.loss),
        best_loss: finite(message.best_loss),
        eta_s: finite(message.eta_s),
        note: Some(message.note)
            .filter(|n| !n.is_empty())
            .map(|n| n.chars().take(LONGEST_NOTE).collect()),
        models: models.collect::<Result<_>>()?,
        error_m: finite(message.error_m),
        preview: None,
    })
}

/// Losses as a worker reports them.
pub(super) fn read_losses(losses: Vec<v1::ModelLoss>) -> Result<Vec<ModelLoss>> {
    const MOST_LOSSES: usize = 1024;
    if losses.len() > MOST_LOSSES {
        return Err(Error::invalid("losses", format!("are more than {MOST_LOSSES}")));
    }
    losses.into_iter().map(read_loss).collect()
}

fn read_loss(message: v1::ModelLoss) -> Result<ModelLoss> {
    let has_losses = |s: &Stage| matches!(s, Stage::Search | Stage::Refine | Stage::Appearance);
    let stage = Stage::parse(&message.stage).filter(has_losses);
    Ok(ModelLoss {
        stage: stage.ok_or_else(|| Error::invalid("losses.stage", "is no stage with losses"))?,
        variant: short(&message.variant),
        iteration: message.iteration,
        loss: finite(message.loss),
        best_loss: finite(message.best_loss),
        error_m: finite(message.error_m),
    })
}

fn short(variant: &str) -> String {
    variant.chars().take(64).collect()
}

fn finite(number: Option<f64>) -> Option<f64> {
    number.filter(|x| x.is_finite())
}

pub(crate) fn twin(twin: Twin) -> v1::Twin {
    let (facts, labels) = (twin.facts, twin.labels);
    v1::Twin {
        name: twin.id.to_string(),
        display_name: labels.display_name,
        note: labels.note,
        tags: labels.tags,
        error_m: twin.error_m,
        owner: twin.owner,
        capture: twin.capture.map(|c| c.to_string()).unwrap_or_default(),
        fit: twin.fit.map(|f| f.to_string()).unwrap_or_default(),
        create_time: Some(time(twin.created)),
        size_bytes: twin.size_bytes,
        digest: twin.digest.to_hex().to_string(),
        node_count: facts.node_count,
        spring_count: facts.spring_count,
        triplet_count: facts.triplet_count,
        control_count: facts.control_count,
        fps: facts.fps,
        substeps: facts.substeps,
        quality_json: facts.quality,
        mass_kg: facts.mass_kg,
    }
}

pub(super) fn worker(view: WorkerView) -> v1::Worker {
    let said = view.worker.registration;
    v1::Worker {
        name: said.id.to_string(),
        backend: said.backend,
        device: said.device,
        start_time: Some(time(view.worker.started)),
        last_seen_time: Some(time(view.last_seen)),
        fit: view.fit.map(|f| f.to_string()).unwrap_or_default(),
        warm_twins: view.warm.iter().map(ToString::to_string).collect(),
        rollouts_in_flight: view.in_flight,
        build: said.build,
        memory_used_bytes: view.memory.unwrap_or_default().used,
        memory_total_bytes: view.memory.unwrap_or_default().total,
        labels: said.labels,
        ingest: view.ingest.map(|c| c.to_string()).unwrap_or_default(),
        draining: view.worker.is_draining,
        server: said.server.map(|s| s.to_string()).unwrap_or_default(),
    }
}

/// A time of a request.
pub(super) fn timestamp(time: prost_types::Timestamp) -> Result<Timestamp> {
    Timestamp::new(time.seconds, time.nanos)
        .map_err(|_| Error::invalid("expire_time", "is no time between the years -9999 and 9999"))
}

pub(super) fn quotas(quotas: v1::KeyQuotas) -> Quotas {
    let v1::KeyQuotas { queued_jobs, stored_bytes, rollouts, .. } = quotas;
    let v1::KeyQuotas { running_jobs, fit_run_s, priority, .. } = quotas;
    Quotas { queued_jobs, stored_bytes, rollouts, running_jobs, fit_run_s, priority }
}

fn quotas_message(quotas: Quotas) -> v1::KeyQuotas {
    let Quotas { queued_jobs, stored_bytes, rollouts, running_jobs, fit_run_s, priority } = quotas;
    v1::KeyQuotas { queued_jobs, stored_bytes, rollouts, running_jobs, fit_run_s, priority }
}

pub(super) fn usage(usage: OwnerUsage) -> v1::OwnerUsage {
    let StoredBytes { captures, derived, twins, checkpoints, uploads } = usage.stored;
    let total = usage.stored.total();
    v1::OwnerUsage {
        owner: usage.owner,
        captures: usage.captures,
        fits: usage.fits,
        twins: usage.twins,
        stored_bytes: Some(v1::StoredBytes {
            total,
            captures,
            derived,
            twins,
            checkpoints,
            uploads,
        }),
        queued_jobs: usage.queued_jobs,
        running_jobs: usage.running_jobs,
        quotas: Some(quotas_message(usage.quotas)),
    }
}

pub(super) fn key(key: Key) -> v1::Key {
    let is_admin = key.scopes.iter().any(|word| word == Scope::Admin.as_str());
    let priority = Some(access::most_priority(is_admin, key.quotas));
    let quotas = v1::KeyQuotas { priority, ..quotas_message(key.quotas) };
    v1::Key {
        name: key.id.to_string(),
        display_name: key.display_name,
        owner: key.owner,
        scopes: key.scopes,
        create_time: Some(time(key.created)),
        expire_time: key.expires.map(time),
        revoke_time: key.revoked.map(time),
        last_use_time: key.used.map(time),
        quotas: Some(quotas),
        is_sign_in: key.signed_in_as.is_some(),
        twin: key.share.map(|share| share.twin.to_string()).unwrap_or_default(),
    }
}

/// The share of a key.
pub(super) fn share(key: Key) -> v1::Share {
    v1::Share {
        name: access::share_of(key.id).to_string(),
        allow_export: access::may_export(&key),
        twin: key.share.map(|share| share.twin.to_string()).unwrap_or_default(),
        display_name: key.display_name,
        owner: key.owner,
        create_time: Some(time(key.created)),
        expire_time: key.expires.map(time),
        revoke_time: key.revoked.map(time),
        last_use_time: key.used.map(time),
    }
}

pub(super) fn project(project: Project) -> v1::Project {
    v1::Project {
        name: project.id.to_string(),
        display_name: project.display_name,
        members: project.members,
        create_time: Some(time(project.created)),
    }
}

pub(crate) fn trashed(trashed: Trashed) -> v1::TrashedResource {
    v1::TrashedResource {
        name: trashed.resource.to_string(),
        display_name: trashed.display_name,
        owner: trashed.owner,
        create_time: Some(time(trashed.created)),
        delete_time: Some(time(trashed.deleted)),
        purge_time: Some(time(trashed.purged)),
        deleted_by: trashed.deleted_by,
        size_bytes: trashed.size_bytes,
    }
}

/// A rule of the configuration.
pub(super) fn retention_conditions(conditions: NewRule) -> v1::RetentionRule {
    v1::RetentionRule {
        name: String::new(),
        display_name: conditions.display_name,
        collection: conditions.collection.name().to_owned(),
        min_age_days: conditions.min_age.as_secs_f64() / 86_400.0,
        owner: conditions.owner,
        tag: conditions.tag,
        verdict: conditions.verdict,
        create_time: None,
    }
}

pub(super) fn retention_rule(rule: Rule) -> v1::RetentionRule {
    let (name, create_time) = (rule.id.to_string(), Some(time(rule.created)));
    v1::RetentionRule { name, create_time, ..retention_conditions(rule.conditions) }
}

pub(super) fn retention_outcome(found: Match) -> v1::RetentionOutcome {
    v1::RetentionOutcome {
        name: found.resource.to_string(),
        display_name: found.display_name,
        owner: found.owner,
        create_time: Some(time(found.created)),
        size_bytes: found.size_bytes,
        rule: found.rule,
        kept_because: found.kept.map(|kept| kept.to_string()).unwrap_or_default(),
    }
}
