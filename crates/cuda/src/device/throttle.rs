//! Limit on the launches that the host has ahead of the device: one stretch of work, so that others
//! have their turn and cancellations are noticed.

use bendtwin_engine::Error;
use cudarc::driver::CudaEvent;

use super::{fault, queue::Queue};

/// The last launch.
#[derive(Default)]
pub(crate) struct LaunchThrottle {
    before: Option<CudaEvent>,
}

impl LaunchThrottle {
    /// Ends a stretch of work; waits for the one before it.
    pub(crate) fn step(&mut self, queue: &Queue) -> Result<(), Error> {
        let now = queue.mark()?;
        match self.before.replace(now) {
            Some(before) => before.synchronize().map_err(|e| fault("the device's work", e)),
            None => Ok(()),
        }
    }
}
