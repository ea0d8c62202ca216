//! Running fits that make way for those of other owners, bounds on running jobs, and times of jobs.

use super::*;
use crate::{
    Capture, Claimant, Creator, JobReport, NewFit, Quotas, Reported, Requirements, Turns, sql,
    store::tests::new_fit,
};

on_both! {
    a_fit_makes_way_for_an_owner_that_has_none_running,
    a_fit_that_has_run_before_is_made_way_for_after_a_longer_slice,
    a_fit_without_a_checkpoint_gets_twice_the_time_each_time,
    no_more_fits_make_way_than_owners_wait,
    nothing_makes_way_for_a_fit_that_the_worker_would_not_get,
    an_owner_that_made_way_was_served_last,
    an_owner_has_no_more_running_jobs_than_its_key_allows,
    a_waiting_claimant_wakes_when_an_owner_comes_below_its_bound,
    running_time_is_that_of_all_attempts,
    a_job_is_idle_while_neither_progress_nor_checkpoint_changes,
}

const SLICE: Duration = Duration::from_secs(4);

async fn queue(bench: &Bench, capture: &Capture, owner: &str, change: impl Fn(&mut NewFit)) -> Job {
    bench.clock.advance(Duration::from_micros(1));
    let creator = Creator { owner: owner.to_owned(), quotas: Quotas::default() };
    let mut new = NewFit { creator, ..new_fit(capture) };
    change(&mut new);
    bench.store.jobs().create_fit(new).await.unwrap()
}

/// The answer to a report of the worker that has this lease.
async fn report(bench: &Bench, lease: Lease) -> Reported {
    let claimant = Claimant::from(lease.worker);
    let turns = Some(Turns { claimant: &claimant, slice: SLICE });
    let report = JobReport { turns, ..JobReport::default() };
    bench.store.jobs().report(lease, report, LEASE).await.unwrap()
}

/// The time within which the job is to make way, after some time.
async fn way_after(bench: &Bench, lease: Lease, time: Duration) -> Option<Duration> {
    assert!(bench.pass(time).await.is_empty());
    report(bench, lease).await.make_way_within
}

async fn release(bench: &Bench, lease: Lease) -> Job {
    bench.store.jobs().end_attempt(lease, AttemptEnd::Released).await.unwrap()
}

async fn end(bench: &Bench, lease: Lease) {
    let end = AttemptEnd::FailedForGood(fault());
    bench.store.jobs().end_attempt(lease, end).await.unwrap();
}

async fn claim_lease(bench: &Bench) -> Lease {
    lease_of(&claim(bench).await.unwrap())
}

async fn a_fit_makes_way_for_an_owner_that_has_none_running(on: On) {
    let bench = Bench::new(on).await;
    let capture = bench.capture("a").await;
    let jobs = bench.store.jobs();
    let long = queue(&bench, &capture, "ada", |_| ()).await;
    queue(&bench, &capture, "ada", |_| ()).await;
    let lease = claim_lease(&bench).await;
    assert_eq!(lease.job, long.id);
    report(&bench, lease).await;
    // Not for her own, and not for one of lower priority.
    assert_eq!(way_after(&bench, lease, 2 * SLICE).await, None);
    queue(&bench, &capture, "bob", |new| new.priority = -1).await;
    assert_eq!(way_after(&bench, lease, SLICE).await, None);
    let equal = queue(&bench, &capture, "bob", |_| ()).await;
    assert_eq!(way_after(&bench, lease, Duration::ZERO).await, Some(SLICE));
    let second = Duration::from_secs(1);
    assert_eq!(way_after(&bench, lease, second).await, Some(SLICE - second));
    // Who waits no more is not made way for.
    jobs.cancel(equal.id).await.unwrap();
    assert_eq!(way_after(&bench, lease, second).await, None);
    let equal = queue(&bench, &capture, "bob", |_| ()).await;
    assert_eq!(way_after(&bench, lease, second).await, Some(SLICE));
    assert_eq!(way_after(&bench, lease, 2 * SLICE).await, Some(Duration::ZERO));

    jobs.save_checkpoint(lease, bench.stage("half way").await, LEASE).await.unwrap();
    let released = release(&bench, lease).await;
    assert_eq!((released.state, released.attempts), (State::Queued, 0));
    let next = claim(&bench).await.unwrap();
    assert_eq!(next.id, equal.id);
    // It has a slice as well, and hers has run before: she waits.
    report(&bench, lease_of(&next)).await;
    assert_eq!(way_after(&bench, lease_of(&next), SLICE).await, None);
    end(&bench, lease_of(&next)).await;
    let again = claim(&bench).await.unwrap();
    assert_eq!((again.id, again.attempts, again.checkpoint.is_some()), (long.id, 1, true));
}

