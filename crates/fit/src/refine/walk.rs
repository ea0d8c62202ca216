//! One variant's walk: where it was best, how long its steps are, when it goes back. The descent takes the
//! steps and knows where the walk is.

use std::sync::Arc;

use bendtwin_core::{Environment, Graph, Params, Timing, settings::Substeps};
use bendtwin_engine::{
    Backend, Loaded, backend,
    descent::{Chart, Descent, Position, Slope, Start},
    enough_substeps,
};
use serde::{Deserialize, Serialize};

use crate::{
    Error,
    chart::chart,
    fabric::{Refusal, load, model},
    sequences,
    task::Task,
};

/// Share of the learning rate that is left in the last pass.
const FINAL_RATE: f64 = 0.1;
/// Below this share of its first rate a walk that keeps failing stays where it was best.
const SMALLEST_RATE: f64 = 1e-3;
/// Passes without a better loss after which a walk goes back and takes shorter steps.
const PATIENCE: u32 = 3;
/// Frames that gradients reach back at most after the first such failure; a quarter after each further one.
const FIRST_REACH: u32 = 16;
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
    /// Halved by every back-off.
    rate: f64,
    /// Frames that gradients reach back, as the settings say, shortened by back-offs; 0 is as far as the
    /// window goes.
    reach: u32,
    /// Passes since the best one, or since the last back-off.
    stale: u32,
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
    /// The model where the walk last arrived; while a pass goes on, the descent is ahead of it.
    pub(crate) loaded: Loaded,
    /// Something that happened in the last pass and that a person should know.
    pub(crate) note: Option<String>,
    chart: Chart,
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
    ) -> Result<(Self, Start), Error> {
        let chart = chart(task, params);
        let position = Position::at_rest(chart.start());
        let model =
            model(task, &graph, chart.params(&position.theta), environment).map_err(too_stiff)?;
        let substeps = model.timing.substeps;
        let loaded = load(backend, model)?.map_err(too_stiff)?;
        let best = Best { theta: position.theta.clone(), substeps, loss: f64::INFINITY };
        let state = WalkState {
            pass: 0,
            position,
            substeps,
            rate: 1.0,
            reach: task.settings.refine.reach,
            stale: 0,
            loss: f64::INFINITY,
            best,
        };
        Ok(Self::at(task, graph, loaded, chart, state))
    }

    /// Where a checkpoint left off; `params` are those that the search found.
    pub(crate) fn resume(
        task: &'a Task<'a>,
        graph: Arc<Graph>,
        params: Params,
        environment: Environment,
        state: WalkState,
        backend: &dyn Backend,
    ) -> Result<(Self, Start), Error> {
        let chart = chart(task, params);
        let best = Position::at_rest(state.best.theta.clone());
        for position in [&state.position, &best] {
            chart.check_position(position).map_err(|e| Error::Checkpoint(e.to_string()))?;
        }
        let params = chart.params(&state.position.theta);
        let mut model = model(task, &graph, params, environment).map_err(too_stiff)?;
        model.timing.substeps = state.substeps;
        let loaded = load(backend, model)?.map_err(too_stiff)?;
        Ok(Self::at(task, graph, loaded, chart, state))
    }

    fn at(
        task: &'a Task<'a>,
        graph: Arc<Graph>,
        loaded: Loaded,
        chart: Chart,
        state: WalkState,
    ) -> (Self, Start) {
        let start = Start {
            loaded: loaded.clone(),
            chart: chart.clone(),
            position: state.position.clone(),
        };
        (Self { state, graph, loaded, note: None, chart, sits_out: false, task }, start)
    }

    /// Whether it takes part in the steps of this pass.
    pub(crate) fn is_active(&self) -> bool {
        !self.sits_out
    }

    /// How far gradients of this walk reach back.
    pub(crate) fn reach(&self) -> usize {
        self.state.reach as usize
    }

    pub(crate) fn begin_pass(&mut self) {
        self.note = None;
        self.set_out();
    }

    /// Takes part again after a back-off, unless its steps have become too short to matter.
    pub(crate) fn set_out(&mut self) {
        self.sits_out = self.state.rate < SMALLEST_RATE;
    }

    pub(crate) fn end_pass(&mut self) {
        self.state.pass += 1;
    }

    /// The best parameters and the substeps that they were scored with.
    pub(crate) fn best(&self) -> (Params, Timing) {
        let best = &self.state.best;
        (self.chart.params(&best.theta), self.timing(best.substeps))
    }

    fn timing(&self, substeps: u32) -> Timing {
        Timing { fps: self.task.capture.fps, substeps }
    }

    /// Moves the descent, in which this walk has this index, here and below.
    fn move_to(
        &mut self,
        index: usize,
        position: Position,
        substeps: u32,
        descent: &mut dyn Descent,
    ) -> Result<Result<(), Refusal>, Error> {
        match descent.move_to(index, &position, self.timing(substeps)) {
            Ok(()) => {
                self.loaded = descent.loaded(index)?;
                (self.state.position, self.state.substeps) = (position, substeps);
                Ok(Ok(()))
            }
            Err(backend::Error::Unstable { needed, .. }) => Ok(Err(Refusal::TooStiff(needed))),
            Err(e) => Err(e.into()),
        }
    }

    /// Rate of the current pass: falls linearly, so that the walk comes to rest.
    fn learning_rate(&self) -> f64 {
        let refine = &self.task.settings.refine;
        let done = f64::from(self.state.pass) / f64::from(refine.passes.max(1));
        refine.learning_rate * self.state.rate * (1.0 - (1.0 - FINAL_RATE) * done)
    }

    /// One step down the mean of the gradients that were just measured.
    pub(crate) fn learn(
        &mut self,
        index: usize,
        slopes: &[Slope],
        descent: &mut dyn Descent,
    ) -> Result<(), Error> {
        if let Some(d) = slopes.iter().find_map(|s| s.loss.diverged) {
            let why = format!("the simulation diverged in frame {}", d.frame);
            return self.back_off(index, &why, descent);
        }
        if slopes.iter().any(|s| !(s.length.is_finite() && s.loss.total.is_finite())) {
            return self.back_off(index, "the gradient is not finite", descent);
        }
        let losses: Vec<f64> = slopes.iter().map(|s| s.loss.total).collect();
        let pulls = sequences::pulls(self.task.settings.loss.sequences, &losses);
        let lengths: Vec<f64> =
            slopes.iter().zip(&pulls).map(|(s, pull)| pull * s.length).collect();
        let weights: Vec<f64> = weights(&lengths).iter().zip(&pulls).map(|(w, p)| w * p).collect();
        Ok(descent.step(index, &weights, self.learning_rate())?)
    }

    /// Takes over where the steps of a pass led.
    pub(crate) fn arrive(&mut self, index: usize, descent: &mut dyn Descent) -> Result<(), Error> {
        self.loaded = descent.loaded(index)?;
        self.state.position = descent.position(index)?;
        self.settle_substeps(index, descent)
    }

    /// Adds substeps where stiffness has grown; backs off where there are none to add.
    fn settle_substeps(&mut self, index: usize, descent: &mut dyn Descent) -> Result<(), Error> {
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
                self.move_to(index, position, model.timing.substeps, descent)?
            }
            Err(refusal) => Err(refusal),
        };
        match moved {
            Ok(()) => {
                self.say(format!("raised to {} substeps a frame", self.state.substeps));
                Ok(())
            }
            Err(Refusal::TooStiff(n)) => {
                self.back_off(index, &format!("it would need {n} substeps a frame"), descent)
            }
        }
    }

    /// Takes the loss over all training frames of the parameters where it is: keeps them if they are the best,
    /// goes back to the best after too many that were not.
    pub(crate) fn judge(
        &mut self,
        index: usize,
        loss: f64,
        descent: &mut dyn Descent,
    ) -> Result<(), Error> {
        self.state.loss = loss;
        if loss < self.state.best.loss {
            let (theta, substeps) = (self.state.position.theta.clone(), self.state.substeps);
            self.state.best = Best { theta, substeps, loss };
            self.state.stale = 0;
            return Ok(());
        }
        self.state.stale += 1;
        if !loss.is_finite() {
            self.back_off(index, "the simulation diverged", descent)?;
        } else if self.state.stale >= PATIENCE && !self.sits_out {
            self.reach_less(index, descent)?;
        }
        Ok(())
    }

    /// Steps that help nowhere mean that the gradient has lost its way through many frames: it grows along
    /// chaotic motion until nothing else is left of it. So it is cut shorter, and only then comes
    /// a shorter step.
    fn reach_less(&mut self, index: usize, descent: &mut dyn Descent) -> Result<(), Error> {
        let why = format!("no gain in {PATIENCE} passes");
        let Some(shorter) = shorter(self.state.reach) else {
            return self.back_off(index, &why, descent);
        };
        self.state.reach = shorter;
        self.go_back(index, descent)?;
        self.say(format!(
            "{why}: went back to the best parameters, gradients now reach {shorter} frames"
        ));
        Ok(())
    }

    /// Back to the best parameters with half the rate.
    fn back_off(
        &mut self,
        index: usize,
        why: &str,
        descent: &mut dyn Descent,
    ) -> Result<(), Error> {
        self.state.rate *= 0.5;
        self.go_back(index, descent)?;
        self.say(format!("{why}: went back to the best parameters and halved the rate"));
        Ok(())
    }

    /// Notes what happened in this pass, after what has happened in it already.
    fn say(&mut self, what: String) {
        match &mut self.note {
            Some(note) => note.extend(["; ", &what]),
            None => self.note = Some(what),
        }
    }

    /// Back to the best parameters, without momentum, until the next pass.
    fn go_back(&mut self, index: usize, descent: &mut dyn Descent) -> Result<(), Error> {
        let best = &self.state.best;
        let (position, substeps) = (Position::at_rest(best.theta.clone()), best.substeps);
        self.move_to(index, position, substeps, descent)?.map_err(too_stiff)?;
        self.state.stale = 0;
        self.sits_out = true;
        Ok(())
    }
}

/// The next shorter reach, if there is one.
fn shorter(reach: u32) -> Option<u32> {
    match reach {
        0 => Some(FIRST_REACH),
        1 => None,
        far => Some((far / 4).clamp(1, FIRST_REACH)),
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
