//! The queue against a model of it in twenty lines: random claims, reports,
//! failures, releases, expiries and cancellations.

use std::{collections::BTreeMap, time::Duration};

use proptest::prelude::*;

use super::{fault, progress};
use crate::{
    Kind, Lease, NewFit,
    jobs::{AttemptEnd, State},
    store::tests::{Bench, LEASE, new_fit},
};
use bendtwin_core::ids::WorkerId;

#[derive(Clone, Debug)]
enum Step {
    Create {
        priority: i32,
    },
    Claim,
    /// Of the n-th lease ever given, stale or not.
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
    Expire,
}

fn steps() -> impl Strategy<Value = Vec<Step>> {
    let step = prop_oneof![
        3 => (-2..3).prop_map(|priority| Step::Create { priority }),
        4 => Just(Step::Claim),
        3 => (0..8usize, 0.0..1.0f64)
            .prop_map(|(lease, fraction)| Step::Report { lease, fraction }),
        3 => (0..8usize, 0..4u8).prop_map(|(lease, how)| Step::End { lease, how }),
        1 => (0..6usize).prop_map(|job| Step::Cancel { job }),
        1 => Just(Step::Expire),
    ];
    proptest::collection::vec(step, 1..40)
}

#[derive(Clone, Debug)]
struct Job {
    state: State,
    priority: i32,
    epoch: u64,
    stalled: u32,
    furthest: f64,
    cancelling: bool,
}

impl Job {
    fn lost(&mut self) {
        self.state = match () {
            () if self.cancelling => State::Cancelled,
            () if self.stalled >= 3 => State::Failed,
            () => State::Queued,
        };
    }
}

async fn run(steps: Vec<Step>) {
    let bench = Bench::new().await;
    let capture = bench.capture("a").await;
    let fits = bench.store.jobs();
    let mut model: Vec<Job> = Vec::new();
    let mut ids = Vec::new();
    let mut leases: Vec<(usize, Lease)> = Vec::new();
    for step in steps {
        match step {
            Step::Create { priority } => {
                bench.clock.advance(Duration::from_micros(1));
                ids.push(
                    fits.create_fit(NewFit { priority, ..new_fit(&capture) }).await.unwrap().id,
                );
                let state = State::Queued;
                let new =
                    Job { state, priority, epoch: 0, stalled: 0, furthest: 0.0, cancelling: false };
                model.push(new);
            }
            Step::Claim => {
                let queued = model.iter().enumerate().filter(|(_, j)| j.state == State::Queued);
                let next = queued.min_by_key(|(i, j)| (-j.priority, *i)).map(|(i, _)| i);
                let got = fits.claim(Kind::Fit, WorkerId::generate(), LEASE).await.unwrap();
                assert_eq!(got.as_ref().map(|f| f.id), next.map(|i| ids[i]));
                if let (Some(fit), Some(i)) = (got, next) {
                    model[i].state = State::Running;
                    model[i].epoch += 1;
                    model[i].stalled += 1;
                    leases.push((i, Lease { job: fit.id, epoch: fit.lease_epoch }));
                }
            }
            Step::Report { lease, fraction } => {
                let Some(&(i, lease)) = leases.get(lease) else { continue };
                let job = &mut model[i];
                let live = job.state == State::Running && job.epoch == lease.epoch;
                let done = fits.report(lease, Some(&progress(fraction)), LEASE).await;
                assert_eq!(done.is_ok(), live);
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
                    _ => {
                        job.stalled = job.stalled.saturating_sub(1);
                        job.state = if job.cancelling { State::Cancelled } else { State::Queued };
                    }
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
            Step::Expire => {
                bench.clock.advance(LEASE + Duration::from_secs(1));
                fits.sweep().await.unwrap();
                model.iter_mut().filter(|j| j.state == State::Running).for_each(Job::lost);
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
        runtime.block_on(run(steps));
    }
}
