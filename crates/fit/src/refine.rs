//! The first-order stage: Adam on every spring and triplet, all models side by side in each batch.
//! Parameters and gradients stay with the backend's [`Optimizer`], which returns losses and
//! gradient norms.

mod average;
mod optimizer_run;
mod parameterization;
mod schedule;
mod step_control;
mod windows;

use std::{
    collections::{BTreeMap, BTreeSet},
    sync::Arc,
};

use bendtwin_core::CancelToken;
use bendtwin_engine::{
    Backend, Loaded,
    backend::{GradientRequest, Instance},
    model::State,
    optimizer::{Decay, GradientNorm, GradientSample, Optimizer, OptimizerInit},
};

pub(crate) use self::optimizer_run::{OptimizerRun, RunState};
use self::{average::Average, schedule::Step, windows::Windows};
use crate::{Error, submit, task::Task};

/// The refinement of all models.
pub(crate) struct Refinement<'a> {
    /// A run per model, in the order of the fit.
    pub(crate) runs: Vec<OptimizerRun<'a>>,
    optimizer: Box<dyn Optimizer>,
    windows: Windows,
    task: &'a Task<'a>,
    backend: &'a dyn Backend,
    cancel: &'a CancelToken,
}

impl<'a> Refinement<'a> {
    /// A refinement of these runs, each with the optimizer's initial state.
    pub(crate) fn new(
        task: &'a Task<'a>,
        runs: Vec<(OptimizerRun<'a>, OptimizerInit)>,
        backend: &'a dyn Backend,
        cancel: &'a CancelToken,
    ) -> Result<Self, Error> {
        let (runs, inits): (Vec<_>, Vec<_>) = runs.into_iter().unzip();
        let refine = &task.settings.refine;
        let decay = Decay {
            beta1: refine.beta1,
            beta2: refine.beta2,
            prior: refine.prior.unwrap_or_default(),
        };
        let optimizer = backend.optimizer(inits, decay)?;
        Ok(Self { runs, optimizer, windows: Windows::default(), task, backend, cancel })
    }

    /// Scores the initial parameters, so that no model can end worse than it began; left to the
    /// first pass if that scores them anyway.
    pub(crate) fn begin(&mut self) -> Result<(), Error> {
        let passes = self.task.passes();
        let first_does = passes > 0 && schedule::is_single_step(self.task);
        if first_does { Ok(()) } else { self.score() }
    }

    /// Runs a pass of all models over the training frames.
    ///
    /// A model whose simulation or gradient is not finite returns to its best parameters with half
    /// the rate and pauses for the rest of the pass; the others are not affected.
    ///
    /// A pass of several steps ends by scoring the parameters that it led to. A pass of a single
    /// step needs nothing beside its gradient: the losses computed with it score the parameters at
    /// which the pass begins, and the next pass scores those at which this one ends. Only the last
    /// pass has none after it.
    pub(crate) fn pass(&mut self) -> Result<(), Error> {
        let Some((pass, passes)) = self.next_pass() else { return Ok(()) };
        let initial: Vec<_> = self.task.training.iter().map(|t| t.source.initial.clone()).collect();
        // States at the start of the next window, by model and sequence.
        let mut states = vec![initial; self.runs.len()];
        self.runs.iter_mut().for_each(OptimizerRun::begin_pass);
        let steps = schedule::steps(self.task, pass);
        match &steps[..] {
            [only] => self.record_and_step(&states, only)?,
            several => {
                for step in several {
                    self.run_step(&mut states, step)?;
                }
            }
        }
        for (index, run) in self.runs.iter_mut().enumerate() {
            run.sync(index, &mut *self.optimizer)?;
        }
        if steps.len() == 1 && Average::is_due(pass) {
            self.score_averages()?;
        }
        let is_last = pass + 1 >= passes;
        if is_last || steps.len() > 1 {
            self.score()?;
        }
        self.runs.iter_mut().for_each(OptimizerRun::end_pass);
        Ok(())
    }

    fn run_step(&mut self, states: &mut [Vec<Arc<State>>], step: &Step) -> Result<(), Error> {
        let active = self.active();
        for (index, own) in self.measure(&active, states, step)? {
            self.runs[index].step(index, &own, &mut *self.optimizer)?;
            for (gradient, window) in own.into_iter().zip(&step.windows) {
                if let Some(state) = gradient.final_state {
                    states[index][window.sequence] = Arc::new(state);
                }
            }
        }
        Ok(())
    }

    /// The only step of a pass, over all training frames from their start. A run that rolls back to
    /// better parameters steps from those.
    fn record_and_step(&mut self, states: &[Vec<Arc<State>>], step: &Step) -> Result<(), Error> {
        let (active, mut back) = (self.active(), Vec::new());
        for (index, gradients) in self.measure(&active, states, step)? {
            let (run, optimizer) = (&mut self.runs[index], &mut *self.optimizer);
            let loss = self.task.loss(gradients.iter().map(|g| g.loss.total));
            run.record_loss(index, loss, optimizer)?;
            if run.is_active() {
                run.step(index, &gradients, optimizer)?;
            } else {
                run.resume();
                back.push(index);
            }
        }
        back.retain(|&index| self.runs[index].is_active());
        for (index, gradients) in self.measure(&back, states, step)? {
            self.runs[index].step(index, &gradients, &mut *self.optimizer)?;
        }
        Ok(())
    }

    fn active(&self) -> Vec<usize> {
        (0..self.runs.len()).filter(|&run| self.runs[run].is_active()).collect()
    }

    /// Gradients of these runs over the windows of a step, by run.
    fn measure(
        &mut self,
        runs: &[usize],
        states: &[Vec<Arc<State>>],
        step: &Step,
    ) -> Result<BTreeMap<usize, Vec<GradientNorm>>, Error> {
        let mut gradients_of = BTreeMap::new();
        // One batch per reach; nearly always all runs have the same.
        let reaches: BTreeSet<usize> = runs.iter().map(|&run| self.runs[run].reach()).collect();
        for reach in reaches {
            let reaches_so_far = |run: &usize| self.runs[*run].reach() == reach;
            let members: Vec<usize> = runs.iter().copied().filter(reaches_so_far).collect();
            let mut batch = Vec::with_capacity(members.len() * step.windows.len());
            for &run in &members {
                let model = &self.runs[run].loaded;
                batch.extend(step.windows.iter().map(|window| {
                    let from = states[run][window.sequence].clone();
                    GradientSample {
                        run,
                        instance: self.windows.instance(self.task, model, window, from),
                    }
                }));
            }
            let request = GradientRequest {
                cut_every: reach,
                final_state: step.has_next,
                ..GradientRequest::default()
            };
            let slice = submit::slice_len(self.backend);
            let optimizer = &mut *self.optimizer;
            let gradients = submit::sliced(&batch, slice, self.cancel, |slice| {
                optimizer.measure(slice, &request, self.cancel)
            })?;
            let mut gradients = gradients.into_iter();
            for run in members {
                gradients_of.insert(run, gradients.by_ref().take(step.windows.len()).collect());
            }
        }
        Ok(gradients_of)
    }

    /// Number of the next pass, counted from 0, and of all passes; none if all runs are done. Runs that
    /// have ended stay at the pass that was their last.
    pub(crate) fn next_pass(&self) -> Option<(u32, u32)> {
        let open = self.runs.iter().filter(|r| !r.state.is_done());
        open.map(|r| (r.state.pass, r.state.passes)).next()
    }

    /// Scores the mean of the last positions of every active run.
    fn score_averages(&mut self) -> Result<(), Error> {
        let (mut scored, mut averages) = (Vec::new(), Vec::new());
        for run in self.active() {
            if let Some(average) = self.runs[run].average(self.backend)? {
                scored.push(run);
                averages.push(average);
            }
        }
        for (run, loss) in scored.into_iter().zip(self.losses(&averages)?) {
            self.runs[run].record_average(loss);
        }
        Ok(())
    }

    /// Scores the current parameters of every model on all training frames, and keeps the best.
    fn score(&mut self) -> Result<(), Error> {
        let current: Vec<Loaded> = self.runs.iter().map(|run| run.loaded.clone()).collect();
        let losses = self.losses(&current)?;
        for (index, (run, loss)) in self.runs.iter_mut().zip(losses).enumerate() {
            run.record_loss(index, loss, &mut *self.optimizer)?;
        }
        Ok(())
    }

    /// Losses of models over all training frames, from one batch.
    fn losses(&self, models: &[Loaded]) -> Result<Vec<f64>, Error> {
        let training = &self.task.training;
        let of = |model| training.iter().map(move |t| t.instance(model));
        let batch: Vec<Instance> = models.iter().flat_map(of).collect();
        let losses = submit::losses(self.backend, &batch, self.cancel)?;
        let own = losses.chunks(training.len());
        Ok(own.map(|own| self.task.loss(own.iter().map(|l| l.total))).collect())
    }
}

#[cfg(test)]
mod tests;
