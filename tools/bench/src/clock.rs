//! Repeats within a budget of time.

use std::time::{Duration, Instant};

/// Never more repeats than this: a median of them is settled.
const MOST_REPEATS: usize = 200;

/// Durations of a repeated piece of work.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Timing {
    /// Number of timings.
    pub(crate) repeats: usize,
    /// The shortest time [s].
    pub(crate) best_s: f64,
    /// The median [s]: the upper one of an even number.
    pub(crate) median_s: f64,
}

/// Does the work until the budget is spent, at least once.
pub(crate) fn repeat<E>(
    budget: Duration,
    mut work: impl FnMut() -> Result<(), E>,
) -> Result<Timing, E> {
    let began = Instant::now();
    let mut times: Vec<f64> = Vec::new();
    loop {
        times.push(once(&mut work)?);
        if began.elapsed() >= budget || times.len() == MOST_REPEATS {
            break;
        }
    }
    times.sort_by(f64::total_cmp);
    Ok(Timing { repeats: times.len(), best_s: times[0], median_s: times[times.len() / 2] })
}

/// Seconds that the work takes [s].
pub(crate) fn once<E>(mut work: impl FnMut() -> Result<(), E>) -> Result<f64, E> {
    let began = Instant::now();
    work()?;
    Ok(began.elapsed().as_secs_f64())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn work_is_done_at_least_once_and_not_for_ever() {
        let count = |budget| {
            let mut done = 0;
            let work = || {
                done += 1;
                Ok::<_, ()>(())
            };
            let timing = repeat(budget, work).unwrap();
            assert_eq!(timing.repeats, done);
            assert!(timing.best_s <= timing.median_s);
            done
        };
        assert_eq!(count(Duration::ZERO), 1);
        assert_eq!(count(Duration::from_secs(3600)), MOST_REPEATS);
    }

    #[test]
    fn failures_end_it() {
        assert_eq!(repeat(Duration::from_secs(3600), || Err::<(), _>("no")), Err("no"));
    }
}
