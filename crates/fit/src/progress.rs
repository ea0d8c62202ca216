//! Progress of a fit in units of simulated frames, and the estimated time to its end.

use std::{sync::Arc, time::Instant};

use bendtwin_core::{Preview, Progress, Stage};

use crate::task::Task;

/// Cost of a frame with its gradient, relative to a frame without, scoring included.
const GRADIENT_COST: f64 = 5.0;
/// Share of the work on the twin that evaluation takes.
const EVALUATION_SHARE: f64 = 0.02;
/// Share of the job that the training of Gaussians takes, where there is one.
pub(crate) const APPEARANCE_SHARE: f64 = 0.5;

/// The planned work of a fit, to estimate progress by.
pub(crate) struct ProgressEstimator {
    generation_frames: f64,
    pass_frames: f64,
    generations: u32,
    passes: u32,
    /// Steps of the training of Gaussians.
    steps: u32,
    /// Time and fraction done at this process's first report.
    origin: Option<(Instant, f64)>,
    /// Error of the newest preview [m].
    error_m: Option<f64>,
}

/// Progress of one model.
pub(crate) struct ModelProgress {
    pub(crate) model: String,
    pub(crate) stage: Stage,
    /// Completed iterations of the stage.
    pub(crate) iteration: u32,
    pub(crate) loss: Option<f64>,
    pub(crate) best_loss: Option<f64>,
    pub(crate) note: Option<String>,
    /// The preview that was made of it in this iteration.
    pub(crate) preview: Option<Arc<Preview>>,
}

impl ModelProgress {
    /// Progress without losses, note and preview.
    pub(crate) fn new(model: &str, stage: Stage, iteration: u32) -> Self {
        let (loss, best_loss, note, preview) = (None, None, None, None);
        Self { model: model.to_owned(), stage, iteration, loss, best_loss, note, preview }
    }
}

impl ProgressEstimator {
    pub(crate) fn new(task: &Task<'_>, search_frames: usize, population: usize) -> Self {
        let frames: usize = task.training.iter().map(|t| t.frames).sum();
        Self {
            generation_frames: (search_frames * population) as f64,
            pass_frames: frames as f64 * GRADIENT_COST,
            generations: task.generations(),
            passes: task.passes(),
            steps: 0,
            origin: None,
            error_m: None,
        }
    }

    /// Takes over the number of generations that a time limit allows.
    pub(crate) fn set_generations(&mut self, generations: u32) {
        self.generations = generations;
    }

    /// Takes over the number of passes that a time limit allows.
    pub(crate) fn set_passes(&mut self, passes: u32) {
        self.passes = passes;
    }

    /// Takes over the number of steps in which Gaussians are trained after the evaluation.
    pub(crate) fn set_steps(&mut self, steps: u32) {
        self.steps = steps;
    }

    fn fraction(&self, stage: Stage, iteration: u32) -> f64 {
        let of_appearance = if self.steps > 0 { APPEARANCE_SHARE } else { 0.0 };
        if stage == Stage::Appearance {
            let done = f64::from(iteration) / f64::from(self.steps.max(1));
            return 1.0 - of_appearance * (1.0 - done);
        }
        (1.0 - of_appearance) * self.fraction_of_twin(stage, iteration)
    }

    fn fraction_of_twin(&self, stage: Stage, iteration: u32) -> f64 {
        let search = self.generation_frames * f64::from(self.generations);
        let refine = self.pass_frames * f64::from(self.passes);
        let total = search + refine;
        let done = match stage {
            Stage::Ingest => 0.0,
            Stage::Search => self.generation_frames * f64::from(iteration),
            Stage::Refine => search + self.pass_frames * f64::from(iteration),
            Stage::Evaluate | Stage::Appearance => total,
        };
        let share = if total > 0.0 { done / total } else { 1.0 };
        if stage == Stage::Evaluate && iteration > 0 {
            return 1.0;
        }
        if stage == Stage::Ingest { 0.0 } else { share * (1.0 - EVALUATION_SHARE) }
    }

    /// A model's progress with the fraction of the whole fit that is done, and the time left.
    pub(crate) fn progress(&mut self, report: ModelProgress) -> Progress {
        let fraction = self.fraction(report.stage, report.iteration);
        let (began, from) = *self.origin.get_or_insert_with(|| (Instant::now(), fraction));
        let gained = fraction - from;
        let eta_s = (gained > 1e-3)
            .then(|| began.elapsed().as_secs_f64() / gained * (1.0 - fraction).max(0.0));
        if let Some(preview) = &report.preview {
            self.error_m = Some(preview.errors.error_m);
        }
        Progress {
            stage: report.stage,
            variant: report.model,
            iteration: report.iteration,
            iterations: match report.stage {
                Stage::Search => self.generations,
                Stage::Refine => self.passes,
                Stage::Ingest | Stage::Evaluate => 1,
                Stage::Appearance => self.steps,
            },
            fraction,
            loss: report.loss.filter(|l| l.is_finite()),
            best_loss: report.best_loss.filter(|l| l.is_finite()),
            eta_s,
            note: report.note,
            models: Vec::new(),
            error_m: self.error_m,
            preview: report.preview,
        }
    }
}
