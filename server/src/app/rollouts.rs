//! Evaluations: a twin beside a recording.

use std::time::Duration;

use bendtwin_core::ids::{CaptureId, TwinId};
use bendtwin_proto::v1::{EvaluateTwinRequest, Evaluation};

use super::{App, Result};

impl App {
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
