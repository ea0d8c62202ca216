//! The queue against a model of it: random claims, reports, failures, releases, cancellations and
//! losses of workers, of the fits of several owners, while time passes, the process stands still and the
//! clock of the day is set.

use std::{collections::BTreeMap, time::Duration};

use jiff::Timestamp;
use proptest::prelude::*;

use super::{fault, progress};
use crate::{
    Claimant, Creator, JobReport, Kind, Lease, NewFit, Quotas, Turns,
    database::testing::On,
    jobs::{AttemptEnd, State, WorkerEnd},
    store::{
        clock::micros,
        tests::{Bench, LEASE, TERMS, new_fit},
    },
};
use bendtwin_core::ids::WorkerId;

const OWNERS: [&str; 3] = ["", "ada", "bob"];
/// Running jobs that an owner may have.
const MOST_RUNNING: usize = 3;
const SLICE: Duration = Duration::from_secs(2);

#[derive(Clone, Debug)]
enum Step {
    Create {
        priority: i32,
        owner: usize,
    },
    Claim,
    /// Reports with the n-th lease ever given, stale or not.
    Report {
        lease: usize,
        fraction: f64,
    },
    End {
        lease: usize,
        how: u8,
    },
    Cancel {
        job: usize,
    },
    /// The worker of the n-th lease ever given is gone.
    Lose {
        lease: usize,
        loss: WorkerEnd,
    },
    /// Time passes in a process that runs.
    Pass {
        seconds: u64,
    },
    /// The process stands still.
    Freeze {
        seconds: u64,
    },
    /// The clock of the day is set forward or back.
    SetClock {
        hours: i64,
    },
}

fn steps() -> impl Strategy<Value = Vec<Step>> {
    let step = prop_oneof![
        4 => (-1..2, 0..OWNERS.len()).prop_map(|(priority, owner)| Step::Create { priority, owner }),
        4 => Just(Step::Claim),
        3 => (0..8usize, 0.0..1.0f64)
            .prop_map(|(lease, fraction)| Step::Report { lease, fraction }),
        3 => (0..8usize, 0..4u8).prop_map(|(lease, how)| Step::End { lease, how }),
        1 => (0..6usize).prop_map(|job| Step::Cancel { job }),
        1 => (0..8usize, prop_oneof![Just(WorkerEnd::Lost), Just(WorkerEnd::DuringRollout), Just(WorkerEnd::ByServer)])
            .prop_map(|(lease, loss)| Step::Lose { lease, loss }),
        3 => (1..40u64).prop_map(|seconds| Step::Pass { seconds }),
        1 => (1..100_000u64).prop_map(|seconds| Step::Freeze { seconds }),
        1 => (-48..48i64).prop_map(|hours| Step::SetClock { hours }),
    ];
    proptest::collection::vec(step, 1..60)
}

#[derive(Clone, Debug)]
struct Job {
    state: State,
    priority: i32,
    /// Time of day, which may be set.
    created: Timestamp,
    epoch: u64,
    stalled: u32,
    furthest: f64,
    cancelling: bool,
    /// End of the lease by the time that counts.
    until: Duration,
    owner: usize,
    started: bool,
    /// Time of day of the last claim, or of the end of an attempt that made way [us].
    served: Option<i64>,
    /// Time of the last renewal, by the time that counts.
    renewed: Duration,
    run: Duration,
    slice: Duration,
    /// The slice at which it was asked to make way.
    asked: Option<Duration>,
}

/// The queued job of an owner that is next.
fn head(model: &[Job], owner: usize) -> Option<usize> {
    let own = model.iter().enumerate().filter(|(_, j)| j.owner == owner);
    let queued = own.filter(|(_, j)| j.state == State::Queued);
    queued.min_by_key(|(_, j)| (-j.priority, j.created)).map(|(i, _)| i)
}

fn running(model: &[Job], owner: usize) -> usize {
    model.iter().filter(|j| j.owner == owner && j.state == State::Running).count()
}

/// The job that a claim takes.
fn next(model: &[Job]) -> Option<usize> {
    let served = |owner| model.iter().filter(|j| j.owner == owner).filter_map(|j| j.served).max();
    let of = |owner| {
        let head = head(model, owner).filter(|_| running(model, owner) < MOST_RUNNING)?;
        let turn = (running(model, owner), served(owner).unwrap_or(0));
        Some((-model[head].priority, turn, model[head].created, head))
    };
    (0..OWNERS.len()).filter_map(of).min().map(|(.., head)| head)
}

