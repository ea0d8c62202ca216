//! The refinement of one model: its best parameters, the length of its steps, and when it returns
//! to the best parameters. The engine's optimizer takes the steps and holds the current position.

use std::sync::Arc;

use bendtwin_core::{Environment, Graph, Params, Timing, settings::Substeps};
use bendtwin_engine::{
    Backend, Loaded, Model, enough_substeps,
    fidelity::Reduction,
    optimizer::{GradientNorm, Optimizer, OptimizerInit, Parameterization, Position},
};
use serde::{Deserialize, Serialize};

use crate::{
    Error,
    built_graph::{LoadError, build_model, load},
    refine::{
        average::Average,
        parameterization::parameterization,
        schedule,
        step_control::{Schedule, StepControl},
    },
    task::{Task, sequences},
};

/// Margin of stability below which substeps are added.
const MIN_MARGIN: f64 = 1.15;

/// The part of a run that a checkpoint keeps.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct RunState {
    /// Passes that are done.
    pub(crate) pass: u32,
    /// Passes in all.
    pub(crate) passes: u32,
    /// Position after the last pass.
    position: Position,
    substeps: u32,
    step_control: StepControl,
    /// Mean of the last positions, where a pass is a single step.
    average: Average,
    /// True if passes make no gain any more.
    pub(crate) has_ended: bool,
    /// The last loss measured over all training frames: at the start of the last pass if that was a
    /// single step, otherwise at its end.
    pub(crate) loss: f64,
    pub(crate) best: Best,
}

impl RunState {
    /// True if no pass is left to make.
    pub(crate) fn is_done(&self) -> bool {
        self.has_ended || self.pass >= self.passes
    }
}

/// The best parameters so far, by their loss over all training frames.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Best {
    theta: Vec<f64>,
    substeps: u32,
    pub(crate) loss: f64,
}

/// The optimizer run that refines one model.
pub(crate) struct OptimizerRun<'a> {
    /// Index of the model in the fit.
    pub(crate) model: usize,
    pub(crate) state: RunState,
    pub(crate) graph: Arc<Graph>,
    /// The model as of the last call of [`OptimizerRun::sync`]; within a pass the optimizer is
    /// ahead of it.
    pub(crate) loaded: Loaded,
    /// A message for people about the last pass.
    pub(crate) note: Option<String>,
    parameterization: Parameterization,
    paused: bool,
    task: &'a Task<'a>,
}

impl<'a> OptimizerRun<'a> {
    /// A run from the parameters that the search found.
    pub(crate) fn new(
        model: usize,
        task: &'a Task<'a>,
        graph: Arc<Graph>,
        params: Params,
        environment: Environment,
        backend: &dyn Backend,
    ) -> Result<(Self, OptimizerInit), Error> {
        let parameterization = parameterization(task, params);
        let position = parameterization.at_rest(parameterization.start());
        let params = parameterization.params(&position.theta);
        let initial = build_model(task, &graph, params, environment)?;
        let substeps = initial.timing.substeps;
        let loaded = load(backend, initial)?;
        let best = Best { theta: position.theta.clone(), substeps, loss: f64::INFINITY };
        let state = RunState {
            pass: 0,
            passes: task.passes(),
            position,
            substeps,
            step_control: StepControl::new(task.settings.refine.reach.unwrap_or_default()),
            average: Average::default(),
            has_ended: false,
            loss: f64::INFINITY,
            best,
        };
        Ok(Self::at(model, task, graph, loaded, parameterization, state))
    }

    /// A run from a checkpoint; `params` are those that the search found.
    pub(crate) fn restore(
        model: usize,
        task: &'a Task<'a>,
        graph: Arc<Graph>,
        params: Params,
        environment: Environment,
        state: RunState,
        backend: &dyn Backend,
    ) -> Result<(Self, OptimizerInit), Error> {
        let parameterization = parameterization(task, params);
        let best = parameterization.at_rest(state.best.theta.clone());
        for position in [&state.position, &best] {
            parameterization
                .check_position(position)
                .map_err(|e| Error::Checkpoint(e.to_string()))?;
        }
        let params = parameterization.params(&state.position.theta);
        let mut current = build_model(task, &graph, params, environment)?;
        current.timing.substeps = state.substeps;
        let loaded = load(backend, current)?;
        Ok(Self::at(model, task, graph, loaded, parameterization, state))
    }

    fn at(
        model: usize,
        task: &'a Task<'a>,
        graph: Arc<Graph>,
        loaded: Loaded,
        parameterization: Parameterization,
        state: RunState,
    ) -> (Self, OptimizerInit) {
        let init = OptimizerInit {
            loaded: loaded.clone(),
            parameterization: parameterization.clone(),
            position: state.position.clone(),
        };
        let (note, paused) = (None, false);
        (Self { model, state, graph, loaded, note, parameterization, paused, task }, init)
    }

    /// True if the run takes part in the steps of this pass.
    pub(crate) fn is_active(&self) -> bool {
        !self.paused
    }

