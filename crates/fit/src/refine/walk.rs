//! One variant's walk: where it is, where it was best, how long its steps are.

use std::sync::Arc;

use bendtwin_core::{Graph, Params, Timing, settings::Substeps};
use bendtwin_engine::{Backend, Loaded, backend::Gradient, stable_substeps};
use serde::{Deserialize, Serialize};

use crate::{
    Error,
    adam::{Adam, Decay},
    coordinates::Coordinates,
    fabric::{Refusal, load, model},
    task::Task,
};

/// Share of the learning rate that is left in the last pass.
const FINAL_RATE: f64 = 0.1;
/// Below this share of its first rate a walk that keeps failing stays where it was best.
const SMALLEST_RATE: f64 = 1e-3;
/// Passes without a better loss after which a walk goes back and takes shorter steps.
const PATIENCE: u32 = 3;
/// Frames that gradients reach back after the first such failure; a quarter after each further one.
const FIRST_REACH: u32 = 16;
/// Margin of stability below which substeps are added.
const THIN_MARGIN: f64 = 1.15;

/// What a checkpoint keeps of a walk.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct WalkState {
    /// Passes that are done.
    pub(crate) pass: u32,
    theta: Vec<f64>,
    adam: Adam,
    substeps: u32,
    /// Halved by every back-off.
    rate: f64,
    /// Frames that gradients reach back, shortened by back-offs; 0 is as far as the window goes.
    reach: u32,
    /// Passes since the best one, or since the last back-off.
    stale: u32,
    /// Loss after the last pass.
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
    pub(crate) loaded: Loaded,
    /// Something that happened in the last pass and that a person should know.
    pub(crate) note: Option<String>,
    coordinates: Coordinates,
    sits_out: bool,
    task: &'a Task<'a>,
}

impl<'a> Walk<'a> {
    /// At the parameters that the search found.
    pub(crate) fn start(
        task: &'a Task<'a>,
        graph: Arc<Graph>,
        params: Params,
        backend: &dyn Backend,
    ) -> Result<Self, Error> {
        let coordinates = Coordinates::new(task, params);
        let theta = coordinates.start();
        let params = coordinates.params(&theta);
        let model = model(task, &graph, params).map_err(too_stiff)?;
        let substeps = model.timing.substeps;
        let loaded = load(backend, model)?.map_err(too_stiff)?;
        let state = WalkState {
            pass: 0,
            adam: Adam::new(coordinates.len()),
            substeps,
            rate: 1.0,
            reach: 0,
            stale: 0,
            loss: f64::INFINITY,
            best: Best { theta: theta.clone(), substeps, loss: f64::INFINITY },
            theta,
        };
        Ok(Self { state, graph, loaded, note: None, coordinates, sits_out: false, task })
    }

    /// Where a checkpoint left off; `params` are those that the search found.
    pub(crate) fn resume(
        task: &'a Task<'a>,
        graph: Arc<Graph>,
        params: Params,
        state: WalkState,
        backend: &dyn Backend,
    ) -> Result<Self, Error> {
        let coordinates = Coordinates::new(task, params);
        if state.theta.len() != coordinates.len() || state.best.theta.len() != coordinates.len() {
            return Err(Error::Checkpoint("it has another number of parameters".into()));
        }
        let mut start = model(task, &graph, coordinates.params(&state.theta)).map_err(too_stiff)?;
        start.timing.substeps = state.substeps;
        let loaded = load(backend, start)?.map_err(too_stiff)?;
        Ok(Self { state, graph, loaded, note: None, coordinates, sits_out: false, task })
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
        self.sits_out = self.state.rate < SMALLEST_RATE;
    }

    pub(crate) fn end_pass(&mut self) {
        self.state.pass += 1;
    }

    /// The best parameters and the substeps that they were scored with.
    pub(crate) fn best(&self) -> (Params, Timing) {
        let best = &self.state.best;
        let timing = Timing { fps: self.task.capture.fps, substeps: best.substeps };
        (self.coordinates.params(&best.theta), timing)
    }

    /// Rate of the current pass: falls linearly, so that the walk comes to rest.
    fn learning_rate(&self) -> f64 {
        let refine = &self.task.settings.refine;
        let done = f64::from(self.state.pass) / f64::from(refine.passes.max(1));
        refine.learning_rate * self.state.rate * (1.0 - (1.0 - FINAL_RATE) * done)
    }

    /// One step down the mean gradient of a batch.
    pub(crate) fn learn(
        &mut self,
        gradients: &[Gradient],
        backend: &dyn Backend,
    ) -> Result<(), Error> {
        let params = &self.loaded.model().params;
        let mut sum = vec![0.0; self.coordinates.len()];
        let own: Vec<Vec<f64>> =
            gradients.iter().map(|g| self.coordinates.gradient(params, &g.params)).collect();
        for (gradient, weight) in own.iter().zip(weights(&own)) {
            sum.iter_mut().zip(gradient).for_each(|(s, g)| *s += weight * g);
        }
        if let Some(d) = gradients.iter().find_map(|g| g.loss.diverged) {
            return self
                .back_off(&format!("the simulation diverged in frame {}", d.frame), backend);
        }
        if sum.iter().any(|g| !g.is_finite()) || gradients.iter().any(|g| !g.loss.total.is_finite())
        {
            return self.back_off("the gradient is not finite", backend);
        }
        let refine = &self.task.settings.refine;
        let decay = Decay { beta1: refine.beta1, beta2: refine.beta2 };
        let rate = self.learning_rate();
        self.coordinates.step(&mut self.state.adam, &mut self.state.theta, &sum, rate, decay);
        let params = self.coordinates.params(&self.state.theta);
        self.loaded = backend.with_params(&self.loaded, params)?;
        Ok(())
    }

