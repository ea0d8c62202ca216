//! Evaluations: a twin beside a recording.

use std::time::Duration;

use bendtwin_core::ids::{CaptureId, TwinId};
use bendtwin_proto::v1::Evaluation;

use super::{App, Result};

impl App {
    /// The quality table of a twin on a capture.
    pub(crate) async fn evaluate_twin(
        &self,
        twin: &str,
        capture: &str,
        timeout: Option<Duration>,
    ) -> Result<Evaluation> {
        let twin: TwinId = super::name(twin)?;
        let capture: CaptureId = super::name(capture)?;
        // A name of nothing is told before a worker is asked.
        self.store.captures().get(capture).await?;
        self.dispatch.evaluate_twin(twin, capture, timeout).await
    }
}
