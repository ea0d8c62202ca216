//! The priority of the work that broke a device: a fit is not to blame for a rollout.

use std::sync::{Arc, OnceLock};

use super::queue::Priority;

/// The priority of the first task that broke the device, if one has.
#[derive(Clone, Debug, Default)]
pub(super) struct Blame(Arc<OnceLock<Priority>>);

/// Watch over a running task, which is to blame if it panics.
pub(super) struct Watch {
    blame: Blame,
    priority: Priority,
}

impl Blame {
    pub(super) fn get(&self) -> Option<Priority> {
        self.0.get().copied()
    }

    /// Watches the task that is about to run.
    pub(super) fn watch(&self, priority: Priority) -> Watch {
        Watch { blame: self.clone(), priority }
    }
}

impl Watch {
    /// The task has broken the device.
    pub(super) fn broke(&self) {
        // Later ones met a device that was broken already.
        let _ = self.blame.0.set(self.priority);
    }
}

impl Drop for Watch {
    fn drop(&mut self) {
        if std::thread::panicking() {
            self.broke();
        }
    }
}