async fn a_fit_that_has_run_before_is_made_way_for_after_a_longer_slice(on: On) {
    let bench = Bench::new(on).await;
    let capture = bench.capture("a").await;
    queue(&bench, &capture, "ada", |_| ()).await;
    let first = claim_lease(&bench).await;
    release(&bench, first).await;
    queue(&bench, &capture, "bob", |_| ()).await;
    let second = claim(&bench).await.unwrap();
    assert_eq!(second.owner, "bob");
    let lease = lease_of(&second);
    report(&bench, lease).await;
    for slices in 1..15 {
        assert_eq!(way_after(&bench, lease, SLICE).await, None, "{slices}");
    }
    assert_eq!(way_after(&bench, lease, SLICE).await, Some(SLICE));
}

async fn a_fit_without_a_checkpoint_gets_twice_the_time_each_time(on: On) {
    let bench = Bench::new(on).await;
    let capture = bench.capture("a").await;
    let long = queue(&bench, &capture, "ada", |_| ()).await;
    let cut = async || {
        let lease = claim_lease(&bench).await;
        assert_eq!(lease.job, long.id);
        report(&bench, lease).await;
        let other = queue(&bench, &capture, "bob", |_| ()).await;
        let within = way_after(&bench, lease, SLICE).await;
        (lease, other, within)
    };
    for slices in [1, 2, 4] {
        let (lease, other, within) = cut().await;
        assert_eq!(within, Some(slices * SLICE));
        release(&bench, lease).await;
        bench.store.jobs().cancel(other.id).await.unwrap();
    }
    // The end of the worker is no reason for more, a checkpoint one for less.
    let lease = claim_lease(&bench).await;
    release(&bench, lease).await;
    let (lease, other, within) = cut().await;
    assert_eq!(within, Some(8 * SLICE));
    let checkpoint = bench.stage("half way").await;
    bench.store.jobs().save_checkpoint(lease, checkpoint, LEASE).await.unwrap();
    release(&bench, lease).await;
    bench.store.jobs().cancel(other.id).await.unwrap();
    assert_eq!(cut().await.2, Some(SLICE));
}

async fn no_more_fits_make_way_than_owners_wait(on: On) {
    let bench = Bench::new(on).await;
    let capture = bench.capture("a").await;
    let mut leases = Vec::new();
    for _ in 0..3 {
        queue(&bench, &capture, "ada", |_| ()).await;
        leases.push(claim_lease(&bench).await);
        report(&bench, *leases.last().unwrap()).await;
    }
    bench.pass(SLICE).await;
    let asked = async || {
        let mut asked = Vec::new();
        for lease in &leases {
            asked.push(report(&bench, *lease).await.make_way_within.is_some());
        }
        asked
    };
    assert_eq!(asked().await, [false, false, false]);
    queue(&bench, &capture, "bob", |_| ()).await;
    queue(&bench, &capture, "bob", |_| ()).await;
    assert_eq!(asked().await, [true, false, false]);
    queue(&bench, &capture, "eve", |_| ()).await;
    assert_eq!(asked().await, [true, true, false]);
    // Those that were asked and do not answer count no longer.
    for _ in 0..4 {
        bench.pass(SLICE).await;
        report(&bench, leases[0]).await;
        report(&bench, leases[1]).await;
    }
    assert!(report(&bench, leases[2]).await.make_way_within.is_some());
}

