//! An optimizer that times each kind of call.

use std::sync::Arc;

use bendtwin_core::{CancelToken, Timing};
use bendtwin_engine::{
    Error, Loaded,
    backend::GradientRequest,
    optimizer::{GradientNorm, GradientSample, Optimizer, Position},
};

use super::{CallTimes, Kind};

/// An optimizer that forwards every call to another one and times it.
pub(super) struct TimedOptimizer {
    pub(super) inner: Box<dyn Optimizer>,
    pub(super) times: Arc<CallTimes>,
}

impl Optimizer for TimedOptimizer {
    fn loaded(&mut self, run: usize) -> Result<Loaded, Error> {
        self.times.time(Kind::Params, || self.inner.loaded(run))
    }

    fn measure(
        &mut self,
        batch: &[GradientSample],
        request: &GradientRequest,
        cancel: &CancelToken,
    ) -> Result<Vec<GradientNorm>, Error> {
        self.times.time(Kind::Gradient, || self.inner.measure(batch, request, cancel))
    }

    fn step(&mut self, run: usize, weights: &[f64], rate: f64) -> Result<(), Error> {
        self.times.time(Kind::Step, || self.inner.step(run, weights, rate))
    }

    fn discard(&mut self, run: usize) -> Result<(), Error> {
        self.times.time(Kind::Step, || self.inner.discard(run))
    }

    fn position(&self, run: usize) -> Result<Position, Error> {
        self.times.time(Kind::Params, || self.inner.position(run))
    }

    fn move_to(&mut self, run: usize, position: &Position, timing: Timing) -> Result<(), Error> {
        self.times.time(Kind::Params, || self.inner.move_to(run, position, timing))
    }
}
