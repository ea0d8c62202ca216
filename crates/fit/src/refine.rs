//! The first-order stage: Adam on every spring and triplet, all variants side by side in each batch.
//! Parameters and gradients stay with the backend's [`Descent`]; what comes back are losses and lengths.

mod schedule;
mod walk;
mod windows;

use std::sync::Arc;

use bendtwin_engine::{
    Backend,
    backend::{CancelToken, GradientRequest, Instance},
    descent::{Decay, Descent, Probe, Slope, Start},
    model::State,
};

pub(crate) use self::walk::{Walk, WalkState};
use self::{schedule::Step, windows::Windows};
use crate::{Error, submit, task::Task};

/// The refinement of all variants.
pub(crate) struct Refinement<'a> {
    /// One per variant, in the order of the fit.
    pub(crate) walks: Vec<Walk<'a>>,
    descent: Box<dyn Descent>,
    windows: Windows,
    task: &'a Task<'a>,
    backend: &'a dyn Backend,
    cancel: &'a CancelToken,
}

impl<'a> Refinement<'a> {
    /// Of walks that stand at their starts.
    pub(crate) fn new(
        task: &'a Task<'a>,
        walks: Vec<(Walk<'a>, Start)>,
        backend: &'a dyn Backend,
        cancel: &'a CancelToken,
    ) -> Result<Self, Error> {
        let (walks, starts): (Vec<_>, Vec<_>) = walks.into_iter().unzip();
        let refine = &task.settings.refine;
        let decay = Decay { beta1: refine.beta1, beta2: refine.beta2 };
        let descent = backend.descent(starts, decay)?;
        Ok(Self { walks, descent, windows: Windows::default(), task, backend, cancel })
    }

    /// One pass of all variants over the training frames.
    ///
    /// A variant whose simulation or gradient is not finite goes back to its best parameters with half
    /// the rate and sits out the rest of the pass; the others are not disturbed.
    pub(crate) fn pass(&mut self) -> Result<(), Error> {
        let Some(pass) = self.walks.first().map(|w| w.state.pass) else { return Ok(()) };
        let initial: Vec<_> = self.task.training.iter().map(|t| t.initial.clone()).collect();
        // States at the start of the next window, by variant and sequence.
        let mut states = vec![initial; self.walks.len()];
        self.walks.iter_mut().for_each(Walk::begin_pass);
        for step in schedule::steps(self.task, pass) {
            self.run_step(&mut states, &step)?;
        }
        for (index, walk) in self.walks.iter_mut().enumerate() {
            walk.arrive(index, &mut *self.descent)?;
        }
        self.score()?;
        self.walks.iter_mut().for_each(Walk::end_pass);
        Ok(())
    }

    fn run_step(&mut self, states: &mut [Vec<Arc<State>>], step: &Step) -> Result<(), Error> {
        // One batch for all variants whose gradients reach equally far, as they nearly always do.
        let mut results: Vec<Option<Vec<Slope>>> = self.walks.iter().map(|_| None).collect();
        let active = self.walks.iter().filter(|w| w.is_active());
        let mut reaches: Vec<usize> = active.map(Walk::reach).collect();
        reaches.sort_unstable();
        reaches.dedup();
        for reach in reaches {
            let members: Vec<usize> = (0..self.walks.len())
                .filter(|&i| self.walks[i].is_active() && self.walks[i].reach() == reach)
                .collect();
            let mut batch = Vec::with_capacity(members.len() * step.windows.len());
            for &walk in &members {
                let model = &self.walks[walk].loaded;
                batch.extend(step.windows.iter().map(|window| {
                    let from = states[walk][window.sequence].clone();
                    Probe { walk, instance: self.windows.instance(self.task, model, window, from) }
                }));
            }
            let request = GradientRequest {
                cut_every: reach,
                final_state: step.goes_on,
                ..GradientRequest::default()
            };
            let slice = submit::slice_len(self.backend);
            let descent = &mut *self.descent;
            let slopes = submit::sliced(&batch, slice, self.cancel, |slice| {
                descent.measure(slice, &request, self.cancel)
            })?;
            let mut slopes = slopes.into_iter();
            for i in members {
                results[i] = Some(slopes.by_ref().take(step.windows.len()).collect());
            }
        }
        for (index, result) in results.into_iter().enumerate() {
            let Some(own) = result else { continue };
            self.walks[index].learn(index, &own, &mut *self.descent)?;
            for (slope, window) in own.into_iter().zip(&step.windows) {
                if let Some(state) = slope.final_state {
                    states[index][window.sequence] = Arc::new(state);
                }
            }
        }
        Ok(())
    }

    /// Measures the parameters where every variant arrived on all training frames and keeps the best; done
    /// before the first pass too, so that none can end worse than it began.
    pub(crate) fn score(&mut self) -> Result<(), Error> {
        let training = &self.task.training;
        let mut batch: Vec<Instance> = Vec::with_capacity(self.walks.len() * training.len());
        for walk in &self.walks {
            batch.extend(training.iter().map(|t| t.instance(&walk.loaded)));
        }
        let losses = submit::losses(self.backend, &batch, self.cancel)?;
        let own = losses.chunks(training.len());
        for (index, (walk, own)) in self.walks.iter_mut().zip(own).enumerate() {
            let loss = own.iter().map(|l| l.total).sum::<f64>() / own.len() as f64;
            walk.judge(index, loss, &mut *self.descent)?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests;
