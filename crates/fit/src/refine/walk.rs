//! One variant's walk: where it was best, how long its steps are, when it goes back. The optimizer takes the
//! steps and knows where the walk is.

use std::sync::Arc;

use bendtwin_core::{Environment, Graph, Params, Timing, settings::Substeps};
use bendtwin_engine::{
    Backend, Loaded, backend, enough_substeps,
    optimizer::{GradientNorm, Optimizer, OptimizerInit, Parameterization, Position},
};
use serde::{Deserialize, Serialize};

use crate::{
    Error,
    fabric::{Refusal, load, model},
    parameterization::parameterization,
    refine::pace::Pace,
    sequences,
    task::Task,
};

/// Margin of stability below which substeps are added.
const THIN_MARGIN: f64 = 1.15;

/// What a checkpoint keeps of a walk.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct WalkState {
    /// Passes that are done.
    pub(crate) pass: u32,
    /// Where the last pass led.
    position: Position,
    substeps: u32,
    pace: Pace,
    /// The loss that was judged last: where the last pass began if it was a single step, otherwise where it led.
    pub(crate) loss: f64,
    pub(crate) best: Best,
}

/// The best parameters so far, by their loss over all training frames.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Best {
    theta: Vec<f64>,
    substeps: u32,
    pub(crate) loss: f64,
}

/// A walk under way.
pub(crate) struct Walk<'a> {
    pub(crate) state: WalkState,
    pub(crate) graph: Arc<Graph>,
    /// The model where the walk last arrived; while a pass goes on, the optimizer is ahead of it.
    pub(crate) loaded: Loaded,
    /// Something that happened in the last pass and that a person should know.
    pub(crate) note: Option<String>,
    parameterization: Parameterization,
    sits_out: bool,
    task: &'a Task<'a>,
}

impl<'a> Walk<'a> {
    /// At the parameters that the search found.
    pub(crate) fn start(
        task: &'a Task<'a>,
        graph: Arc<Graph>,
        params: Params,
        environment: Environment,
        backend: &dyn Backend,
    ) -> Result<(Self, OptimizerInit), Error> {
        let parameterization = parameterization(task, params);
        let position = Position::at_rest(parameterization.start());
        let model = model(task, &graph, parameterization.params(&position.theta), environment)
            .map_err(too_stiff)?;
        let substeps = model.timing.substeps;
        let loaded = load(backend, model)?.map_err(too_stiff)?;
        let best = Best { theta: position.theta.clone(), substeps, loss: f64::INFINITY };
        let state = WalkState {
            pass: 0,
            position,
            substeps,
            pace: Pace::new(task.settings.refine.reach),
            loss: f64::INFINITY,
            best,
        };
        Ok(Self::at(task, graph, loaded, parameterization, state))
    }

    /// Where a checkpoint left off; `params` are those that the search found.
    pub(crate) fn resume(
        task: &'a Task<'a>,
        graph: Arc<Graph>,
        params: Params,
        environment: Environment,
        state: WalkState,
        backend: &dyn Backend,
    ) -> Result<(Self, OptimizerInit), Error> {
        let parameterization = parameterization(task, params);
        let best = Position::at_rest(state.best.theta.clone());
        for position in [&state.position, &best] {
            parameterization
                .check_position(position)
                .map_err(|e| Error::Checkpoint(e.to_string()))?;
        }
        let params = parameterization.params(&state.position.theta);
        let mut model = model(task, &graph, params, environment).map_err(too_stiff)?;
        model.timing.substeps = state.substeps;
        let loaded = load(backend, model)?.map_err(too_stiff)?;
        Ok(Self::at(task, graph, loaded, parameterization, state))
    }

    fn at(
        task: &'a Task<'a>,
        graph: Arc<Graph>,
        loaded: Loaded,
        parameterization: Parameterization,
        state: WalkState,
    ) -> (Self, OptimizerInit) {
        let start = OptimizerInit {
            loaded: loaded.clone(),
            parameterization: parameterization.clone(),
            position: state.position.clone(),
        };
        (Self { state, graph, loaded, note: None, parameterization, sits_out: false, task }, start)
    }