    /// Reach of this run's gradients [frames]; 0 is the whole window.
    pub(crate) fn reach(&self) -> usize {
        self.state.step_control.reach()
    }

    pub(crate) fn begin_pass(&mut self) {
        self.note = None;
        self.resume();
    }

    /// Ends a pause after a rollback, unless the run has ended or steps have become too short to
    /// matter.
    pub(crate) fn resume(&mut self) {
        self.paused = self.state.has_ended || !self.state.step_control.can_continue();
    }

    pub(crate) fn end_pass(&mut self) {
        if self.state.is_done() {
            return;
        }
        self.state.pass += 1;
        if self.schedule() == Schedule::Whole {
            let control = &mut self.state.step_control;
            self.state.has_ended =
                control.has_ended(self.state.best.loss) || !control.can_continue();
        }
    }

    /// The best parameters, and the timing that they were scored with.
    pub(crate) fn best(&self) -> (Params, Timing) {
        let best = &self.state.best;
        (self.parameterization.params(&best.theta), self.timing(best.substeps))
    }

    fn timing(&self, substeps: u32) -> Timing {
        Timing { fps: self.task.capture.fps, substeps }
    }

    /// Moves this run, which has this index in the optimizer, to a position.
    fn move_to(
        &mut self,
        index: usize,
        position: Position,
        substeps: u32,
        optimizer: &mut dyn Optimizer,
    ) -> Result<(), LoadError> {
        optimizer.move_to(index, &position, self.timing(substeps))?;
        self.loaded = optimizer.loaded(index).map_err(LoadError::Backend)?;
        (self.state.position, self.state.substeps) = (position, substeps);
        Ok(())
    }

    /// Schedule of the steps of this run.
    fn schedule(&self) -> Schedule {
        if schedule::is_single_step(self.task) {
            Schedule::Whole
        } else {
            Schedule::Parts { passes: self.state.passes }
        }
    }

    /// Learning rate of the current pass.
    fn learning_rate(&self) -> f64 {
        let steps = self.state.position.adam.steps;
        let rate = self.task.settings.refine.learning_rate;
        rate * self.state.step_control.rate(self.schedule(), self.state.pass, steps)
    }

    /// Takes an optimizer step down the mean of the gradients that were just measured.
    pub(crate) fn step(
        &mut self,
        index: usize,
        gradients: &[GradientNorm],
        optimizer: &mut dyn Optimizer,
    ) -> Result<(), Error> {
        if let Some(d) = gradients.iter().find_map(|g| g.loss.diverged) {
            let why = format!("the simulation diverged in frame {}", d.frame);
            let change = self.state.step_control.halve_rate();
            return self.rollback(index, &why, &change, optimizer);
        }
        if gradients.iter().any(|g| !(g.norm.is_finite() && g.loss.total.is_finite())) {
            let change = self.state.step_control.shorten_reach();
            return self.rollback(index, "the gradient is not finite", &change, optimizer);
        }
        let losses: Vec<f64> = gradients.iter().map(|g| g.loss.total).collect();
        let scales = sequences::gradient_scales(self.task.sequence_mean(), &losses);
        let norms: Vec<f64> =
            gradients.iter().zip(&scales).map(|(g, scale)| scale * g.norm).collect();
        let mut weights = weights(&norms);
        let norm = norms.iter().zip(&weights).map(|(norm, weight)| norm * weight).sum();
        let clip = self.state.step_control.clip_factor(norm);
        weights.iter_mut().zip(&scales).for_each(|(weight, scale)| *weight *= scale * clip);
        Ok(optimizer.step(index, &weights, self.learning_rate())?)
    }

    /// Takes over the optimizer's position after the steps of a pass.
    pub(crate) fn sync(
        &mut self,
        index: usize,
        optimizer: &mut dyn Optimizer,
    ) -> Result<(), Error> {
        self.loaded = optimizer.loaded(index)?;
        self.state.position = optimizer.position(index)?;
        if self.schedule() == Schedule::Whole && self.is_active() {
            self.state.average.add(&self.state.position.theta);
        }
        self.raise_substeps(index, optimizer)
    }

    /// Adds substeps where stiffness has grown; rolls back where the limit is reached.
    fn raise_substeps(&mut self, index: usize, optimizer: &mut dyn Optimizer) -> Result<(), Error> {
        let current = self.loaded.model();
        let margin = match self.task.settings.substeps {
            Substeps::Auto { safety, .. } => safety.min(MIN_MARGIN),
            Substeps::Fixed(_) => 1.0,
        };
        let with_margin = (f64::from(self.state.substeps) / margin) as u32;
        if enough_substeps(current, with_margin).is_ok() {
            return Ok(());
        }
        let moved = match build_model(
            self.task,
            &self.graph,
            current.params.clone(),
            current.environment,
        ) {
            // At the limit the margin is reduced.
            Ok(model) if model.timing.substeps <= self.state.substeps => return Ok(()),
            Ok(model) => {
                let position = self.state.position.clone();
                self.move_to(index, position, model.timing.substeps, optimizer)
            }
            Err(error) => Err(error),
        };
        match moved {
            Ok(()) => {
                self.note(format!("raised to {} substeps a frame", self.state.substeps));
                Ok(())
            }
            Err(LoadError::TooStiff(_))
                if self.task.softens && self.soften(index, optimizer)? =>
            {
                Ok(())
            }
            Err(LoadError::TooStiff(n)) => {
                let change = self.state.step_control.halve_rate();
                self.rollback(
                    index,
                    &format!("it would need {n} substeps a frame"),
                    &change,
                    optimizer,
                )
            }
            Err(error) => Err(error.into()),
        }
    }

