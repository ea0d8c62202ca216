//! The planner's twin at the end of a fit.

use bendtwin_core::{Category, Problem as _, Stage};

use super::{Outcome, Run};
use crate::{Error, distill::Distillation, progress::ModelProgress};

impl Run<'_> {
    /// Adds the planner's twin, if the settings ask for one and leave the time.
    pub(super) fn distill(&mut self, outcome: &mut Outcome) -> Result<(), Error> {
        let settings = &self.task.settings.planner;
        let nodes = settings.nodes.unwrap_or_default();
        if nodes == 0 {
            return Ok(());
        }
        if let Some(limit_s) = self.task.settings.within_s {
            outcome.twin.quality.warnings.push(format!(
                "No planner's twin was made, since the fit was limited to {limit_s} s: `bendtwin twin planner` makes one."
            ));
            return Ok(());
        }
        let progress = ModelProgress::new(&self.models[0].name, Stage::Evaluate, 1);
        let note = Some("distilling a planner's twin".into());
        self.report(ModelProgress { note, ..progress });
        let substeps = settings.substeps.unwrap_or_default();
        let wanted =
            Distillation { nodes: nodes as usize, substeps, seed: self.task.settings.seed };
        let capture = Some(self.job.capture);
        match wanted.of(&outcome.twin, capture, &self.job.backend, self.cancel) {
            Ok(twin) => outcome.twin = twin,
            // A twin is worth keeping without one.
            Err(error) if is_its_own(&error) => {
                let note = format!("No planner's twin was made: {error}");
                outcome.twin.quality.warnings.push(note);
            }
            Err(error) => return Err(error),
        }
        Ok(())
    }
}

/// True if an error says something about the planner's twin, rather than of the device or of a request to
/// stop.
fn is_its_own(error: &Error) -> bool {
    matches!(error.category(), Category::InvalidArgument | Category::FailedPrecondition)
}
