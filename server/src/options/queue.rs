//! Options of the queue: how owners share the workers.

use std::time::Duration;

use serde::{Deserialize, Serialize};

/// Shares of owners, and bounds on what one job may take of a worker.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Queue {
    /// Time for which a fit runs before it makes way for an owner that has none running [s]; 15 times
    /// that before it makes way for a fit that has run before.
    pub slice_s: f64,
    /// Longest time for which a fit runs at workers, over all attempts [s].
    pub fit_run_s: f64,
    /// Time without progress and without a new checkpoint after which a job is taken from its worker
    /// [s].
    pub stall_s: f64,
}

impl Default for Queue {
    fn default() -> Self {
        Self { slice_s: 20.0, fit_run_s: 86_400.0, stall_s: 7_200.0 }
    }
}

impl Queue {
    /// Passes each number to `within` with its name and its bounds.
    pub(super) fn validate(&self, mut within: impl FnMut(&str, f64, f64, f64)) {
        const LONGEST: f64 = 365.0 * 86_400.0;
        within("queue.slice_s", self.slice_s, 0.1, LONGEST);
        within("queue.fit_run_s", self.fit_run_s, 1.0, LONGEST);
        within("queue.stall_s", self.stall_s, 1.0, LONGEST);
    }

    pub(crate) fn slice(&self) -> Duration {
        Duration::from_secs_f64(self.slice_s)
    }

    pub(crate) fn fit_run(&self) -> Duration {
        Duration::from_secs_f64(self.fit_run_s)
    }

    pub(crate) fn stall(&self) -> Duration {
        Duration::from_secs_f64(self.stall_s)
    }
}
