mod claims;
mod ingests;
mod lease_time;
mod model;
mod turns;

use std::time::Duration;

use bendtwin_core::{Category, Fault, Progress, Stage, ids::WorkerId};

use super::{AttemptEnd, Job, Kind, Lease, MAX_INTERRUPTED_ATTEMPTS, State, WorkerEnd};
use crate::{
    Error, NewFit, TwinFacts,
    database::testing::{On, on_both},
    store::tests::{Bench, LEASE, lease_of, new_fit},
};

on_both! {
    higher_priorities_first_then_the_oldest,
    creation_is_idempotent,
    racing_claimants_never_share_a_job,
    waiting_claimants_wake_when_a_job_comes,
    a_stale_lease_changes_nothing,
    three_attempts_without_progress_fail_the_job,
    a_checkpoint_is_progress_if_its_content_is_new,
    released_jobs_go_back_uncounted,
    interrupted_attempts_do_not_count_up_to_a_bound,
    a_checkpoint_whose_content_is_lost_is_forgotten,
    cancellation_reaches_every_state,
    every_change_has_a_higher_revision,
}

async fn claim(bench: &Bench) -> Option<Job> {
    bench.claim(Kind::Fit).await
}

fn progress(fraction: f64) -> Progress {
    Progress {
        stage: Stage::Search,
        variant: "bending".into(),
        iteration: 1,
        iterations: 10,
        fraction,
        loss: Some(0.5),
        best_loss: None,
        eta_s: None,
        note: None,
        models: Vec::new(),
        error_m: Some(0.01),
        preview: None,
    }
}

fn fault() -> Fault {
    Fault { category: Category::Internal, reason: "TEST".into(), message: "a test".into() }
}

async fn higher_priorities_first_then_the_oldest(on: On) {
    let bench = Bench::new(on).await;
    let capture = bench.capture("a").await;
    let mut ids = Vec::new();
    for priority in [0, 5, 0, 5, -1] {
        let new = NewFit { priority, ..new_fit(&capture) };
        ids.push(bench.store.jobs().create_fit(new).await.unwrap().id);
    }
    let mut claimed = Vec::new();
    while let Some(fit) = claim(&bench).await {
        claimed.push(fit.id);
    }
    assert_eq!(claimed, [ids[1], ids[3], ids[0], ids[2], ids[4]]);
}

async fn creation_is_idempotent(on: On) {
    let bench = Bench::new(on).await;
    let capture = bench.capture("a").await;
    let new = NewFit { request_id: Some("key".into()), ..new_fit(&capture) };
    let first = bench.store.jobs().create_fit(new.clone()).await.unwrap();
    assert_eq!(bench.store.jobs().create_fit(new.clone()).await.unwrap(), first);
    let other = bench.store.jobs().create_fit(NewFit { priority: 1, ..new }).await;
    assert!(matches!(other, Err(Error::RequestIdTaken { .. })));
}

async fn racing_claimants_never_share_a_job(on: On) {
    let bench = Bench::new(on).await;
    let capture = bench.capture("a").await;
    for _ in 0..20 {
        bench.store.jobs().create_fit(new_fit(&capture)).await.unwrap();
    }
    let claimants = (0..8).map(|_| {
        let store = bench.store.clone();
        tokio::spawn(async move {
            let mut mine = Vec::new();
            while let Some(fit) =
                store.jobs().claim(Kind::Fit, WorkerId::generate(), LEASE).await.unwrap()
            {
                mine.push(fit.id);
            }
            mine
        })
    });
    let mut all: Vec<_> =
        futures::future::join_all(claimants).await.into_iter().flat_map(Result::unwrap).collect();
    assert_eq!(all.len(), 20);
    all.sort();
    all.dedup();
    assert_eq!(all.len(), 20);
}

async fn waiting_claimants_wake_when_a_job_comes(on: On) {
    let bench = Bench::new(on).await;
    let capture = bench.capture("a").await;
    let store = bench.store.clone();
    let waiting = tokio::spawn(async move {
        let wait = Duration::from_secs(60);
        store.jobs().claim_within(Kind::Fit, WorkerId::generate(), LEASE, wait).await.unwrap()
    });
    tokio::task::yield_now().await;
    let fit = bench.store.jobs().create_fit(new_fit(&capture)).await.unwrap();
    assert_eq!(waiting.await.unwrap().unwrap().id, fit.id);
    let none = bench.store.jobs();
    let none =
        none.claim_within(Kind::Fit, WorkerId::generate(), LEASE, Duration::from_millis(1)).await;
    assert_eq!(none.unwrap(), None);
}

