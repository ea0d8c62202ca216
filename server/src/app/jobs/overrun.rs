//! Jobs that take too much of a worker: fits that run too long, and jobs that make no progress.

use std::time::Duration;

use bendtwin_core::Problem;
use bendtwin_store::{AttemptEnd, JobTimes, Kind};

use crate::options::Queue;

/// Reason for which the server ends an attempt that its worker continues.
#[derive(Debug, PartialEq, thiserror::Error, Problem)]
pub(super) enum Overrun {
    #[error(
        "the fit has run for {} s, the longest that {} allows: give it a time limit (within_s), after \
         which it ends with what it has, or less to do (a lower effort, fewer starts, generations or \
         passes)",
        .most.as_secs(),
        .by_key.then_some("its key").unwrap_or("this server")
    )]
    #[problem(ResourceExhausted, "FIT_TOO_LONG")]
    TooLong { most: Duration, by_key: bool },
    #[error(
        "the job made neither progress nor a checkpoint for {} s, so it was taken from its worker: see \
         that worker's log and restart it if it hangs, or raise queue.stall_s",
        .idle.as_secs()
    )]
    #[problem(Unavailable, "JOB_STALLED")]
    Stalled { idle: Duration },
}

/// The reason to end a running attempt, if there is one.
pub(super) fn of(kind: Kind, times: &JobTimes, queue: &Queue) -> Option<Overrun> {
    let of_server = queue.fit_run();
    let most = times.most_run.map_or(of_server, |of_key| of_key.min(of_server));
    if kind == Kind::Fit && times.run > most {
        return Some(Overrun::TooLong { most, by_key: most < of_server });
    }
    (times.idle > queue.stall()).then_some(Overrun::Stalled { idle: times.idle })
}

impl From<Overrun> for AttemptEnd {
    fn from(overrun: Overrun) -> Self {
        match overrun {
            Overrun::TooLong { .. } => Self::FailedForGood(overrun.fault()),
            Overrun::Stalled { .. } => Self::Failed(overrun.fault()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn times(run: u64, idle: u64, most_run: Option<u64>) -> JobTimes {
        let of = Duration::from_secs;
        JobTimes { run: of(run), idle: of(idle), most_run: most_run.map(of) }
    }

    #[test]
    fn the_lower_bound_ends_a_fit_for_good_and_a_standstill_any_job_for_now() {
        let queue = Queue { fit_run_s: 100.0, stall_s: 10.0, ..Queue::default() };
        let of = |kind, times| of(kind, &times, &queue);
        assert_eq!(of(Kind::Fit, times(100, 10, None)), None);
        assert_eq!(of(Kind::Fit, times(50, 0, Some(50))), None);
        for (run, most_run, most, by_key) in
            [(101, None, 100, false), (101, Some(200), 100, false), (51, Some(50), 50, true)]
        {
            let overrun = of(Kind::Fit, times(run, 0, most_run)).unwrap();
            assert_eq!(overrun, Overrun::TooLong { most: Duration::from_secs(most), by_key });
            let AttemptEnd::FailedForGood(fault) = overrun.into() else { panic!() };
            assert!(fault.reason == "FIT_TOO_LONG" && fault.message.contains(&most.to_string()));
        }
        for kind in [Kind::Fit, Kind::Ingest] {
            let end = of(kind, times(11, 11, None)).unwrap().into();
            assert!(matches!(end, AttemptEnd::Failed(fault) if fault.reason == "JOB_STALLED"));
        }
        // The worker ends an ingest that takes too long.
        assert_eq!(of(Kind::Ingest, times(101, 0, None)), None);
    }
}
