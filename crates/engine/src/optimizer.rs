//! Gradient descent in parameter space: loss and gradient at a point, a weighted step of Adam,
//! repeated. Parameters and gradients stay with the backend, on its device if it has one; the host
//! sees a few numbers per instance.

mod adam;
mod host;
mod parameter;
mod parameterization;

use bendtwin_core::{CancelToken, Timing};
use serde::{Deserialize, Serialize};

pub use self::{
    adam::{Adam, Bounds, Decay, EPSILON, SLOPE},
    host::HostOptimizer,
    parameter::Parameter,
    parameterization::{Parameterization, Scale, Section},
};
use crate::{
    backend::{Error, GradientRequest, Instance, Loaded, Loss},
    model::State,
};

/// The state of an optimizer run, complete enough to continue from it with identical bits on the
/// same backend.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Position {
    /// Coordinates of a [`Parameterization`], shape [`Parameterization::len`].
    pub theta: Vec<f64>,
    /// Adam's moments.
    pub adam: Adam,
}

/// The initial state of one optimizer run.
#[derive(Clone, Debug)]
pub struct OptimizerInit {
    /// Graph and timing, loaded by the same backend. Its parameters are replaced by those at
    /// `position`.
    pub loaded: Loaded,
    /// Coordinates that the run changes.
    pub parameterization: Parameterization,
    /// Initial coordinates and moments.
    pub position: Position,
}

impl OptimizerInit {
    /// Checks that parameterization and position belong together.
    ///
    /// # Errors
    /// If lengths differ, or a coordinate or moment is not finite.
    pub fn check(&self) -> Result<(), Error> {
        self.parameterization.check(&self.loaded.model().graph)?;
        self.parameterization.check_position(&self.position)
    }
}

/// An instance whose loss and gradient are measured for an optimizer run.
#[derive(Clone, Debug)]
pub struct GradientSample {
    /// Index of the run.
    pub run: usize,
    /// Simulation to measure. The run's current model replaces the instance's own, which must
    /// nevertheless be one that the backend loaded.
    pub instance: Instance,
}

/// Loss and gradient norm of one sample: all that the host sees of a gradient.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct GradientNorm {
    /// The loss.
    pub loss: Loss,
    /// Euclidean norm of d loss / d theta; not finite if any component is not. Zero where the
    /// simulation diverged.
    pub norm: f64,
    /// State after the last frame, if asked for and if it did not diverge.
    pub final_state: Option<State>,
}

/// Optimizer runs side by side, each over the parameters of its own graph.
///
/// Gradients computed by [`Optimizer::measure`] are kept until [`Optimizer::step`] or
/// [`Optimizer::discard`] of their run; several calls of `measure` may precede a step. The same
/// input, build and device give bit-identical positions, however measurements were cut into calls.
/// A call that fails changes no run. An unknown run is an [`Error::InvalidInput`].
pub trait Optimizer: Send {
    /// The model at a run's current position, parameters on the host included. Later steps do not
    /// change it.
    ///
    /// # Errors
    /// If the device fails.
    fn loaded(&mut self, run: usize) -> Result<Loaded, Error>;

    /// Losses and gradients at the runs' current positions. Gradients with respect to controls and
    /// initial states are never computed, even if the request asks for them. After an error some of
    /// the call's gradients may be pending: discard them before continuing.
    ///
    /// # Errors
    /// Those of [`crate::Backend::gradients`].
    fn measure(
        &mut self,
        batch: &[GradientSample],
        request: &GradientRequest,
        cancel: &CancelToken,
    ) -> Result<Vec<GradientNorm>, Error>;

    /// Takes a step of Adam down the weighted sum of the run's pending gradients, which are then
    /// cleared. Coordinates move by at most `rate` times their [`Section::rate`], within their
    /// bounds.
    ///
    /// `weights` has one finite number per pending gradient, in the order of measurement.
    ///
    /// # Errors
    /// If the number of weights differs, or the weighted sum is not finite: then nothing changes
    /// and the gradients stay pending.
    fn step(&mut self, run: usize, weights: &[f64], rate: f64) -> Result<(), Error>;

    /// Drops a run's pending gradients.
    ///
    /// # Errors
    /// If the device fails.
    fn discard(&mut self, run: usize) -> Result<(), Error>;

    /// The position of a run.
    ///
    /// # Errors
    /// If the device fails.
    fn position(&self, run: usize) -> Result<Position, Error>;

    /// Moves a run to a position, sets its timing, and drops its pending gradients.
    ///
    /// # Errors
    /// Those of [`crate::Backend::load`] (stability is checked), or if the position does not fit the
    /// parameterization.
    fn move_to(&mut self, run: usize, position: &Position, timing: Timing) -> Result<(), Error>;
}