    /// Whether it takes part in the steps of this pass.
    pub(crate) fn is_active(&self) -> bool {
        !self.sits_out
    }

    /// How far gradients of this walk reach back.
    pub(crate) fn reach(&self) -> usize {
        self.state.pace.reach()
    }

    pub(crate) fn begin_pass(&mut self) {
        self.note = None;
        self.set_out();
    }

    /// Takes part again after a back-off, unless its steps have become too short to matter.
    pub(crate) fn set_out(&mut self) {
        self.sits_out = !self.state.pace.goes_on();
    }

    pub(crate) fn end_pass(&mut self) {
        self.state.pass += 1;
    }

    /// The best parameters and the substeps that they were scored with.
    pub(crate) fn best(&self) -> (Params, Timing) {
        let best = &self.state.best;
        (self.parameterization.params(&best.theta), self.timing(best.substeps))
    }

    fn timing(&self, substeps: u32) -> Timing {
        Timing { fps: self.task.capture.fps, substeps }
    }

    /// Moves the optimizer, in which this walk has this index, here and below.
    fn move_to(
        &mut self,
        index: usize,
        position: Position,
        substeps: u32,
        optimizer: &mut dyn Optimizer,
    ) -> Result<Result<(), Refusal>, Error> {
        match optimizer.move_to(index, &position, self.timing(substeps)) {
            Ok(()) => {
                self.loaded = optimizer.loaded(index)?;
                (self.state.position, self.state.substeps) = (position, substeps);
                Ok(Ok(()))
            }
            Err(backend::Error::Unstable { needed, .. }) => Ok(Err(Refusal::TooStiff(needed))),
            Err(e) => Err(e.into()),
        }
    }

    /// Rate of the current pass.
    fn learning_rate(&self) -> f64 {
        let refine = &self.task.settings.refine;
        let steps = self.state.position.adam.steps;
        refine.learning_rate * self.state.pace.rate(self.state.pass, refine.passes, steps)
    }

    /// One step down the mean of the gradients that were just measured.
    pub(crate) fn learn(
        &mut self,
        index: usize,
        slopes: &[GradientNorm],
        optimizer: &mut dyn Optimizer,
    ) -> Result<(), Error> {
        if let Some(d) = slopes.iter().find_map(|s| s.loss.diverged) {
            let why = format!("the simulation diverged in frame {}", d.frame);
            let change = self.state.pace.slow_down();
            return self.go_back(index, &why, &change, optimizer);
        }
        if slopes.iter().any(|s| !(s.norm.is_finite() && s.loss.total.is_finite())) {
            let change = self.state.pace.overflow();
            return self.go_back(index, "the gradient is not finite", &change, optimizer);
        }
        let losses: Vec<f64> = slopes.iter().map(|s| s.loss.total).collect();
        let pulls = sequences::pulls(self.task.sequence_mean(), &losses);
        let lengths: Vec<f64> = slopes.iter().zip(&pulls).map(|(s, pull)| pull * s.norm).collect();
        let mut weights = weights(&lengths);
        let length = lengths.iter().zip(&weights).map(|(length, weight)| length * weight).sum();
        let by = self.state.pace.shorten(length);
        weights.iter_mut().zip(&pulls).for_each(|(weight, pull)| *weight *= pull * by);
        Ok(optimizer.step(index, &weights, self.learning_rate())?)
    }

    /// Takes over where the steps of a pass led.
    pub(crate) fn arrive(
        &mut self,
        index: usize,
        optimizer: &mut dyn Optimizer,
    ) -> Result<(), Error> {
        self.loaded = optimizer.loaded(index)?;
        self.state.position = optimizer.position(index)?;
        self.settle_substeps(index, optimizer)
    }