async fn a_stale_lease_changes_nothing(on: On) {
    let bench = Bench::new(on).await;
    let capture = bench.capture("a").await;
    bench.store.jobs().create_fit(new_fit(&capture)).await.unwrap();
    let old = lease_of(&claim(&bench).await.unwrap());
    assert!(bench.pass(LEASE).await.is_empty());
    bench.clock.advance(Duration::from_secs(1));
    // Expired but not swept: it still is the newest lease, so it writes.
    bench.store.jobs().report(old, Some(&progress(0.1)), LEASE).await.unwrap();
    assert!(bench.sweep().await.is_empty());
    assert_eq!(bench.pass(LEASE + Duration::from_secs(1)).await.len(), 1);
    let new = claim(&bench).await.unwrap();
    let before = bench.store.jobs().get(new.id).await.unwrap();

    let fits = bench.store.jobs();
    let stale = |r: Option<Error>| assert!(matches!(r, Some(Error::StaleLease { .. })));
    stale(fits.report(old, Some(&progress(0.9)), LEASE).await.err());
    stale(fits.save_checkpoint(old, bench.stage("late").await, LEASE).await.err());
    stale(fits.complete_fit(old, &TwinFacts::default(), bench.stage("late").await).await.err());
    stale(fits.end_attempt(old, AttemptEnd::Released).await.err());
    stale(fits.check_lease(old).await.err());
    // The epoch alone is no lease.
    let guessed = Lease { worker: WorkerId::generate(), ..lease_of(&new) };
    stale(fits.report(guessed, None, LEASE).await.err());
    stale(fits.save_checkpoint(guessed, bench.stage("late").await, LEASE).await.err());
    stale(fits.complete_fit(guessed, &TwinFacts::default(), bench.stage("late").await).await.err());
    stale(fits.end_attempt(guessed, AttemptEnd::Released).await.err());
    stale(fits.check_lease(guessed).await.err());
    fits.check_lease(lease_of(&new)).await.unwrap();
    assert_eq!(bench.store.jobs().get(new.id).await.unwrap(), before);
    assert_eq!(bench.blob_count().await, 1);
}

async fn three_attempts_without_progress_fail_the_job(on: On) {
    let bench = Bench::new(on).await;
    let capture = bench.capture("a").await;
    let fit = bench.store.jobs().create_fit(new_fit(&capture)).await.unwrap().id;
    let fail = async |progressed: Option<f64>| {
        let lease = lease_of(&claim(&bench).await.unwrap());
        if let Some(fraction) = progressed {
            bench.store.jobs().report(lease, Some(&progress(fraction)), LEASE).await.unwrap();
        }
        bench.store.jobs().end_attempt(lease, AttemptEnd::Failed(fault())).await.unwrap().state
    };
    assert_eq!(fail(None).await, State::Queued);
    assert_eq!(fail(None).await, State::Queued);
    assert_eq!(fail(Some(0.5)).await, State::Queued);
    // As far as before is no progress.
    assert_eq!(fail(Some(0.5)).await, State::Queued);
    assert_eq!(fail(Some(0.4)).await, State::Queued);
    assert_eq!(fail(None).await, State::Failed);
    let fit = bench.store.jobs().get(fit).await.unwrap();
    assert_eq!((fit.attempts, fit.attempt_faults.len()), (6, 5));
    assert_eq!(fit.fault, Some(fault()));
    assert!(claim(&bench).await.is_none());
}

async fn a_checkpoint_is_progress_if_its_content_is_new(on: On) {
    let bench = Bench::new(on).await;
    let capture = bench.capture("a").await;
    bench.store.jobs().create_fit(new_fit(&capture)).await.unwrap();
    let mut states = Vec::new();
    for content in ["one", "two", "two", "two", "two"] {
        let fit = claim(&bench).await.unwrap();
        let checkpoint = bench.stage(content).await;
        bench.store.jobs().save_checkpoint(lease_of(&fit), checkpoint, LEASE).await.unwrap();
        let lost = bench.store.jobs().forfeit(fit.worker.unwrap(), WorkerEnd::Lost).await.unwrap();
        states.push(lost[0].state);
    }
    use State::{Failed, Queued};
    assert_eq!(states, [Queued, Queued, Queued, Queued, Failed]);
}

async fn released_jobs_go_back_uncounted(on: On) {
    let bench = Bench::new(on).await;
    let capture = bench.capture("a").await;
    bench.store.jobs().create_fit(new_fit(&capture)).await.unwrap();
    for _ in 0..10 {
        let lease = lease_of(&claim(&bench).await.unwrap());
        let fit = bench.store.jobs().end_attempt(lease, AttemptEnd::Released).await.unwrap();
        assert_eq!((fit.state, fit.attempts), (State::Queued, 0));
    }
}

