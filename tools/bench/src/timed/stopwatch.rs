//! Time during which at least one of several calls runs, on any thread.

use std::{
    sync::{Mutex, PoisonError},
    time::{Duration, Instant},
};

/// Total time of calls; overlapping calls count once.
#[derive(Debug, Default)]
pub(super) struct Stopwatch(Mutex<Calls>);

#[derive(Debug, Default)]
struct Calls {
    running: usize,
    /// Start of the first of the running calls.
    since: Option<Instant>,
    spent: Duration,
}

impl Stopwatch {
    /// Runs a call and counts its time.
    pub(super) fn time<R>(&self, work: impl FnOnce() -> R) -> R {
        /// Ends the call, also if it panics.
        struct RunGuard<'a>(&'a Stopwatch);
        impl Drop for RunGuard<'_> {
            fn drop(&mut self) {
                self.0.change(|calls| {
                    calls.running -= 1;
                    if calls.running == 0
                        && let Some(since) = calls.since.take()
                    {
                        calls.spent += since.elapsed();
                    }
                });
            }
        }
        self.change(|calls| {
            calls.running += 1;
            calls.since.get_or_insert_with(Instant::now);
        });
        let _running = RunGuard(self);
        work()
    }

    /// Time of calls that have ended [s].
    pub(super) fn seconds(&self) -> f64 {
        self.change(|calls| calls.spent).as_secs_f64()
    }

    fn change<R>(&self, change: impl FnOnce(&mut Calls) -> R) -> R {
        change(&mut self.0.lock().unwrap_or_else(PoisonError::into_inner))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_overlaps_counts_once() {
        let watch = Stopwatch::default();
        let began = Instant::now();
        let work = || (0..100_000_u64).fold(0, |sum, i| std::hint::black_box(sum ^ i));
        watch.time(|| watch.time(|| watch.time(work)));
        let most = began.elapsed().as_secs_f64();
        let spent = watch.seconds();
        assert!(spent > 0.0 && spent <= most, "{spent} of {most}");
    }

    #[test]
    fn a_call_that_panics_ends_as_well() {
        let watch = Stopwatch::default();
        let failing = std::panic::AssertUnwindSafe(|| watch.time(|| panic!("on purpose")));
        assert!(std::panic::catch_unwind(failing).is_err());
        assert_eq!(watch.change(|calls| (calls.running, calls.since)), (0, None));
    }
}
