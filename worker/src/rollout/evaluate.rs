//! Evaluations: the predictions of a twin beside a recording, as a fit scores its own. Their
//! simulations wait for their turns at the device like those of rollouts.

use std::sync::Arc;

use bendtwin_core::ids::{CaptureId, InvalidName, TwinId};
use bendtwin_eval::{EvaluateOptions, Scale, assess, evaluate};
use bendtwin_proto::{v1::Evaluation, worker::v1::ExecuteEvaluateTwinRequest};

use super::{
    error::Error,
    service::{Inner, Unary},
};
use crate::device::Priority;

impl Inner {
    /// Answers an evaluation.
    pub(super) async fn evaluate(
        self: &Arc<Self>,
        request: ExecuteEvaluateTwinRequest,
        call: &Unary,
    ) -> Result<Evaluation, Error> {
        let wire = request.request.ok_or_else(|| Error::field("request", "is missing"))?;
        let wrong = |field| move |e: InvalidName| Error::field(field, e.to_string());
        let twin: TwinId = wire.twin.parse().map_err(wrong("twin"))?;
        let capture: CaptureId = wire.capture.parse().map_err(wrong("capture"))?;
        let warm = self.twins.get(twin).await?;
        let (recording, share) = self.replays.recording(capture).await?;
        let backend = self.device.backend(Priority::Interactive);
        let quality = call.blocking(move |cancel| {
            let _share = share;
            let options = EvaluateOptions::default();
            let mut quality = evaluate(&backend, &warm.twin, &recording, &options, cancel)?;
            let scale = Scale::of_nodes(&warm.twin.graph.rest_positions);
            quality.assessment = Some(assess(&quality, scale));
            Ok(quality)
        });
        let quality_json = serde_json::to_string(&quality.await?)
            .map_err(|e| Error::field("quality", e.to_string()))?;
        Ok(Evaluation {
            twin: twin.to_string(),
            capture: capture.to_string(),
            quality_json,
            worker: self.worker.clone(),
        })
    }
}
