//! The queue against a model of it: random claims, reports, failures, releases, cancellations and
//! losses of workers, while time passes, the process stands still and the clock of the day is set.

use std::{collections::BTreeMap, time::Duration};

use jiff::Timestamp;
use proptest::prelude::*;

use super::{fault, progress};
use crate::{
    Kind, Lease, NewFit,
    database::testing::On,
    jobs::{AttemptEnd, State, WorkerEnd},
    store::tests::{Bench, LEASE, TERMS, new_fit},
};
use bendtwin_core::ids::WorkerId;

#[derive(Clone, Debug)]
enum Step {
    Create {
        priority: i32,
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
        3 => (-2..3).prop_map(|priority| Step::Create { priority }),
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
    proptest::collection::vec(step, 1..40)
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
        self.state = match () {
            () if self.cancelling => State::Cancelled,
            () if self.stalled >= 3 => State::Failed,
            () => State::Queued,
        };
    }

    fn released(&mut self) {
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
            Step::Create { priority } => {
                bench.clock.advance(Duration::from_micros(1));
                time.since_sweep += Duration::from_micros(1);
                ids.push(
                    fits.create_fit(NewFit { priority, ..new_fit(&capture) }).await.unwrap().id,
                );
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
                });
            }
            Step::Claim => {
                let queued = model.iter().enumerate().filter(|(_, j)| j.state == State::Queued);
                let next = queued.min_by_key(|(_, j)| (-j.priority, j.created)).map(|(i, _)| i);
                let worker = WorkerId::generate();
                let got = fits.claim(Kind::Fit, worker, LEASE).await.unwrap();
                assert_eq!(got.as_ref().map(|f| f.id), next.map(|i| ids[i]));
                if let (Some(fit), Some(i)) = (got, next) {
                    model[i].state = State::Running;
                    model[i].epoch += 1;
                    model[i].stalled += 1;
                    model[i].until = time.now() + LEASE;
                    leases.push((i, fit.lease().unwrap()));
                }
            }
            Step::Report { lease, fraction } => {
                let Some(&(i, lease)) = leases.get(lease) else { continue };
                let job = &mut model[i];
                let live = job.state == State::Running && job.epoch == lease.epoch;
                let done = fits.report(lease, Some(&progress(fraction)), LEASE).await;
                assert_eq!(done.is_ok(), live);
                if live {
                    job.until = time.now() + LEASE;
                }
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
                    1 => job.state = State::Failed,
                    2 => job.state = State::Cancelled,
                    _ => job.released(),
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
                    WorkerEnd::DuringRollout | WorkerEnd::ByServer => job.released(),
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