    /// Continues with stiffness and damping that the most substeps allow, with a margin; false if
    /// they would have to be reduced too much.
    fn soften(&mut self, index: usize, optimizer: &mut dyn Optimizer) -> Result<bool, Error> {
        let (current, most) = (self.loaded.model(), self.task.settings.substeps.most());
        let with_margin = (f64::from(most) / MIN_MARGIN) as u32;
        let Some(reduction) = Reduction::to(current, with_margin.max(1)) else { return Ok(false) };
        let params = reduction.apply(current).params;
        let theta = parameterization(self.task, params).start();
        let position = Position { theta, ..self.state.position.clone() };
        self.move_to(index, position, most, optimizer)?;
        Ok(true)
    }

    /// Records the loss of the current parameters over all training frames: keeps them if they are
    /// the best so far, returns to the best after too many passes without a gain.
    pub(crate) fn record_loss(
        &mut self,
        index: usize,
        loss: f64,
        optimizer: &mut dyn Optimizer,
    ) -> Result<(), Error> {
        self.state.loss = loss;
        if loss < self.state.best.loss {
            let (theta, substeps) = (self.state.position.theta.clone(), self.state.substeps);
            self.state.best = Best { theta, substeps, loss };
            self.state.step_control.record_gain();
            return Ok(());
        }
        if !loss.is_finite() {
            let change = self.state.step_control.halve_rate();
            self.rollback(index, "the simulation diverged", &change, optimizer)?;
        } else if !self.paused
            && let Some(patience) = self.state.step_control.record_no_gain(self.schedule())
        {
            let change = self.state.step_control.back_off();
            self.rollback(index, &format!("no gain in {patience} passes"), &change, optimizer)?;
        }
        Ok(())
    }

    /// The model at the mean of the last positions; `None` without a mean, or if the model would
    /// need more substeps than the run takes.
    pub(crate) fn average(&self, backend: &dyn Backend) -> Result<Option<Loaded>, Error> {
        let Some(theta) = self.state.average.theta() else { return Ok(None) };
        let params = self.parameterization.params(theta);
        let model = Model { params, ..Model::clone(self.loaded.model()) };
        if enough_substeps(&model, self.state.substeps).is_err() {
            return Ok(None);
        }
        Ok(Some(backend.with_params(&self.loaded, model.params)?))
    }

    /// Records the loss of [`OptimizerRun::average`]: the mean becomes the best if its loss is the
    /// lowest, while steps continue from the current position.
    pub(crate) fn record_average(&mut self, loss: f64) {
        let Some(theta) = self.state.average.theta() else { return };
        if loss < self.state.best.loss {
            let theta = theta.to_vec();
            self.state.best = Best { theta, substeps: self.state.substeps, loss };
            self.state.step_control.record_gain();
        }
    }

    /// Appends to the message about this pass.
    fn note(&mut self, what: String) {
        match &mut self.note {
            Some(note) => note.extend(["; ", &what]),
            None => self.note = Some(what),
        }
    }

    /// Returns to the best parameters, without momentum, and pauses until the next pass. `why` and
    /// `change` go into the message about this pass.
    fn rollback(
        &mut self,
        index: usize,
        why: &str,
        change: &str,
        optimizer: &mut dyn Optimizer,
    ) -> Result<(), Error> {
        let best = &self.state.best;
        let (position, substeps) =
            (self.parameterization.at_rest(best.theta.clone()), best.substeps);
        self.move_to(index, position, substeps, optimizer)?;
        self.state.average.clear();
        self.paused = true;
        self.note(format!("{why}: went back to the best parameters, {change}"));
        Ok(())
    }
}

/// Weights of the gradients of a batch, from their norms. A long rollout occasionally comes near a
/// bifurcation of the motion, and its gradient is larger than all others by orders of magnitude
/// without carrying more information: no gradient counts with more than the median norm.
fn weights(norms: &[f64]) -> Vec<f64> {
    // Sequences without a gradient must not lower the median.
    let mut sorted: Vec<f64> = norms.iter().copied().filter(|l| *l > 0.0).collect();
    sorted.sort_by(f64::total_cmp);
    let even = 1.0 / norms.len().max(1) as f64;
    let Some(&median) = sorted.get(sorted.len() / 2) else { return vec![even; norms.len()] };
    norms.iter().map(|&l| if l > median { even * median / l } else { even }).collect()
}

#[cfg(test)]
mod tests;