    /// Adds substeps where stiffness has grown; backs off where there are none to add.
    pub(crate) fn settle_substeps(&mut self, backend: &dyn Backend) -> Result<(), Error> {
        let current = self.loaded.model();
        let needed = stable_substeps(current).needed;
        let margin = match self.task.settings.substeps {
            Substeps::Auto { safety, .. } => safety.min(THIN_MARGIN),
            Substeps::Fixed(_) => 1.0,
        };
        if f64::from(needed) * margin <= f64::from(self.state.substeps) {
            return Ok(());
        }
        let again = model(self.task, &self.graph, current.params.clone());
        let loaded = match again {
            // At the limit the margin has to give way.
            Ok(model) if model.timing.substeps <= self.state.substeps => return Ok(()),
            Ok(model) => load(backend, model)?,
            Err(refusal) => Err(refusal),
        };
        match loaded {
            Ok(loaded) => {
                self.state.substeps = loaded.model().timing.substeps;
                self.loaded = loaded;
                self.note = Some(format!("raised to {} substeps a frame", self.state.substeps));
                Ok(())
            }
            Err(Refusal::TooStiff(n)) => {
                self.back_off(&format!("it would need {n} substeps a frame"), backend)
            }
        }
    }

    /// Takes the loss over all training frames of the current parameters.
    pub(crate) fn judge(&mut self, loss: f64, backend: &dyn Backend) -> Result<(), Error> {
        self.state.loss = loss;
        if loss < self.state.best.loss {
            let (theta, substeps) = (self.state.theta.clone(), self.state.substeps);
            self.state.best = Best { theta, substeps, loss };
            self.state.stale = 0;
            return Ok(());
        }
        self.state.stale += 1;
        if !loss.is_finite() {
            self.back_off("the simulation diverged", backend)?;
        } else if self.state.stale >= PATIENCE && !self.sits_out {
            self.reach_less(backend)?;
        }
        Ok(())
    }

    /// Steps that help nowhere mean that the gradient has lost its way through many frames: it grows along
    /// chaotic motion until nothing else is left of it. So it is cut shorter, and only then comes
    /// a shorter step.
    fn reach_less(&mut self, backend: &dyn Backend) -> Result<(), Error> {
        let why = format!("no gain in {PATIENCE} passes");
        let shorter = match self.state.reach {
            0 => FIRST_REACH,
            reach => reach / 4,
        };
        if shorter == 0 {
            return self.back_off(&why, backend);
        }
        self.state.reach = shorter;
        self.go_back(backend)?;
        self.note = Some(format!(
            "{why}: went back to the best parameters, gradients now reach {shorter} frames"
        ));
        Ok(())
    }

    /// Back to the best parameters with half the rate.
    fn back_off(&mut self, why: &str, backend: &dyn Backend) -> Result<(), Error> {
        self.state.rate *= 0.5;
        self.go_back(backend)?;
        self.note = Some(format!("{why}: went back to the best parameters and halved the rate"));
        Ok(())
    }

    /// Back to the best parameters, without momentum, until the next pass.
    fn go_back(&mut self, backend: &dyn Backend) -> Result<(), Error> {
        let state = &mut self.state;
        state.theta.clone_from(&state.best.theta);
        state.substeps = state.best.substeps;
        state.adam = Adam::new(state.theta.len());
        state.stale = 0;
        self.sits_out = true;
        let mut model = bendtwin_engine::Model::clone(self.loaded.model());
        model.params = self.coordinates.params(&self.state.theta);
        model.timing.substeps = self.state.substeps;
        self.loaded = load(backend, model)?.map_err(too_stiff)?;
        Ok(())
    }
}

/// Weights of the gradients of a batch. A long rollout now and then comes near a point where the motion branches,
/// and its gradient is larger than all others by orders of magnitude without saying more: none counts
/// with more than the median length.
fn weights(gradients: &[Vec<f64>]) -> Vec<f64> {
    let length = |g: &Vec<f64>| g.iter().map(|x| x * x).sum::<f64>().sqrt();
    let lengths: Vec<f64> = gradients.iter().map(length).collect();
    // Sequences that say nothing must not silence the others.
    let mut sorted: Vec<f64> = lengths.iter().copied().filter(|l| *l > 0.0).collect();
    sorted.sort_by(f64::total_cmp);
    let even = 1.0 / gradients.len().max(1) as f64;
    let Some(&median) = sorted.get(sorted.len() / 2) else { return vec![even; lengths.len()] };
    lengths.iter().map(|&l| if l > median { even * median / l } else { even }).collect()
}

fn too_stiff(refusal: Refusal) -> Error {
    let Refusal::TooStiff(needed) = refusal;
    Error::NothingStable(format!("the found parameters need {needed} substeps a frame"))
}
