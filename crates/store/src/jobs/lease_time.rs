//! The time by which leases end: the time for which this process has run, as its sweeps saw it
//! pass.
//!
//! Lease time is not the time of day, which an administrator or a time server may set back or
//! forward. Time in which the process stood still (a suspended machine, a stopped container, a disk
//! that did not answer) counts as at most one step between two sweeps: workers could not renew
//! anything then, so they keep the rest of their leases.
//!
//! The ends of leases are in memory. After a restart every lease that the database knows begins
//! again with the first sweep: its holder gets a full lease to report, and no more. The same
//! applies to leases that another server has renewed since the last sweep.

use std::{
    collections::HashMap,
    sync::{Mutex, MutexGuard, PoisonError},
    time::Duration,
};

use super::JobId;

/// Duration of leases, and the pace of the sweeps that end them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LeaseTerms {
    /// Time of a lease.
    pub lease: Duration,
    /// Most time that counts between two sweeps: somewhat more than their interval.
    pub step: Duration,
}

/// The leases that run, and the time by which they end.
#[derive(Debug, Default)]
pub(crate) struct LeaseTimes(Mutex<State>);

#[derive(Debug, Default)]
struct State {
    /// Lease time at the last sweep.
    passed: Duration,
    /// The monotonic clock at the last sweep; none before the first.
    swept: Option<Duration>,
    /// Most time that counts until the next.
    step: Duration,
    ends: HashMap<JobId, End>,
}

/// A lease, and its end if it is known here.
#[derive(Clone, Copy, Debug)]
struct End {
    epoch: u64,
    at: Duration,
    /// Renewal that the last sweep found.
    renewal: Option<i64>,
    /// Time of the last renewal in this process, if there was one.
    renewed: Option<Duration>,
}

/// A running job, as a sweep finds it in the database.
#[derive(Clone, Copy, Debug)]
pub(super) struct RunningJob {
    pub(super) job: JobId,
    pub(super) epoch: u64,
    /// Changes with each renewal, where other servers may renew it.
    pub(super) renewal: Option<i64>,
}

impl State {
    fn now(&self, monotonic: Duration) -> Duration {
        let since = self.swept.map_or(Duration::ZERO, |swept| monotonic.saturating_sub(swept));
        self.passed + since.min(self.step)
    }
}

impl LeaseTimes {
    /// The lease time at this reading of the monotonic clock.
    pub(crate) fn now(&self, monotonic: Duration) -> Duration {
        self.lock().now(monotonic)
    }

    /// Begins or renews a lease. Returns the time since the renewal before it: zero if there was
    /// none in this process, and at most a lease, because another server may have renewed it since.
    pub(super) fn renew(
        &self,
        job: JobId,
        epoch: u64,
        monotonic: Duration,
        lease: Duration,
    ) -> Duration {
        let mut state = self.lock();
        let now = state.now(monotonic);
        let known = state.ends.get(&job).filter(|end| end.epoch == epoch);
        let renewal = known.and_then(|end| end.renewal);
        let before = known.and_then(|end| end.renewed);
        let at = now.saturating_add(lease);
        state.ends.insert(job, End { epoch, at, renewal, renewed: Some(now) });
        before.map_or(Duration::ZERO, |before| now.saturating_sub(before)).min(lease)
    }

    /// Lets time pass up to now, given the leases that run: those not known yet begin, others are
    /// forgotten. Returns those that have run out.
    pub(super) fn sweep(
        &self,
        running: &[RunningJob],
        monotonic: Duration,
        terms: LeaseTerms,
    ) -> Vec<JobId> {
        let mut state = self.lock();
        let now = state.now(monotonic);
        (state.passed, state.swept, state.step) = (now, Some(monotonic), terms.step);
        let mut before = std::mem::take(&mut state.ends);
        let mut expired = Vec::new();
        for &RunningJob { job, epoch, renewal } in running {
            let known = before.remove(&job).filter(|end| end.epoch == epoch);
            let renewed = now.saturating_add(terms.lease);
            let at = match known {
                Some(end) if end.renewal == renewal => end.at,
                Some(end) => end.at.max(renewed),
                None => renewed,
            };
            if at < now {
                expired.push(job);
            }
            let renewed_here = known.and_then(|end| end.renewed);
            state.ends.insert(job, End { epoch, at, renewal, renewed: renewed_here });
        }
        expired
    }

    /// True if the lease has run out by the last sweep.
    pub(super) fn has_run_out(&self, job: JobId, epoch: u64) -> bool {
        let state = self.lock();
        state.ends.get(&job).is_some_and(|end| end.epoch == epoch && end.at < state.passed)
    }

    fn lock(&self) -> MutexGuard<'_, State> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
