//! Waiting for the device without keeping a processor busy.
//!
//! The driver waits by polling, which takes a whole core for as long as a kernel runs. Here a wait
//! polls for a short time only and then sleeps between two polls, each time for an eighth of the
//! time that it has lasted so far: it ends late by an eighth at most, and takes hardly any
//! processor time if it is long. Callers of an urgent queue wait for small work, and poll for much
//! longer before they sleep.

use std::{thread, time::Duration, time::Instant};

use cudarc::driver::{CudaEvent, CudaStream, DriverError, sys};

use super::URGENT;

/// Time for which a wait looks without a break: a sleep takes no less.
const LOOK: Duration = Duration::from_micros(50);
/// Time of polling for urgent work.
const URGENT_LOOK: Duration = Duration::from_millis(20);
/// A sleep as a share of the wait so far, and its bounds.
const SHARE: u32 = 8;
const SHORTEST_SLEEP: Duration = Duration::from_micros(20);
const LONGEST_SLEEP: Duration = Duration::from_micros(500);

/// Waits for all launches on a stream so far.
pub(crate) fn for_stream(stream: &CudaStream) -> Result<(), DriverError> {
    let mark = stream.record_event(None)?;
    for_event(&mark, stream)
}

/// Waits for an event of a stream.
pub(crate) fn for_event(event: &CudaEvent, stream: &CudaStream) -> Result<(), DriverError> {
    // Asks of an event without binding, which another thread may have recorded.
    stream.context().bind_to_thread()?;
    let look = if is_urgent(stream) { URGENT_LOOK } else { LOOK };
    let began = Instant::now();
    while !event.try_is_complete()? {
        match sleep_after(began.elapsed(), look) {
            Some(sleep) => thread::sleep(sleep),
            None => thread::yield_now(),
        }
    }
    Ok(())
}

/// Sleep before the next look of a wait that has lasted so long; none at its beginning.
fn sleep_after(waited: Duration, look: Duration) -> Option<Duration> {
    (waited >= look).then(|| (waited / SHARE).clamp(SHORTEST_SLEEP, LONGEST_SLEEP))
}

/// True for a stream of an urgent queue.
fn is_urgent(stream: &CudaStream) -> bool {
    let mut priority = 0;
    // SAFETY: the stream is alive, and the priority is a C int.
    let asked = unsafe { sys::cuStreamGetPriority(stream.cu_stream(), &raw mut priority) };
    asked == sys::CUresult::CUDA_SUCCESS && priority == URGENT
}

#[cfg(test)]
mod tests;