/// Rollouts that kill workers do not end a fit, but a fit that kills workers ends all the same.
async fn interrupted_attempts_do_not_count_up_to_a_bound(on: On) {
    let bench = Bench::new(on).await;
    let capture = bench.capture("a").await;
    let jobs = bench.store.jobs();
    jobs.create_fit(new_fit(&capture)).await.unwrap();
    let interrupt = async || {
        let worker = claim(&bench).await.unwrap().worker.unwrap();
        jobs.forfeit(worker, WorkerEnd::DuringRollout).await.unwrap().remove(0)
    };
    for _ in 0..MAX_INTERRUPTED_ATTEMPTS {
        let fit = interrupt().await;
        assert_eq!((fit.state, fit.attempts), (State::Queued, 0));
    }
    let states = [interrupt().await, interrupt().await].map(|fit| fit.state);
    assert_eq!(states, [State::Queued, State::Queued]);
    // Progress restarts the count.
    let lease = lease_of(&claim(&bench).await.unwrap());
    jobs.report(lease, Some(&progress(0.5)), LEASE).await.unwrap();
    jobs.end_attempt(lease, AttemptEnd::Released).await.unwrap();
    for _ in 0..MAX_INTERRUPTED_ATTEMPTS + 2 {
        assert_eq!(interrupt().await.state, State::Queued);
    }
    let failed = interrupt().await;
    assert_eq!(
        (failed.state, failed.fault.unwrap().reason.as_str()),
        (State::Failed, "WORKER_LOST")
    );
}

/// A lost checkpoint costs the work that it held, not the job.
async fn a_checkpoint_whose_content_is_lost_is_forgotten(on: On) {
    let bench = Bench::new(on).await;
    let capture = bench.capture("a").await;
    let jobs = bench.store.jobs();
    jobs.create_fit(new_fit(&capture)).await.unwrap();
    let fit = claim(&bench).await.unwrap();
    jobs.save_checkpoint(lease_of(&fit), bench.stage("half way").await, LEASE).await.unwrap();
    let digest = jobs.get(fit.id).await.unwrap().checkpoint.unwrap();
    bench.store.blobs().delete(&digest.to_hex()).await.unwrap();
    assert!(matches!(jobs.checkpoint(fit.id).await, Err(Error::ContentLost { .. })));
    assert_eq!(jobs.get(fit.id).await.unwrap().checkpoint, None);
    assert!(matches!(jobs.checkpoint(fit.id).await, Err(Error::NotFound { .. })));
    jobs.save_checkpoint(lease_of(&fit), bench.stage("half way").await, LEASE).await.unwrap();
    jobs.checkpoint(fit.id).await.unwrap();
}

async fn cancellation_reaches_every_state(on: On) {
    let bench = Bench::new(on).await;
    let capture = bench.capture("a").await;
    let fits = bench.store.jobs();
    let queued = fits.create_fit(new_fit(&capture)).await.unwrap().id;
    assert_eq!(fits.cancel(queued).await.unwrap().state, State::Cancelled);

    fits.create_fit(new_fit(&capture)).await.unwrap();
    let running = claim(&bench).await.unwrap();
    let asked = fits.cancel(running.id).await.unwrap();
    assert!(asked.state == State::Running && asked.cancel_requested);
    assert!(matches!(fits.delete(running.id.fit().unwrap()).await, Err(Error::FitRunning { .. })));
    let lease = lease_of(&running);
    assert!(fits.report(lease, None, LEASE).await.unwrap().cancel_requested);
    let ended = fits.end_attempt(lease, AttemptEnd::Cancelled).await.unwrap();
    assert_eq!(ended.state, State::Cancelled);
    assert_eq!(fits.cancel(running.id).await.unwrap(), ended);

    // A worker that dies while it is asked to stop has stopped.
    fits.create_fit(new_fit(&capture)).await.unwrap();
    let dying = claim(&bench).await.unwrap();
    fits.cancel(dying.id).await.unwrap();
    assert_eq!(bench.pass(LEASE * 2).await[0].state, State::Cancelled);
    fits.delete(dying.id.fit().unwrap()).await.unwrap();
}

async fn every_change_has_a_higher_revision(on: On) {
    let bench = Bench::new(on).await;
    let capture = bench.capture("a").await;
    let mut changes = bench.store.jobs().changes();
    let id = bench.store.jobs().create_fit(new_fit(&capture)).await.unwrap().id;
    let lease = lease_of(&claim(&bench).await.unwrap());
    bench.store.jobs().report(lease, Some(&progress(0.1)), LEASE).await.unwrap();
    let twin = bench.stage("twin").await;
    bench.store.jobs().complete_fit(lease, &TwinFacts::default(), twin).await.unwrap();
    for _ in 0..4 {
        assert_eq!(changes.try_recv().unwrap(), id);
    }
    assert_eq!(bench.store.jobs().get(id).await.unwrap().revision, 4);
}
