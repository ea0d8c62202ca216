//! The evaluation as a stage of a fit: the quality table of its twins, and what it says in words.

use bendtwin_core::{
    Quality, Stage, Twin,
    quality::{Assessment, Level, Predictor},
};
use bendtwin_eval::{EvaluateOptions, Scale, assess, evaluate, fast_variant};

use super::{Outcome, Run, model_fit::model_name, refine::RefinedModel};
use crate::{Error, progress::ModelProgress};

impl Run<'_> {
    /// The table in words. Where the time limit cut the fit short, that comes before other advice.
    fn assessment(&self, twin: &Twin, quality: &Quality, is_cut: bool) -> Assessment {
        let mut assessment =
            assess(quality, Scale::of_nodes(&twin.graph.rest_positions, &twin.graph.rods));
        let made = twin.provenance.settings.as_ref().and_then(|s| s.refine.passes);
        if let (Some(made), Some(limit_s)) = (made, self.task.settings.within_s)
            && is_cut
            && assessment.level != Level::Good
        {
            assessment.next = format!(
                "The time limit of {limit_s} s left {made} of {} passes: fit again with more time.",
                self.task.passes()
            );
        }
        assessment
    }

    /// Evaluates the twin and adds its fast variant.
    pub(super) fn evaluate(&mut self, finished: Vec<RefinedModel>) -> Result<Outcome, Error> {
        self.check_cancelled()?;
        let model = model_name(self.models[0].bending);
        let progress = |iteration| ModelProgress::new(model, Stage::Evaluate, iteration);
        self.report(progress(0));
        let mut finished = finished.into_iter();
        let Some(RefinedModel { mut twin, warnings, choice, is_cut }) = finished.next() else {
            return Err(Error::NothingStable("there is no model".into()));
        };
        let mut axial = finished.next().map(|f| f.twin);
        let options = EvaluateOptions { axial: axial.as_ref(), per_frame: false };
        let mut quality =
            evaluate(&*self.job.backend, &twin, self.job.capture, &options, self.cancel)?;
        quality.warnings.splice(0..0, warnings);
        quality.choice = choice;
        if let Some(axial) = &mut axial {
            let row = quality.score(Predictor::Axial).cloned();
            axial.quality.scores = row.into_iter().collect();
        }
        quality.fast = fast_variant(&*self.job.backend, &twin, self.job.capture, self.cancel)?;
        quality.assessment = Some(self.assessment(&twin, &quality, is_cut));
        twin.quality = quality;
        self.identify(&mut twin)?;
        self.report(progress(1));
        Ok(Outcome { twin, axial })
    }
}
