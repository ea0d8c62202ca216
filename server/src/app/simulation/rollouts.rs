//! What a twin computes in one call: rollouts, registrations, and evaluations beside a recording.

use std::time::Duration;

use bendtwin_budget::Share;
use bendtwin_core::ids::{CaptureId, TwinId};
use bendtwin_proto::v1::{EvaluateTwinRequest, Evaluation};

use super::super::{App, InParts, Register, Registered, Result, RollOut, Whole};
use crate::access::Scope;

impl App {
    /// Simulates a rollout.
    pub(crate) async fn roll_out(&self, rollout: RollOut) -> Result<Whole> {
        self.require_rollout(&rollout.request).await?;
        self.dispatch.roll_out(rollout).await
    }

    /// Simulates a rollout whose reply comes in parts.
    pub(crate) async fn roll_out_in_parts(&self, rollout: RollOut) -> Result<InParts> {
        self.require_rollout(&rollout.request).await?;
        self.dispatch.parts(rollout).await
    }

    /// The state of a twin that explains an observation.
    pub(crate) async fn register_state(&self, register: Register) -> Result<Registered> {
        let request = &register.request;
        self.reach::<TwinId>(Scope::RolloutsRun, &request.twin).await?;
        self.require_initial(request.initial.as_ref()).await?;
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
        let twin: TwinId = self.reach(Scope::RolloutsRun, &request.twin).await?;
        let capture: CaptureId = self.reach(Scope::RolloutsRun, &request.capture).await?;
        // Unknown names are reported before a worker is asked.
        self.store.captures().get(capture).await?;
        self.dispatch.evaluate_twin(twin, request, timeout).await
    }
}
