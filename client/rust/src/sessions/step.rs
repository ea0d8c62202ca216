//! Steps of a closed loop: a correction, a plan and an advance in one call.

use std::time::Duration;

use bendtwin_core::{Fault, ids::SessionId};
pub use bendtwin_proto::v1::stepped_session::Times as StepTimes;
use bendtwin_proto::v1::{StepSessionRequest, SteppedSession};

use super::{Corrected, Correction};
use crate::{Error, PlanUpdate, Planning, Reply, State};

/// A step to be taken: a plan from where a slot is, and what comes before and after it. The actions of
/// its rollout are the nominal plan; what the rollout returns is of the frames that are executed.
#[derive(Clone, Debug)]
pub struct Step {
    slot: u32,
    correction: Option<Correction>,
    planning: Planning,
    execute_frames: u32,
    deadline: Duration,
}

/// A step that was taken.
#[derive(Clone, Debug, PartialEq)]
pub struct Stepped {
    /// The correction; none if none was asked for, or it was refused.
    pub corrected: Option<Corrected>,
    /// The reason of a refusal: the slot does not explain the points, and was planned from and
    /// advanced as it had been predicted.
    pub refused: Option<Fault>,
    /// True if the slot does not follow its object any more.
    pub lost: bool,
    /// The best plan.
    pub plan: PlanUpdate,
    /// The rollout of the frames that were executed; none without any. If it diverged, the slot is
    /// still where the plan began.
    pub advanced: Option<Reply>,
    /// The state that the slot is in now.
    pub state: State,
    /// Time of the correction, of the search, of the frames that were executed, and of all of it.
    pub times: StepTimes,
}

impl Step {
    /// A plan from slot 0, of which nothing is executed.
    pub fn of(planning: Planning) -> Self {
        let deadline = Duration::ZERO;
        Self { slot: 0, correction: None, planning, execute_frames: 0, deadline }
    }

    /// Another slot.
    #[must_use]
    pub fn slot(mut self, slot: u32) -> Self {
        self.slot = slot;
        self
    }

    /// Corrects the slot before the plan.
    #[must_use]
    pub fn corrected(mut self, correction: Correction) -> Self {
        self.correction = Some(correction);
        self
    }

    /// Advances the slot by the first frames of the best plan.
    #[must_use]
    pub fn execute(mut self, frames: u32) -> Self {
        self.execute_frames = frames;
        self
    }

    /// Time for all of it: the search ends when nine tenths of it have passed.
    #[must_use]
    pub fn deadline(mut self, deadline: Duration) -> Self {
        self.deadline = deadline;
        self
    }

    pub(super) fn into_request(self, name: SessionId) -> Result<StepSessionRequest, Error> {
        let Self { slot, correction, planning, execute_frames, deadline } = self;
        let mut search = planning.into_request()?;
        let returns = search.rollout.as_mut().and_then(|rollout| rollout.returns.take());
        let correction = correction.map(|correction| {
            let mut request = correction.into_request(name, &[]);
            request.name.clear();
            request
        });
        Ok(StepSessionRequest {
            name: name.to_string(),
            slot,
            correction,
            search: Some(search),
            execute_frames,
            returns,
            deadline_s: deadline.as_secs_f64(),
        })
    }
}

impl TryFrom<SteppedSession> for Stepped {
    type Error = Error;
    fn try_from(wire: SteppedSession) -> Result<Self, Error> {
        let corrections = wire.corrected.unwrap_or_default().corrections;
        Ok(Self {
            corrected: corrections.into_iter().next().map(Corrected::try_from).transpose()?,
            refused: wire.refused.as_ref().map(Fault::from),
            lost: wire.lost,
            plan: wire.plan.unwrap_or_default().try_into()?,
            advanced: wire.advanced.map(Reply::try_from).transpose()?,
            state: wire.state.unwrap_or_default().try_into()?,
            times: wire.times.unwrap_or_default(),
        })
    }
}

#[cfg(test)]
mod tests;
