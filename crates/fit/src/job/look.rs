//! The stage after the fit: colours and Gaussians of its twins from the views of the recording, and
//! the likeness of their renderings. A twin without them predicts equally well, so a fault here is
//! a warning.

use bendtwin_appearance::{Dressed, Motion, Scene, Training, TrainingOptions, score, skin_colors};
use bendtwin_core::{Appearance, Splats, Stage, Twin, quality::RenderedScore};
use bendtwin_splat::Rasteriser;

use super::{Outcome, Run, model_fit::model_name, time_limit::TimeLimit};
use crate::{
    Error,
    look::{Look, Predicted},
    progress::ModelProgress,
};

/// Steps of a training between two reports of its progress.
const REPORT_EVERY: u32 = 25;

/// The end of work on a look.
enum Fault {
    /// The appearance cannot be made.
    Look(bendtwin_appearance::Error),
    /// The fit must end.
    Fit(Error),
}

impl From<bendtwin_appearance::Error> for Fault {
    fn from(error: bendtwin_appearance::Error) -> Self {
        Self::Look(error)
    }
}

impl From<Error> for Fault {
    fn from(error: Error) -> Self {
        Self::Fit(error)
    }
}

impl Run<'_> {
    /// Gives the twins of an outcome their looks and measures these, if there are views.
    pub(super) fn dress(&mut self, outcome: &mut Outcome) -> Result<(), Error> {
        let job = self.job;
        let Some(look) = &job.look else { return Ok(()) };
        let mut rasteriser = match (look.rasteriser)() {
            Ok(rasteriser) => rasteriser,
            Err(error) => {
                warn(&mut outcome.twin, &error);
                return Ok(());
            }
        };
        let twins = std::iter::once(&mut outcome.twin).chain(&mut outcome.axial);
        for (index, twin) in twins.enumerate() {
            let rendered = match self.dress_one(index, look, twin, &mut *rasteriser) {
                Ok(rendered) => rendered,
                Err(Fault::Fit(error)) => return Err(error),
                Err(Fault::Look(error)) => {
                    warn(twin, &error.to_string());
                    continue;
                }
            };
            if let Some(own) = twin.quality.scores.first_mut() {
                own.rendered = rendered;
            }
        }
        // The axial row of the twin's own table.
        if let Some(own) = outcome.axial.as_ref().and_then(|axial| axial.quality.scores.first()) {
            let rows = outcome.twin.quality.scores.iter_mut();
            for row in rows.filter(|row| row.predictor == own.predictor) {
                row.rendered.clone_from(&own.rendered);
            }
        }
        Ok(())
    }

    fn dress_one(
        &mut self,
        index: usize,
        look: &Look<'_>,
        twin: &mut Twin,
        rasteriser: &mut dyn Rasteriser,
    ) -> Result<Option<RenderedScore>, Fault> {
        let (job, cancel) = (self.job, self.cancel);
        let predicted = Predicted::new(twin, job.capture, &*job.backend, cancel)?;
        let Some(predicted) = predicted else { return Ok(None) };
        let motion = predicted.motion();
        let settings = self.task.settings.appearance.clone();
        let skin_colors = skin_colors(twin, &motion, look.views, &settings.held_out_cameras)?;
        let splats = match settings.gaussians.unwrap_or_default() {
            0 => None,
            _ => Some(self.train(index, look, twin, motion, &skin_colors, rasteriser)?),
        };
        let appearance = Appearance { skin_colors, splats };
        let dressed = Dressed::in_appearance(twin, &appearance)?;
        let held_out = &settings.held_out_cameras;
        let scene = Scene { dressed: &dressed, motion, views: look.views, held_out };
        let rendered = score(&scene, rasteriser, false, &mut || !cancel.is_cancelled())?;
        self.check_cancelled()?;
        twin.appearance = Some(appearance);
        Ok(rendered)
    }

    /// Trains the Gaussians of a twin, from its checkpoint if there is one.
    fn train(
        &mut self,
        index: usize,
        look: &Look<'_>,
        twin: &Twin,
        motion: Motion<'_>,
        colors: &[[u8; 3]],
        rasteriser: &mut dyn Rasteriser,
    ) -> Result<Splats, Fault> {
        let settings = &self.task.settings.appearance;
        let options = TrainingOptions {
            gaussians: settings.gaussians.unwrap_or_default() as usize,
            steps: settings.steps,
            isotropic: settings.isotropic,
            max_frames: settings.max_frames,
            held_out: settings.held_out_cameras.clone(),
            seed: self.task.settings.seed,
        };
        let (steps, bending) = (options.steps, self.models[0].bending && index == 0);
        let mut training = Training::new(twin, motion, look.views, colors, options)?;
        if let Some(checkpoint) = self.trainings.get(index) {
            training.restore(checkpoint)?;
        }
        let mut best = None;
        while !training.is_done() && !self.is_out_of_time() {
            self.check_cancelled()?;
            let step = training.step(rasteriser)?;
            best = Some(best.map_or(step.loss, |least: f64| least.min(step.loss)));
            if step.done.is_multiple_of(REPORT_EVERY) || step.done == steps {
                self.report(ModelProgress {
                    model: model_name(bending).to_owned(),
                    stage: Stage::Appearance,
                    iteration: index as u32 * steps + step.done,
                    loss: Some(step.loss),
                    best_loss: best,
                    note: None,
                    preview: None,
                });
            }
            if step.settled || step.done == steps {
                self.trainings.truncate(index);
                self.trainings.push(training.checkpoint()?);
                self.keep()?;
            }
        }
        Ok(training.splats())
    }

    /// True if the user's time is up.
    fn is_out_of_time(&self) -> bool {
        let limit_s = self.task.settings.within_s;
        let spent_s = self.limit.as_ref().map(TimeLimit::spent_s);
        limit_s.zip(spent_s).is_some_and(|(limit_s, spent_s)| spent_s > limit_s)
    }
}

fn warn(twin: &mut Twin, why: &str) {
    twin.quality.warnings.push(format!("the twin has no appearance: {why}"));
}
