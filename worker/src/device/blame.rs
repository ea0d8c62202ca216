//! The priority of the work that broke a device: a fit is not to blame for a rollout.

use std::sync::{Arc, OnceLock};

use super::queue::Priority;

/// The priority of the first task that broke the device, if one has.
#[derive(Clone, Debug, Default)]
pub(super) struct Blame(Arc<OnceLock<Priority>>);

/// A task that runs; it is to blame if it panics.
pub(super) struct Running {
    blame: Blame,
    priority: Priority,
}

impl Blame {
    pub(super) fn get(&self) -> Option<Priority> {
        self.0.get().copied()
    }

    /// Marks the task that is about to run.
    pub(super) fn running(&self, priority: Priority) -> Running {
        Running { blame: self.clone(), priority }
    }
}

impl Running {
    /// The task has broken the device.
    pub(super) fn broke(&self) {
        // Later ones met a device that was broken already.
        let _ = self.blame.0.set(self.priority);
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        if std::thread::panicking() {
            self.broke();
        }
    }
}
