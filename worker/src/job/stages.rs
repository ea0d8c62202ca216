//! Spans of the stages of a job, for traces: those of a fit, and the steps of the process that
//! reads a capture, which may not connect to anything itself.

use bendtwin_core::{Progress, Stage};
use tracing::Span;

/// The span of the present stage.
#[derive(Debug)]
pub(super) struct StageSpans {
    job: Span,
    present: Option<(String, Span)>,
}

/// Stages of the job whose span is the current one.
impl Default for StageSpans {
    fn default() -> Self {
        Self { job: Span::current(), present: None }
    }
}

impl StageSpans {
    /// Ends the span of a stage and begins that of the next when the progress names another stage.
    pub(super) fn follow(&mut self, progress: &Progress) {
        let name = match progress.stage {
            Stage::Ingest => progress.variant.as_str(),
            // Models are fitted side by side, each its variant.
            stage => stage.as_str(),
        };
        if self.present.as_ref().is_some_and(|(present, _)| present == name) {
            return;
        }
        let span = tracing::info_span!(parent: &self.job, "stage", stage = name);
        self.present = Some((name.to_owned(), span));
    }
}