async fn nothing_makes_way_for_a_fit_that_the_worker_would_not_get(on: On) {
    let bench = Bench::new(on).await;
    let capture = bench.capture("a").await;
    queue(&bench, &capture, "ada", |_| ()).await;
    let lease = claim_lease(&bench).await;
    report(&bench, lease).await;
    bench.pass(SLICE).await;
    let cuda = Requirements { backend: "cuda".into(), ..Requirements::default() };
    queue(&bench, &capture, "bob", |new| new.requirements = cuda.clone()).await;
    assert_eq!(report(&bench, lease).await.make_way_within, None);
    // Its capture has not been read, which the owner's only running job is about to do.
    let unread = bench.fresh_capture("b").await;
    queue(&bench, &unread, "eve", |_| ()).await;
    assert_eq!(report(&bench, lease).await.make_way_within, None);
    let owned = "update jobs set owner = 'eve' where kind = 'ingest' and state = 'queued'";
    bench.tell(sql::query(owned)).await;
    let ingest = lease_of(&bench.claim(Kind::Ingest).await.unwrap());
    queue(&bench, &capture, "eve", |new| new.creator.quotas.running_jobs = Some(1)).await;
    assert_eq!(report(&bench, lease).await.make_way_within, None);
    release(&bench, ingest).await;
    assert_eq!(report(&bench, lease).await.make_way_within, Some(SLICE));
}

/// Else it would be served again before others that were served while it ran.
async fn an_owner_that_made_way_was_served_last(on: On) {
    let bench = Bench::new(on).await;
    let capture = bench.capture("a").await;
    queue(&bench, &capture, "ada", |_| ()).await;
    let long = claim_lease(&bench).await;
    report(&bench, long).await;
    bench.pass(SLICE).await;
    queue(&bench, &capture, "bob", |_| ()).await;
    let short = claim_lease(&bench).await;
    end(&bench, short).await;
    bench.pass(SLICE).await;
    let waiting = queue(&bench, &capture, "bob", |_| ()).await;
    assert_eq!(report(&bench, long).await.make_way_within, Some(SLICE));
    release(&bench, long).await;
    assert_eq!(claim(&bench).await.unwrap().id, waiting.id);
}

async fn an_owner_has_no_more_running_jobs_than_its_key_allows(on: On) {
    let bench = Bench::new(on).await;
    let capture = bench.capture("a").await;
    let bounded = |new: &mut NewFit| new.creator.quotas.running_jobs = Some(2);
    for _ in 0..4 {
        queue(&bench, &capture, "ada", bounded).await;
    }
    queue(&bench, &capture, "bob", |_| ()).await;
    queue(&bench, &capture, "bob", |_| ()).await;
    let mut owners = Vec::new();
    let mut leases = Vec::new();
    while let Some(fit) = claim(&bench).await {
        leases.push(lease_of(&fit));
        owners.push(fit.owner);
    }
    assert_eq!(owners, ["ada", "bob", "ada", "bob"]);
    end(&bench, leases[1]).await;
    assert!(claim(&bench).await.is_none());
    end(&bench, leases[0]).await;
    assert_eq!(claim(&bench).await.unwrap().owner, "ada");
    assert!(claim(&bench).await.is_none());
}

async fn a_waiting_claimant_wakes_when_an_owner_comes_below_its_bound(on: On) {
    let bench = Bench::new(on).await;
    let capture = bench.capture("a").await;
    for _ in 0..2 {
        queue(&bench, &capture, "ada", |new| new.creator.quotas.running_jobs = Some(1)).await;
    }
    let lease = claim_lease(&bench).await;
    let store = bench.store.clone();
    let waiting = tokio::spawn(async move {
        let wait = Duration::from_secs(60);
        store.jobs().claim_within(Kind::Fit, WorkerId::generate(), LEASE, wait).await.unwrap()
    });
    tokio::task::yield_now().await;
    end(&bench, lease).await;
    let woken = tokio::time::timeout(Duration::from_secs(5), waiting).await;
    assert!(woken.expect("it slept").unwrap().is_some());
}

