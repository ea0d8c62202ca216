//! The backend that rollouts run on.

use std::time::Duration;

use bendtwin_core::CancelToken;
use bendtwin_engine::{
    Backend,
    backend::{Error, Instance, Outputs, Rollout},
};

/// A backend that can stop at the end of a time limit with what it has, and that says how long it
/// computed.
pub trait RolloutBackend: Backend {
    /// [`Backend::roll_out`], but with `None` for instances that are not done when the token is
    /// cancelled.
    ///
    /// # Errors
    /// As [`Backend::roll_out`], apart from the end of the token's time.
    fn roll_out_in_time(
        &self,
        batch: &[Instance],
        outputs: &Outputs,
        cancel: &CancelToken,
    ) -> Result<Vec<Option<Rollout>>, Error>;

    /// Device time used so far.
    fn compute(&self) -> Duration;
}
