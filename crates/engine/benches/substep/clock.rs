//! Time that a piece of work takes on the processor: on Linux what the kernel gave to this
//! process's threads, so that a busy machine does not slow it; elsewhere the wall clock.

use std::{fs, time::Instant};

/// Shortest time of several runs [s]: what disturbs a run only adds.
pub(crate) fn best_of(times: usize, mut work: impl FnMut()) -> f64 {
    let run = |_| {
        let (start, before) = (Instant::now(), processor_ns());
        work();
        match (before, processor_ns()) {
            (Some(before), Some(after)) => (after - before) as f64 * 1e-9,
            _ => start.elapsed().as_secs_f64(),
        }
    };
    (0..times).map(run).fold(f64::INFINITY, f64::min)
}

/// Time on the processor of all threads of this process [ns].
fn processor_ns() -> Option<u64> {
    let mut sum = 0;
    for task in fs::read_dir("/proc/self/task").ok()? {
        let stat = fs::read_to_string(task.ok()?.path().join("schedstat")).ok()?;
        sum += stat.split(' ').next()?.parse::<u64>().ok()?;
    }
    Some(sum)
}
