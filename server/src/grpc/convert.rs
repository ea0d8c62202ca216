//! Rows of the store as messages.

use bendtwin_core::{Progress, Stage};
use bendtwin_proto::v1;
use bendtwin_store::{Job, Overview, PageRequest, State, Twin};
use jiff::Timestamp;

use crate::{
    app::{Error, Result},
    dispatch::WorkerView,
};

pub(super) fn time(time: Timestamp) -> prost_types::Timestamp {
    // Whole nanoseconds since the epoch, split so that nanos are never negative.
    let nanos = time.as_nanosecond();
    const SECOND: i128 = 1_000_000_000;
    prost_types::Timestamp {
        seconds: i64::try_from(nanos.div_euclid(SECOND)).unwrap_or_default(),
        nanos: i32::try_from(nanos.rem_euclid(SECOND)).unwrap_or_default(),
    }
}

pub(super) fn page(size: u32, token: String) -> PageRequest {
    PageRequest { size, token }
}

pub(super) fn capture(overview: Overview) -> v1::Capture {
    let Overview { capture, ingest, report } = overview;
    v1::Capture {
        name: capture.id.to_string(),
        display_name: capture.display_name,
        create_time: Some(time(capture.created)),
        size_bytes: capture.size_bytes,
        digest: capture.digest.to_hex().to_string(),
        ingest: Some(job(ingest)),
        verdict: report.map(|r| r.verdict).unwrap_or_default(),
    }
}

pub(super) fn fit(fit: Job) -> v1::Fit {
    v1::Fit {
        name: fit.id.to_string(),
        capture: fit.capture.to_string(),
        twin: fit.twin.map(|t| t.to_string()).unwrap_or_default(),
        priority: fit.priority,
        job: Some(job(fit)),
    }
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
    }
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

const STAGES: [(Stage, &str); 4] = [
    (Stage::Ingest, "ingest"),
    (Stage::Search, "search"),
    (Stage::Refine, "refine"),
    (Stage::Evaluate, "evaluate"),
];

fn progress(progress: Progress) -> v1::Progress {
    let stage = STAGES.iter().find(|(s, _)| *s == progress.stage).map_or("", |(_, name)| name);
    v1::Progress {
        stage: stage.to_owned(),
        variant: progress.variant,
        iteration: progress.iteration,
        iterations: progress.iterations,
        fraction: progress.fraction,
        loss: progress.loss,
        best_loss: progress.best_loss,
        eta_s: progress.eta_s,
        note: progress.note.unwrap_or_default(),
    }
}

/// Progress as a worker reports it. Numbers that are none are left out.
pub(super) fn read_progress(message: v1::Progress) -> Result<Progress> {
    const LONGEST_NOTE: usize = 2000;
    let stage = STAGES.iter().find(|(_, name)| *name == message.stage).map(|(s, _)| *s);
    let finite = |x: Option<f64>| x.filter(|x| x.is_finite());
    Ok(Progress {
        stage: stage.ok_or_else(|| {
            Error::invalid("progress.stage", "is none of ingest, search, refine, evaluate")
        })?,
        variant: message.variant.chars().take(64).collect(),
        iteration: message.iteration,
        iterations: message.iterations,
        fraction: if message.fraction.is_finite() { message.fraction.clamp(0.0, 1.0) } else { 0.0 },
        loss: finite(message.loss),
        best_loss: finite(message.best_loss),
        eta_s: finite(message.eta_s),
        note: Some(message.note)
            .filter(|n| !n.is_empty())
            .map(|n| n.chars().take(LONGEST_NOTE).collect()),
    })
}

pub(super) fn twin(twin: Twin) -> v1::Twin {
    let facts = twin.facts;
    v1::Twin {
        name: twin.id.to_string(),
        display_name: twin.display_name,
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
        ingest: view.ingest.map(|c| c.to_string()).unwrap_or_default(),
    }
}