/// True if a running job is to make way.
fn makes_way(model: &[Job], job: &Job) -> bool {
    if job.slice < SLICE {
        return false;
    }
    let is_long = job.slice >= 15 * SLICE;
    let waits = |owner: usize| {
        let head = head(model, owner).map(|head| &model[head]);
        let counts = |h: &Job| h.priority >= job.priority && (!h.started || is_long);
        owner != job.owner && running(model, owner) == 0 && head.is_some_and(counts)
    };
    let waiting = (0..OWNERS.len()).filter(|owner| waits(*owner)).count();
    let asked = |j: &&Job| {
        let is_soon = |asked: Duration| j.slice.saturating_sub(asked) < 3 * SLICE;
        j.state == State::Running && j.asked.is_some_and(is_soon)
    };
    let others = if job.asked.is_some() { 0 } else { model.iter().filter(asked).count() };
    waiting > others
}

/// The time that counts for leases: whole while the process runs, at most a step of a standstill.
#[derive(Default)]
struct Time {
    passed: Duration,
    since_sweep: Duration,
}

impl Time {
    fn now(&self) -> Duration {
        self.passed + self.since_sweep.min(TERMS.step)
    }

    fn sweep(&mut self, model: &mut [Job]) {
        *self = Self { passed: self.now(), since_sweep: Duration::ZERO };
        let running = model.iter_mut().filter(|j| j.state == State::Running);
        running.filter(|j| j.until < self.passed).for_each(Job::lost);
    }
}

impl Job {
    fn lost(&mut self) {
        self.asked = None;
        self.state = match () {
            () if self.cancelling => State::Cancelled,
            () if self.stalled >= 3 => State::Failed,
            () => State::Queued,
        };
    }

    /// Handed back at this time of day [us].
    fn released(&mut self, now: i64) {
        if self.asked.take().is_some() {
            self.served = Some(now);
        }
        self.stalled = self.stalled.saturating_sub(1);
        self.state = if self.cancelling { State::Cancelled } else { State::Queued };
    }
}

