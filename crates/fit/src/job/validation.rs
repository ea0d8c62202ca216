//! Frames that are held back from several starts, to choose the one that predicts them best.
//!
//! The training loss does not show which of two starts predicts better: each matches the frames
//! that it was fitted to, and they diverge after these. So all starts are searched and refined
//! without the last training frames, and the search result of the start that predicts these best is
//! then refined again on all of them: parameters refined without them would keep the traces of
//! that.

use std::sync::Arc;

use bendtwin_core::CancelToken;
use bendtwin_engine::{Backend, Model, Objective, backend::Instance};

use crate::{Error, refine::OptimizerRun, submit, task::Task};

/// Fewest frames to hold back of the longest sequence; fewer say nothing.
const LEAST_FRAMES: usize = 5;
/// Passes of all starts, over those that the chosen one makes on all training frames.
const SHARE_OF_PASSES: f64 = 0.5;

/// The frames that are held back.
pub(crate) struct Validation<'a> {
    /// The fit's task without them, and with the passes of all starts.
    pub(crate) shorter: Task<'a>,
    /// The fit's task.
    task: &'a Task<'a>,
    /// Their loss, by sequence.
    objectives: Vec<Objective>,
    /// Frames held back of the longest sequence.
    pub(crate) frames: u32,
}

impl<'a> Validation<'a> {
    /// `None` where a single start leaves no choice, or where settings or capture leave nothing to
    /// hold back.
    pub(crate) fn new(task: &'a Task<'a>) -> Option<Self> {
        let share = task.settings.search.held_back;
        if task.settings.search.start_count() < 2 || share <= 0.0 {
            return None;
        }
        let mut shorter = task.without_last(share)?;
        let passes = f64::from(task.passes()) * SHARE_OF_PASSES;
        shorter.settings.refine.passes = Some(passes.ceil() as u32);
        let pairs = || task.training.iter().zip(&shorter.training);
        let frames = pairs().map(|(all, kept)| all.frames - kept.frames).max()?;
        let objectives: Vec<Objective> =
            pairs().map(|(all, kept)| all.after(kept.frames)).collect();
        let says_something = objectives.iter().any(|o| !o.terms.is_empty());
        (frames >= LEAST_FRAMES && says_something).then_some(Self {
            shorter,
            task,
            objectives,
            frames: frames as u32,
        })
    }

    /// Losses of the runs' best parameters over the frames held back, by run; infinite where a
    /// simulation diverges.
    pub(crate) fn losses(
        &self,
        runs: &[OptimizerRun<'_>],
        backend: &dyn Backend,
        cancel: &CancelToken,
    ) -> Result<Vec<f64>, Error> {
        let mut batch: Vec<Instance> = Vec::with_capacity(runs.len() * self.objectives.len());
        for run in runs {
            let (params, timing) = run.best();
            let model = Model { params, timing, ..Model::clone(run.loaded.model()) };
            let loaded = backend.load(Arc::new(model))?;
            let measured = self.task.training.iter().zip(&self.objectives);
            batch.extend(measured.map(|(training, objective)| Instance {
                objective: objective.clone(),
                ..training.instance(&loaded)
            }));
        }
        let losses = submit::losses(backend, &batch, cancel)?;
        let of_runs = losses.chunks(self.objectives.len());
        let total = |l: &bendtwin_engine::backend::Loss| match l.diverged {
            None => l.total,
            Some(_) => f64::INFINITY,
        };
        Ok(of_runs.map(|own| self.task.loss(own.iter().map(total))).collect())
    }
}

#[cfg(test)]
mod tests;
