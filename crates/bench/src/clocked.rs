//! A backend that notes how long each kind of call takes, so that a fit's time can be split.

mod optimizer;
mod stopwatch;

use std::sync::{
    Arc,
    atomic::{AtomicU64, Ordering},
};

use bendtwin_core::{CancelToken, Params};
use bendtwin_engine::{
    Backend, Device, Error, Loaded, Model,
    backend::{Gradient, GradientRequest, Instance, Loss, Memory, Outputs, Rollout},
    optimizer::{Decay, Optimizer, OptimizerInit},
};

use self::{optimizer::ClockedOptimizer, stopwatch::Stopwatch};

/// Passes every call on to another backend. A method that the trait gains must be passed on here too, or
/// its default would be timed instead of the backend's own; a test sees to it.
pub(crate) struct Clocked {
    inner: Arc<dyn Backend>,
    clocks: Arc<Clocks>,
}

/// What a call is for.
#[derive(Clone, Copy, Debug)]
enum Kind {
    Load,
    Params,
    Forward,
    Gradient,
    Step,
}

/// What calls took.
#[derive(Debug, Default)]
struct Clocks {
    /// By [`Kind`].
    watches: [Stopwatch; 5],
    /// Instances that were rolled out without a gradient.
    rollouts: AtomicU64,
}

/// Seconds spent so far in each kind of call, and what for. Calls of a kind that run side by side count once.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Spent {
    /// Loading models.
    pub(crate) load_s: f64,
    /// Handing parameters to and fro.
    pub(crate) params_s: f64,
    /// Rollouts and losses.
    pub(crate) forward_s: f64,
    /// Gradients.
    pub(crate) gradient_s: f64,
    /// Steps of the optimiser.
    pub(crate) step_s: f64,
    /// Instances that were rolled out without a gradient.
    pub(crate) rollouts: u64,
}

impl std::ops::Sub for Spent {
    type Output = Self;

    fn sub(self, earlier: Self) -> Self {
        Self {
            load_s: self.load_s - earlier.load_s,
            params_s: self.params_s - earlier.params_s,
            forward_s: self.forward_s - earlier.forward_s,
            gradient_s: self.gradient_s - earlier.gradient_s,
            step_s: self.step_s - earlier.step_s,
            rollouts: self.rollouts - earlier.rollouts,
        }
    }
}

impl Spent {
    /// Seconds of all calls.
    pub(crate) fn total_s(self) -> f64 {
        self.load_s + self.params_s + self.forward_s + self.gradient_s + self.step_s
    }
}

impl Clocks {
    fn time<R>(&self, kind: Kind, work: impl FnOnce() -> R) -> R {
        self.watches[kind as usize].time(work)
    }

    fn roll_out<R>(&self, instances: usize, work: impl FnOnce() -> R) -> R {
        self.rollouts.fetch_add(instances as u64, Ordering::Relaxed);
        self.time(Kind::Forward, work)
    }

    fn seconds(&self, kind: Kind) -> f64 {
        self.watches[kind as usize].seconds()
    }
}

impl Clocked {
    pub(crate) fn new(inner: Arc<dyn Backend>) -> Self {
        Self { inner, clocks: Arc::default() }
    }

    pub(crate) fn spent(&self) -> Spent {
        Spent {
            load_s: self.clocks.seconds(Kind::Load),
            params_s: self.clocks.seconds(Kind::Params),
            forward_s: self.clocks.seconds(Kind::Forward),
            gradient_s: self.clocks.seconds(Kind::Gradient),
            step_s: self.clocks.seconds(Kind::Step),
            rollouts: self.clocks.rollouts.load(Ordering::Relaxed),
        }
    }
}

impl Backend for Clocked {
    fn device(&self) -> Device {
        self.inner.device()
    }

    fn load(&self, model: Arc<Model>) -> Result<Loaded, Error> {
        self.clocks.time(Kind::Load, || self.inner.load(model))
    }

    fn with_params(&self, loaded: &Loaded, params: Params) -> Result<Loaded, Error> {
        self.clocks.time(Kind::Params, || self.inner.with_params(loaded, params))
    }

    fn roll_out(
        &self,
        batch: &[Instance],
        outputs: &Outputs,
        cancel: &CancelToken,
    ) -> Result<Vec<Rollout>, Error> {
        self.clocks.roll_out(batch.len(), || self.inner.roll_out(batch, outputs, cancel))
    }

    fn losses(&self, batch: &[Instance], cancel: &CancelToken) -> Result<Vec<Loss>, Error> {
        self.clocks.roll_out(batch.len(), || self.inner.losses(batch, cancel))
    }

    fn gradients(
        &self,
        batch: &[Instance],
        request: &GradientRequest,
        cancel: &CancelToken,
    ) -> Result<Vec<Gradient>, Error> {
        self.clocks.time(Kind::Gradient, || self.inner.gradients(batch, request, cancel))
    }

    fn optimizer(
        &self,
        inits: Vec<OptimizerInit>,
        decay: Decay,
    ) -> Result<Box<dyn Optimizer>, Error> {
        let inner = self.clocks.time(Kind::Load, || self.inner.optimizer(inits, decay))?;
        Ok(Box::new(ClockedOptimizer { inner, clocks: self.clocks.clone() }))
    }

    fn memory(&self) -> Option<Memory> {
        self.inner.memory()
    }

    fn urgent(&self) -> Option<Arc<dyn Backend>> {
        let inner = self.inner.urgent()?;
        Some(Arc::new(Self { inner, clocks: self.clocks.clone() }))
    }

    fn plan(&self, model: &Loaded, batch: usize) -> Option<String> {
        self.inner.plan(model, batch)
    }
}

#[cfg(test)]
mod tests;
