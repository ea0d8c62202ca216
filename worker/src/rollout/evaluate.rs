//! Evaluations: the recording that they need, and its memory. Their simulations wait for their turns
//! at the device like those of rollouts.

use std::sync::Arc;

use bendtwin_core::ids::{CaptureId, TwinId};
use bendtwin_proto::{v1::Evaluation, worker::v1::ExecuteEvaluateTwinRequest};
use bendtwin_rollout::evaluate_twin;

use super::{
    error::Error,
    service::{Inner, Unary},
};

impl Inner {
    /// Answers an evaluation.
    pub(super) async fn evaluate(
        self: &Arc<Self>,
        request: ExecuteEvaluateTwinRequest,
        call: &Unary,
    ) -> Result<Evaluation, Error> {
        let request = request.request.ok_or_else(|| Error::field("request", "is missing"))?;
        let twin: TwinId = Error::parsed("twin", &request.twin)?;
        let capture: CaptureId = Error::parsed("capture", &request.capture)?;
        let warm = self.twins.get(twin).await?;
        let (recording, share) = self.replays.recording(capture).await?;
        let sequence = request.motion.map(|motion| motion.sequence);
        let backend = call.backend(&self.device);
        let evaluated = call.blocking(move |cancel| {
            let _share = share;
            Ok(evaluate_twin(&warm, &recording, sequence, &backend, cancel)?)
        });
        let (quality_json, motion) = evaluated.await?;
        Ok(Evaluation {
            twin: twin.to_string(),
            capture: capture.to_string(),
            quality_json,
            worker: self.worker.clone(),
            motion,
        })
    }
}
