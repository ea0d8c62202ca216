//! What a twin computes in one call: rollouts, registrations, and evaluations beside a recording.

use std::time::Duration;

use bendtwin_budget::Share;
use bendtwin_core::ids::{CaptureId, TwinId};
use bendtwin_proto::v1::{EvaluateTwinRequest, Evaluation};

use super::{App, InParts, Register, Registered, Result, RollOut, Whole};

impl App {
    /// Simulates a rollout.
    pub(crate) async fn roll_out(&self, rollout: RollOut) -> Result<Whole> {
        self.dispatch.roll_out(rollout).await
    }

    /// Simulates a rollout whose reply comes in parts.
    pub(crate) async fn roll_out_in_parts(&self, rollout: RollOut) -> Result<InParts> {
        self.dispatch.parts(rollout).await
    }

    /// The state of a twin that explains an observation.
    pub(crate) async fn register_state(&self, register: Register) -> Result<Registered> {
        self.dispatch.register_state(register).await
    }

    /// Memory for a reply whose messages have at most `bytes`.
    pub(crate) async fn reply_memory(&self, bytes: u64) -> Result<Share> {
        self.memory.reply(bytes).await
    }

    /// The quality table of a twin on a capture, and the motion of a sequence if that was asked for.
    pub(crate) async fn evaluate_twin(
        &self,
        request: EvaluateTwinRequest,
        timeout: Option<Duration>,
    ) -> Result<Evaluation> {
        let twin: TwinId = super::name(&request.twin)?;
        let capture: CaptureId = super::name(&request.capture)?;
        // Unknown names are reported before a worker is asked.
        self.store.captures().get(capture).await?;
        self.dispatch.evaluate_twin(twin, request, timeout).await
    }
}
