//! Limit on the launches that the host has ahead of the device, so that others have their turn and
//! cancellations are noticed.

use bendtwin_engine::Error;
use cudarc::driver::CudaEvent;

use super::queue::Queue;

/// Launches under way.
#[derive(Default)]
pub(crate) struct LaunchThrottle {
    /// End of the stretch before this one.
    before: Option<CudaEvent>,
    /// Estimated time of what this stretch has [us].
    since_us: f64,
}

impl LaunchThrottle {
    /// Counts work that was launched and should take so long [us]. Where it ends a stretch, waits
    /// for the stretch before.
    pub(crate) fn launched(&mut self, queue: &Queue, us: f64) -> Result<(), Error> {
        self.since_us += us;
        // Half a stretch more would be too long: estimates may be off by that.
        if self.since_us < 0.5 * queue.stretch_us() {
            return Ok(());
        }
        self.since_us = 0.0;
        let now = queue.mark()?;
        match self.before.replace(now) {
            Some(before) => queue.wait_for(&before),
            None => Ok(()),
        }
    }
}
