//! Walking downhill through parameter space: loss and gradient at a point, a
//! weighted step of Adam, and again. Points and gradients stay with the backend,
//! on its device if it has one; the host sees a few numbers per instance.

mod adam;
mod chart;
mod host;
mod parameter;

use bendtwin_core::{CancelToken, Timing};
use serde::{Deserialize, Serialize};

pub use self::{
    adam::{Adam, Decay, EPSILON, Ground},
    chart::{Chart, Scale, Section},
    host::HostDescent,
    parameter::Parameter,
};
use crate::{
    backend::{Error, GradientRequest, Instance, Loaded, Loss},
    model::State,
};

/// Where a walk stands: all that it takes to go on from there with the same bits on the same backend.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Position {
    /// Coordinates of a [`Chart`], shape [`Chart::len`].
    pub theta: Vec<f64>,
    /// Adam's moments.
    pub adam: Adam,
}

impl Position {
    /// At these coordinates, without momentum.
    pub fn at_rest(theta: Vec<f64>) -> Self {
        Self { adam: Adam::new(theta.len()), theta }
    }
}

/// One walk as it begins.
#[derive(Clone, Debug)]
pub struct Start {
    /// The graph and the timing to walk with, loaded by the same backend. Its parameters make
    /// place for those at `position`.
    pub loaded: Loaded,
    /// The coordinates that it walks in.
    pub chart: Chart,
    /// Where it starts.
    pub position: Position,
}

impl Start {
    /// Checks that chart and position belong together.
    ///
    /// # Errors
    /// If lengths differ, or a coordinate or moment is not finite.
    pub fn check(&self) -> Result<(), Error> {
        self.chart.check(&self.loaded.model().graph)?;
        self.chart.check_position(&self.position)
    }
}

/// An instance that is measured on behalf of a walk.
#[derive(Clone, Debug)]
pub struct Probe {
    /// Index of the walk.
    pub walk: usize,
    /// What to simulate. It runs with the walk's current model; its own model is not looked at
    /// (but must be one that the backend loaded).
    pub instance: Instance,
}

/// What the host sees of a gradient.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Slope {
    /// The loss.
    pub loss: Loss,
    /// Euclidean length of d loss / d theta; not finite if any component is not. Zero where it diverged.
    pub length: f64,
    /// State after the last frame, if asked for and if it did not diverge.
    pub final_state: Option<State>,
}

/// Several walks side by side, each through the parameters of its own graph.
///
/// Gradients that [`Descent::measure`] finds wait with the descent until [`Descent::step`] or
/// [`Descent::discard`] of their walk; there may be several calls of `measure` before a step. Same input, build
/// and device: bit-identical positions, however measurements were cut into calls.
/// A call that fails moves no walk. An unknown walk is an [`Error::InvalidInput`].
pub trait Descent: Send {
    /// The model at a walk's current point, parameters on the host included. It stays as it is
    /// when the walk moves on.
    ///
    /// # Errors
    /// If the device fails.
    fn loaded(&mut self, walk: usize) -> Result<Loaded, Error>;

    /// Losses and gradients at the walks' current points; gradients with respect to controls and initial states
    /// are not computed, whatever the request says. After an error some of the call's gradients may
    /// wait: discard them before going on.
    ///
    /// # Errors
    /// As [`crate::Backend::gradients`].
    fn measure(
        &mut self,
        batch: &[Probe],
        request: &GradientRequest,
        cancel: &CancelToken,
    ) -> Result<Vec<Slope>, Error>;

    /// One step of Adam down the weighted sum of the walk's waiting gradients, which are
    /// cleared. Coordinates move by about `rate` times their [`Section::rate`], within their bounds.
    ///
    /// `weights` has one finite number per waiting gradient, in the order in which they were measured.
    ///
    /// # Errors
    /// If the number of weights differs, or the weighted sum is not finite: then nothing moves and
    /// the gradients still wait.
    fn step(&mut self, walk: usize, weights: &[f64], rate: f64) -> Result<(), Error>;

    /// Forgets a walk's waiting gradients.
    ///
    /// # Errors
    /// If the device fails.
    fn discard(&mut self, walk: usize) -> Result<(), Error>;

    /// Where a walk is.
    ///
    /// # Errors
    /// If the device fails.
    fn position(&self, walk: usize) -> Result<Position, Error>;

    /// Moves a walk to a position, with this timing from now on, and forgets its waiting gradients.
    ///
    /// # Errors
    /// As [`crate::Backend::load`] (stability is checked), or if the position does not fit the chart.
    fn move_to(&mut self, walk: usize, position: &Position, timing: Timing) -> Result<(), Error>;
}
