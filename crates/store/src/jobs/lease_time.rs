//! The time by which leases end: the time for which this process has run, as its sweeps saw it
//! pass.
//!
//! It is not the time of day, which an administrator or a time server may set back or forward. And
//! time in which the process stood still (a suspended machine, a stopped container, a disk that
//! did not answer) counts no more than one step between two sweeps: workers could not renew
//! anything then, so they keep what was left of their leases.
//!
//! The ends of leases are in memory. After a restart every lease that the database knows begins
//! anew with the first sweep: whoever holds one gets its time to report, and no longer.

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
    /// Epoch and end of each lease.
    ends: HashMap<JobId, (u64, Duration)>,
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

    /// Begins or renews a lease.
    pub(super) fn renew(&self, job: JobId, epoch: u64, monotonic: Duration, lease: Duration) {
        let mut state = self.lock();
        let end = state.now(monotonic).saturating_add(lease);
        state.ends.insert(job, (epoch, end));
    }

    /// Lets time pass up to now, given the leases that run: those not known yet begin, others are
    /// forgotten. Returns those that have run out.
    pub(super) fn sweep(
        &self,
        running: &[(JobId, u64)],
        monotonic: Duration,
        terms: LeaseTerms,
    ) -> Vec<JobId> {
        let mut state = self.lock();
        let now = state.now(monotonic);
        (state.passed, state.swept, state.step) = (now, Some(monotonic), terms.step);
        let mut before = std::mem::take(&mut state.ends);
        let mut expired = Vec::new();
        for (job, epoch) in running {
            let known = before.remove(job).filter(|(of, _)| of == epoch);
            let (_, end) = known.unwrap_or((*epoch, now.saturating_add(terms.lease)));
            if end < now {
                expired.push(*job);
            }
            state.ends.insert(*job, (*epoch, end));
        }
        expired
    }

    /// True if the lease has run out by the last sweep.
    pub(super) fn has_run_out(&self, job: JobId, epoch: u64) -> bool {
        let state = self.lock();
        state.ends.get(&job).is_some_and(|(of, end)| *of == epoch && *end < state.passed)
    }

    fn lock(&self) -> MutexGuard<'_, State> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
