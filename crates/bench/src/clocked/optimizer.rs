//! An optimizer that notes how long each kind of call takes.

use std::sync::Arc;

use bendtwin_core::{CancelToken, Timing};
use bendtwin_engine::{
    Error, Loaded,
    backend::GradientRequest,
    optimizer::{GradientNorm, GradientSample, Optimizer, Position},
};

use super::{Clocks, Kind};

/// Passes every call on to another optimizer.
pub(super) struct ClockedOptimizer {
    pub(super) inner: Box<dyn Optimizer>,
    pub(super) clocks: Arc<Clocks>,
}

impl Optimizer for ClockedOptimizer {
    fn loaded(&mut self, walk: usize) -> Result<Loaded, Error> {
        self.clocks.time(Kind::Params, || self.inner.loaded(walk))
    }

    fn measure(
        &mut self,
        batch: &[GradientSample],
        request: &GradientRequest,
        cancel: &CancelToken,
    ) -> Result<Vec<GradientNorm>, Error> {
        self.clocks.time(Kind::Gradient, || self.inner.measure(batch, request, cancel))
    }

    fn step(&mut self, walk: usize, weights: &[f64], rate: f64) -> Result<(), Error> {
        self.clocks.time(Kind::Step, || self.inner.step(walk, weights, rate))
    }

    fn discard(&mut self, walk: usize) -> Result<(), Error> {
        self.clocks.time(Kind::Step, || self.inner.discard(walk))
    }

    fn position(&self, walk: usize) -> Result<Position, Error> {
        self.clocks.time(Kind::Params, || self.inner.position(walk))
    }

    fn move_to(&mut self, walk: usize, position: &Position, timing: Timing) -> Result<(), Error> {
        self.clocks.time(Kind::Params, || self.inner.move_to(walk, position, timing))
    }
}
