//! States of jobs.

use crate::v1::{Fit, Job, job::State};

impl State {
    /// True if the job will not change any more.
    pub fn has_ended(self) -> bool {
        matches!(self, Self::Succeeded | Self::Failed | Self::Cancelled)
    }
}

impl Fit {
    /// State of the fit's job; unspecified if the message has none.
    pub fn state(&self) -> State {
        self.job.as_ref().map_or(State::Unspecified, Job::state)
    }
}