async fn run(on: On, steps: Vec<Step>) {
    let bench = Bench::new(on).await;
    let capture = bench.capture("a").await;
    let fits = bench.store.jobs();
    let mut model: Vec<Job> = Vec::new();
    let mut ids = Vec::new();
    let mut leases: Vec<(usize, Lease)> = Vec::new();
    let mut time = Time::default();
    bench.sweep().await;
    for step in steps {
        match step {
            Step::Create { priority, owner } => {
                bench.clock.advance(Duration::from_micros(1));
                time.since_sweep += Duration::from_micros(1);
                let running_jobs = Some(MOST_RUNNING as u64);
                let quotas = Quotas { running_jobs, ..Quotas::default() };
                let creator = Creator { owner: OWNERS[owner].to_owned(), quotas };
                let new = NewFit { priority, creator, ..new_fit(&capture) };
                ids.push(fits.create_fit(new).await.unwrap().id);
                let state = State::Queued;
                let (furthest, until) = (0.0, Duration::ZERO);
                let (epoch, stalled, cancelling) = (0, 0, false);
                let created = bench.store.now();
                model.push(Job {
                    state,
                    priority,
                    created,
                    epoch,
                    stalled,
                    furthest,
                    cancelling,
                    until,
                    owner,
                    started: false,
                    served: None,
                    renewed: Duration::ZERO,
                    run: Duration::ZERO,
                    slice: Duration::ZERO,
                    asked: None,
                });
            }
            Step::Claim => {
                let next = next(&model);
                let got = fits.claim(Kind::Fit, WorkerId::generate(), LEASE).await.unwrap();
                assert_eq!(got.as_ref().map(|f| f.id), next.map(|i| ids[i]));
                if let (Some(fit), Some(i)) = (got, next) {
                    model[i].state = State::Running;
                    model[i].epoch += 1;
                    model[i].stalled += 1;
                    model[i].until = time.now() + LEASE;
                    model[i].renewed = time.now();
                    model[i].started = true;
                    model[i].served = Some(micros(bench.store.now()));
                    model[i].slice = Duration::ZERO;
                    leases.push((i, fit.lease().unwrap()));
                }
            }
            Step::Report { lease, fraction } => {
                let Some(&(i, lease)) = leases.get(lease) else { continue };
                let live = model[i].state == State::Running && model[i].epoch == lease.epoch;
                let claimant = Claimant::from(lease.worker);
                let turns = Some(Turns { claimant: &claimant, slice: SLICE });
                let said = progress(fraction);
                let report = JobReport { progress: Some(&said), turns, ..JobReport::default() };
                let done = fits.report(lease, report, LEASE).await;
                assert_eq!(done.is_ok(), live);
                if let Ok(reported) = done {
                    let job = &mut model[i];
                    let passed = (time.now() - job.renewed).min(LEASE);
                    (job.run, job.slice) = (job.run + passed, job.slice + passed);
                    (job.until, job.renewed) = (time.now() + LEASE, time.now());
                    let makes_way = makes_way(&model, &model[i]);
                    assert_eq!(reported.make_way_within.is_some(), makes_way);
                    assert_eq!(reported.times.run, model[i].run);
                    let asked = model[i].asked.unwrap_or(model[i].slice);
                    model[i].asked = makes_way.then_some(asked);
                }
                let job = &mut model[i];
                if live && fraction > job.furthest {
                    (job.furthest, job.stalled) = (fraction, 0);
                }
            }
            Step::End { lease, how } => {
                let Some(&(i, lease)) = leases.get(lease) else { continue };
                let job = &mut model[i];
                let live = job.state == State::Running && job.epoch == lease.epoch;
                let end = match how {
                    0 => AttemptEnd::Failed(fault()),
                    1 => AttemptEnd::FailedForGood(fault()),
                    2 => AttemptEnd::Cancelled,
                    _ => AttemptEnd::Released,
                };
                assert_eq!(fits.end_attempt(lease, end).await.is_ok(), live);
                match how {
                    _ if !live => {}
                    0 => job.lost(),
                    1 => (job.state, job.asked) = (State::Failed, None),
                    2 => (job.state, job.asked) = (State::Cancelled, None),
                    _ => job.released(micros(bench.store.now())),
                }
            }
            Step::Cancel { job } => {
                let Some(&id) = ids.get(job) else { continue };
                fits.cancel(id).await.unwrap();
                match model[job].state {
                    State::Queued => model[job].state = State::Cancelled,
                    State::Running => model[job].cancelling = true,
                    _ => {}
                }
            }
            Step::Lose { lease, loss } => {
                let Some(&(i, lease)) = leases.get(lease) else { continue };
                let job = &mut model[i];
                let live = job.state == State::Running && job.epoch == lease.epoch;
                let ended = fits.forfeit(lease.worker, loss).await.unwrap();
                assert_eq!(ended.len(), usize::from(live));
                match loss {
                    _ if !live => {}
                    WorkerEnd::Lost => job.lost(),
                    WorkerEnd::DuringRollout => {
                        job.asked = None;
                        job.released(0);
                    }
                    WorkerEnd::ByServer => job.released(micros(bench.store.now())),
                }
            }
            Step::Pass { seconds } => {
                for _ in 0..seconds {
                    bench.clock.advance(Duration::from_secs(1));
                    time.since_sweep += Duration::from_secs(1);
                    bench.sweep().await;
                    time.sweep(&mut model);
                }
            }
            Step::Freeze { seconds } => {
                bench.clock.advance(Duration::from_secs(seconds));
                time.since_sweep += Duration::from_secs(seconds);
                bench.sweep().await;
                time.sweep(&mut model);
            }
            Step::SetClock { hours } => {
                bench.clock.set(hours * 3_600_000_000);
                bench.sweep().await;
                time.sweep(&mut model);
            }
        }
        let mut counts = BTreeMap::new();
        for (id, job) in ids.iter().zip(&model) {
            let fit = fits.get(*id).await.unwrap();
            assert_eq!((fit.state, fit.lease_epoch), (job.state, job.epoch));
            *counts.entry(job.state.as_str()).or_insert(0u64) += 1;
        }
        let depth = fits.depth().await.unwrap();
        let fits = depth.counts.iter().filter(|(kind, ..)| *kind == Kind::Fit);
        let depth: BTreeMap<_, _> = fits.map(|(_, s, n)| (s.as_str(), *n)).collect();
        assert_eq!(depth, counts);
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 24, ..ProptestConfig::default() })]
    #[test]
    fn the_queue_is_its_model(steps in steps()) {
        let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap();
        runtime.block_on(run(On::Sqlite, steps));
    }
}

proptest! {
    // Each makes a database.
    #![proptest_config(ProptestConfig { cases: 6, ..ProptestConfig::default() })]
    #[test]
    fn the_queue_is_its_model_on_postgres(steps in steps()) {
        let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap();
        if let Some(on) = On::postgres_or_skip() {
            runtime.block_on(run(on, steps));
        }
    }
}