    /// Adds substeps where stiffness has grown; backs off where there are none to add.
    fn settle_substeps(
        &mut self,
        index: usize,
        optimizer: &mut dyn Optimizer,
    ) -> Result<(), Error> {
        let current = self.loaded.model();
        let margin = match self.task.settings.substeps {
            Substeps::Auto { safety, .. } => safety.min(THIN_MARGIN),
            Substeps::Fixed(_) => 1.0,
        };
        let with_margin = (f64::from(self.state.substeps) / margin) as u32;
        if enough_substeps(current, with_margin).is_ok() {
            return Ok(());
        }
        let moved = match model(self.task, &self.graph, current.params.clone(), current.environment)
        {
            // At the limit the margin has to give way.
            Ok(model) if model.timing.substeps <= self.state.substeps => return Ok(()),
            Ok(model) => {
                let position = self.state.position.clone();
                self.move_to(index, position, model.timing.substeps, optimizer)?
            }
            Err(refusal) => Err(refusal),
        };
        match moved {
            Ok(()) => {
                self.say(format!("raised to {} substeps a frame", self.state.substeps));
                Ok(())
            }
            Err(Refusal::TooStiff(n)) => {
                let change = self.state.pace.slow_down();
                self.go_back(
                    index,
                    &format!("it would need {n} substeps a frame"),
                    &change,
                    optimizer,
                )
            }
        }
    }

    /// Takes the loss over all training frames of the parameters where it is: keeps them if they are the best,
    /// goes back to the best after too many that were not.
    pub(crate) fn judge(
        &mut self,
        index: usize,
        loss: f64,
        optimizer: &mut dyn Optimizer,
    ) -> Result<(), Error> {
        self.state.loss = loss;
        if loss < self.state.best.loss {
            let (theta, substeps) = (self.state.position.theta.clone(), self.state.substeps);
            self.state.best = Best { theta, substeps, loss };
            self.state.pace.gain();
            return Ok(());
        }
        let passes = self.task.settings.refine.passes;
        if !loss.is_finite() {
            let change = self.state.pace.slow_down();
            self.go_back(index, "the simulation diverged", &change, optimizer)?;
        } else if !self.sits_out
            && let Some(patience) = self.state.pace.no_gain(passes)
        {
            let change = self.state.pace.fail();
            self.go_back(index, &format!("no gain in {patience} passes"), &change, optimizer)?;
        }
        Ok(())
    }

    /// Notes what happened in this pass, after what has happened in it already.
    fn say(&mut self, what: String) {
        match &mut self.note {
            Some(note) => note.extend(["; ", &what]),
            None => self.note = Some(what),
        }
    }

    /// Back to the best parameters, without momentum, until the next pass; says why and what changes.
    fn go_back(
        &mut self,
        index: usize,
        why: &str,
        change: &str,
        optimizer: &mut dyn Optimizer,
    ) -> Result<(), Error> {
        let best = &self.state.best;
        let (position, substeps) = (Position::at_rest(best.theta.clone()), best.substeps);
        self.move_to(index, position, substeps, optimizer)?.map_err(too_stiff)?;
        self.sits_out = true;
        self.say(format!("{why}: went back to the best parameters, {change}"));
        Ok(())
    }
}

/// Weights of the gradients of a batch. A long rollout now and then comes near a point where the motion branches,
/// and its gradient is larger than all others by orders of magnitude without saying more: none counts
/// with more than the median length.
fn weights(lengths: &[f64]) -> Vec<f64> {
    // Sequences that say nothing must not silence the others.
    let mut sorted: Vec<f64> = lengths.iter().copied().filter(|l| *l > 0.0).collect();
    sorted.sort_by(f64::total_cmp);
    let even = 1.0 / lengths.len().max(1) as f64;
    let Some(&median) = sorted.get(sorted.len() / 2) else { return vec![even; lengths.len()] };
    lengths.iter().map(|&l| if l > median { even * median / l } else { even }).collect()
}

fn too_stiff(refusal: Refusal) -> Error {
    let Refusal::TooStiff(needed) = refusal;
    Error::NothingStable(format!("the found parameters need {needed} substeps a frame"))
}

#[cfg(test)]
mod tests;
