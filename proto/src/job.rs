//! States of jobs.

use crate::v1::{Fit, Job, job::State};

impl State {
    /// True if the job will not change any more.
    pub fn has_ended(self) -> bool {
        matches!(self, Self::Succeeded | Self::Failed | Self::Cancelled)
    }

    /// The state as one lower-case word.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Unspecified => "unspecified",
            Self::Queued => "queued",
            Self::Running => "running",
            Self::Succeeded => "succeeded",
            Self::Failed => "failed",
            Self::Cancelled => "cancelled",
        }
    }
}

impl Fit {
    /// State of the fit's job; unspecified if the message has none.
    pub fn state(&self) -> State {
        self.job.as_ref().map_or(State::Unspecified, Job::state)
    }
}