async fn running_time_is_that_of_all_attempts(on: On) {
    let bench = Bench::new(on).await;
    let capture = bench.capture("a").await;
    let jobs = bench.store.jobs();
    let most = |new: &mut NewFit| new.creator.quotas.fit_run_s = Some(100);
    let fit = queue(&bench, &capture, "ada", most).await;
    let seconds = Duration::from_secs;
    let lease = claim_lease(&bench).await;
    bench.pass(seconds(5)).await;
    assert_eq!(report(&bench, lease).await.times.run, seconds(5));
    // A checkpoint counts as well.
    bench.pass(seconds(2)).await;
    jobs.save_checkpoint(lease, bench.stage("half way").await, LEASE).await.unwrap();
    bench.pass(seconds(1)).await;
    jobs.report(lease, Some(&progress(0.5)), LEASE).await.unwrap();
    assert_eq!(jobs.get(fit.id).await.unwrap().run, seconds(8));
    release(&bench, lease).await;
    // Neither the queue nor a clock that is set counts, and a standstill hardly.
    bench.pass(seconds(9)).await;
    let lease = claim_lease(&bench).await;
    bench.clock.set(86_400_000_000);
    bench.pass(seconds(3)).await;
    assert_eq!(report(&bench, lease).await.times.run, seconds(11));
    bench.sweep().await;
    bench.clock.advance(seconds(1000));
    let times = report(&bench, lease).await.times;
    assert!(times.run <= seconds(13), "{times:?}");
    assert_eq!(times.most_run, Some(seconds(100)));
}

async fn a_job_is_idle_while_neither_progress_nor_checkpoint_changes(on: On) {
    let bench = Bench::new(on).await;
    let capture = bench.capture("a").await;
    let jobs = bench.store.jobs();
    queue(&bench, &capture, "ada", |_| ()).await;
    let lease = claim_lease(&bench).await;
    let second = Duration::from_secs(1);
    let idle_after = async |fraction: f64| {
        bench.pass(second).await;
        jobs.report(lease, Some(&progress(fraction)), LEASE).await.unwrap().times.idle
    };
    assert_eq!(idle_after(0.1).await, Duration::ZERO);
    assert_eq!(idle_after(0.1).await, second);
    assert_eq!(idle_after(0.1).await, 2 * second);
    // A change is enough: a later attempt may be behind an earlier one.
    assert_eq!(idle_after(0.05).await, Duration::ZERO);
    assert_eq!(idle_after(0.05).await, second);
    for (content, idle) in [("new", second), ("new", 2 * second)] {
        jobs.save_checkpoint(lease, bench.stage(content).await, LEASE).await.unwrap();
        assert_eq!(idle_after(0.05).await, idle);
    }
    release(&bench, lease).await;
    let lease = claim_lease(&bench).await;
    assert_eq!(report(&bench, lease).await.times.idle, Duration::ZERO);
}

/// Index searches alone: no step of the question reads all jobs.
#[tokio::test]
async fn the_question_who_waits_reads_indexes() {
    let bench = Bench::new(On::Sqlite).await;
    let waiting = crate::jobs::waiting_statement("ada", 0, true, &[String::new()]);
    let steps: Vec<(i64, i64, i64, String)> = waiting
        .explained("explain query plan")
        .fetch_all(bench.store.inner.database.read())
        .await
        .unwrap();
    let plan: String = steps.into_iter().map(|(.., step)| step + "\n").collect();
    assert!(!plan.contains("SCAN jobs") && !plan.contains("SCAN j\n"), "{plan}");
    assert!(plan.contains("j USING INDEX jobs_by_queue"), "{plan}");
    assert!(plan.contains("r USING COVERING INDEX jobs_running_by_owner"), "{plan}");
}
