//! The first-order stage: Adam on every spring and triplet, all variants side by side in each batch.
//! Parameters and gradients stay with the backend's [`Optimizer`]; what comes back are losses and lengths.

mod pace;
mod schedule;
mod walk;
mod windows;

use std::{
    collections::{BTreeMap, BTreeSet},
    sync::Arc,
};

use bendtwin_core::CancelToken;
use bendtwin_engine::{
    Backend,
    backend::{GradientRequest, Instance},
    model::State,
    optimizer::{Decay, GradientNorm, GradientSample, Optimizer, OptimizerInit},
};

pub(crate) use self::walk::{Walk, WalkState};
use self::{schedule::Step, windows::Windows};
use crate::{Error, submit, task::Task};

/// The refinement of all variants.
pub(crate) struct Refinement<'a> {
    /// One per variant, in the order of the fit.
    pub(crate) walks: Vec<Walk<'a>>,
    optimizer: Box<dyn Optimizer>,
    windows: Windows,
    task: &'a Task<'a>,
    backend: &'a dyn Backend,
    cancel: &'a CancelToken,
}

impl<'a> Refinement<'a> {
    /// Of walks that stand at their starts.
    pub(crate) fn new(
        task: &'a Task<'a>,
        walks: Vec<(Walk<'a>, OptimizerInit)>,
        backend: &'a dyn Backend,
        cancel: &'a CancelToken,
    ) -> Result<Self, Error> {
        let (walks, starts): (Vec<_>, Vec<_>) = walks.into_iter().unzip();
        let refine = &task.settings.refine;
        let decay = Decay { beta1: refine.beta1, beta2: refine.beta2, prior: refine.prior };
        let optimizer = backend.optimizer(starts, decay)?;
        Ok(Self { walks, optimizer, windows: Windows::default(), task, backend, cancel })
    }

    /// Measures where the variants start, so that none can end worse than it began; left to the first
    /// pass if that does it.
    pub(crate) fn begin(&mut self) -> Result<(), Error> {
        let passes = self.task.settings.refine.passes;
        let first_does = passes > 0 && schedule::steps(self.task, 0).len() == 1;
        if first_does { Ok(()) } else { self.score() }
    }

    /// One pass of all variants over the training frames.
    ///
    /// A variant whose simulation or gradient is not finite goes back to its best parameters with half
    /// the rate and sits out the rest of the pass; the others are not disturbed.
    ///
    /// A pass of several steps ends by measuring where they led. A pass of a single step needs no more than
    /// its gradient: the losses that come with it tell how good the parameters are where the pass begins,
    /// and the next pass tells the same of where this one ends. Only the last pass has none after it.
    pub(crate) fn pass(&mut self) -> Result<(), Error> {
        let Some(pass) = self.walks.first().map(|w| w.state.pass) else { return Ok(()) };
        let initial: Vec<_> = self.task.training.iter().map(|t| t.initial.clone()).collect();
        // States at the start of the next window, by variant and sequence.
        let mut states = vec![initial; self.walks.len()];
        self.walks.iter_mut().for_each(Walk::begin_pass);
        let steps = schedule::steps(self.task, pass);
        match &steps[..] {
            [only] => self.judge_and_step(&states, only)?,
            several => {
                for step in several {
                    self.run_step(&mut states, step)?;
                }
            }
        }
        for (index, walk) in self.walks.iter_mut().enumerate() {
            walk.arrive(index, &mut *self.optimizer)?;
        }
        let is_last = pass + 1 >= self.task.settings.refine.passes;
        if is_last || steps.len() > 1 {
            self.score()?;
        }
        self.walks.iter_mut().for_each(Walk::end_pass);
        Ok(())
    }

    fn run_step(&mut self, states: &mut [Vec<Arc<State>>], step: &Step) -> Result<(), Error> {
        let active = self.active();
        for (index, own) in self.measure(&active, states, step)? {
            self.walks[index].learn(index, &own, &mut *self.optimizer)?;
            for (slope, window) in own.into_iter().zip(&step.windows) {
                if let Some(state) = slope.final_state {
                    states[index][window.sequence] = Arc::new(state);
                }
            }
        }
        Ok(())
    }

    /// The only step of a pass: it sees all training frames from their start. Who goes back
    /// to better parameters steps from there.
    fn judge_and_step(&mut self, states: &[Vec<Arc<State>>], step: &Step) -> Result<(), Error> {
        let (active, mut back) = (self.active(), Vec::new());
        for (index, slopes) in self.measure(&active, states, step)? {
            let (walk, optimizer) = (&mut self.walks[index], &mut *self.optimizer);
            let loss = self.task.loss(slopes.iter().map(|s| s.loss.total));
            walk.judge(index, loss, optimizer)?;
            if walk.is_active() {
                walk.learn(index, &slopes, optimizer)?;
            } else {
                walk.set_out();
                back.push(index);
            }
        }
        back.retain(|&index| self.walks[index].is_active());
        for (index, slopes) in self.measure(&back, states, step)? {
            self.walks[index].learn(index, &slopes, &mut *self.optimizer)?;
        }
        Ok(())
    }

    fn active(&self) -> Vec<usize> {
        (0..self.walks.len()).filter(|&walk| self.walks[walk].is_active()).collect()
    }

    /// Gradients of these walks over the windows of a step, by walk.
    fn measure(
        &mut self,
        walks: &[usize],
        states: &[Vec<Arc<State>>],
        step: &Step,
    ) -> Result<BTreeMap<usize, Vec<GradientNorm>>, Error> {
        let mut slopes_of = BTreeMap::new();
        // One batch for all whose gradients reach equally far, as they nearly always do.
        let reaches: BTreeSet<usize> = walks.iter().map(|&walk| self.walks[walk].reach()).collect();
        for reach in reaches {
            let reaches_so_far = |walk: &usize| self.walks[*walk].reach() == reach;
            let members: Vec<usize> = walks.iter().copied().filter(reaches_so_far).collect();
            let mut batch = Vec::with_capacity(members.len() * step.windows.len());
            for &walk in &members {
                let model = &self.walks[walk].loaded;
                batch.extend(step.windows.iter().map(|window| {
                    let from = states[walk][window.sequence].clone();
                    GradientSample {
                        run: walk,
                        instance: self.windows.instance(self.task, model, window, from),
                    }
                }));
            }
            let request = GradientRequest {
                cut_every: reach,
                final_state: step.goes_on,
                ..GradientRequest::default()
            };
            let slice = submit::slice_len(self.backend);
            let optimizer = &mut *self.optimizer;
            let slopes = submit::sliced(&batch, slice, self.cancel, |slice| {
                optimizer.measure(slice, &request, self.cancel)
            })?;
            let mut slopes = slopes.into_iter();
            for walk in members {
                slopes_of.insert(walk, slopes.by_ref().take(step.windows.len()).collect());
            }
        }
        Ok(slopes_of)
    }

    /// Measures the parameters where every variant is on all training frames, and keeps the best.
    fn score(&mut self) -> Result<(), Error> {
        let training = &self.task.training;
        let mut batch: Vec<Instance> = Vec::with_capacity(self.walks.len() * training.len());
        for walk in &self.walks {
            batch.extend(training.iter().map(|t| t.instance(&walk.loaded)));
        }
        let losses = submit::losses(self.backend, &batch, self.cancel)?;
        let own = losses.chunks(training.len());
        for (index, (walk, own)) in self.walks.iter_mut().zip(own).enumerate() {
            let loss = self.task.loss(own.iter().map(|l| l.total));
            walk.judge(index, loss, &mut *self.optimizer)?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests;
