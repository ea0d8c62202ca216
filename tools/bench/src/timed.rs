//! A backend that times each kind of call, so that a fit's time can be split.

mod optimizer;
mod stopwatch;

use std::sync::{
    Arc,
    atomic::{AtomicU64, Ordering},
};

use bendtwin_core::{CancelToken, Environment, Params};
use bendtwin_engine::{
    Backend, Device, Error, Loaded, Model,
    backend::{Gradient, GradientRequest, Instance, Loss, Memory, Outputs, Rollout},
    optimizer::{Decay, Optimizer, OptimizerInit},
};

use self::{optimizer::TimedOptimizer, stopwatch::Stopwatch};

/// A backend that forwards every call to another one and times it. New methods of the trait must be
/// forwarded here too, or the default would be timed instead of the backend's own; a test checks
/// that.
pub(crate) struct TimedBackend {
    inner: Arc<dyn Backend>,
    times: Arc<CallTimes>,
}

/// The kind of a call.
#[derive(Clone, Copy, Debug)]
enum Kind {
    Load,
    Params,
    Forward,
    Gradient,
    Step,
}

/// Time of calls, and the number of rollouts.
#[derive(Debug, Default)]
struct CallTimes {
    /// Stopwatches by [`Kind`].
    watches: [Stopwatch; 5],
    /// Instances that were rolled out without a gradient.
    rollouts: AtomicU64,
}

/// Seconds spent so far in each kind of call. Calls of a kind that run at the same time count once.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct TimeSpent {
    /// Loading models.
    pub(crate) load_s: f64,
    /// Transfers of parameters.
    pub(crate) params_s: f64,
    /// Rollouts and losses.
    pub(crate) forward_s: f64,
    /// Gradients.
    pub(crate) gradient_s: f64,
    /// Steps of the optimizer.
    pub(crate) step_s: f64,
    /// Instances that were rolled out without a gradient.
    pub(crate) rollouts: u64,
}

impl std::ops::Sub for TimeSpent {
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

impl TimeSpent {
    /// Seconds of all calls.
    pub(crate) fn total_s(self) -> f64 {
        self.load_s + self.params_s + self.forward_s + self.gradient_s + self.step_s
    }
}

impl CallTimes {
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

impl TimedBackend {
    pub(crate) fn new(inner: Arc<dyn Backend>) -> Self {
        Self { inner, times: Arc::default() }
    }

    pub(crate) fn spent(&self) -> TimeSpent {
        TimeSpent {
            load_s: self.times.seconds(Kind::Load),
            params_s: self.times.seconds(Kind::Params),
            forward_s: self.times.seconds(Kind::Forward),
            gradient_s: self.times.seconds(Kind::Gradient),
            step_s: self.times.seconds(Kind::Step),
            rollouts: self.times.rollouts.load(Ordering::Relaxed),
        }
    }
}

impl Backend for TimedBackend {
    fn device(&self) -> Device {
        self.inner.device()
    }

    fn load(&self, model: Arc<Model>) -> Result<Loaded, Error> {
        self.times.time(Kind::Load, || self.inner.load(model))
    }

    fn with_params(&self, loaded: &Loaded, params: Params) -> Result<Loaded, Error> {
        self.times.time(Kind::Params, || self.inner.with_params(loaded, params))
    }

    fn with_environment(&self, loaded: &Loaded, environment: Environment) -> Result<Loaded, Error> {
        self.inner.with_environment(loaded, environment)
    }

    fn roll_out(
        &self,
        batch: &[Instance],
        outputs: &Outputs,
        cancel: &CancelToken,
    ) -> Result<Vec<Rollout>, Error> {
        self.times.roll_out(batch.len(), || self.inner.roll_out(batch, outputs, cancel))
    }

    fn losses(&self, batch: &[Instance], cancel: &CancelToken) -> Result<Vec<Loss>, Error> {
        self.times.roll_out(batch.len(), || self.inner.losses(batch, cancel))
    }

    fn gradients(
        &self,
        batch: &[Instance],
        request: &GradientRequest,
        cancel: &CancelToken,
    ) -> Result<Vec<Gradient>, Error> {
        self.times.time(Kind::Gradient, || self.inner.gradients(batch, request, cancel))
    }

    fn optimizer(
        &self,
        inits: Vec<OptimizerInit>,
        decay: Decay,
    ) -> Result<Box<dyn Optimizer>, Error> {
        let inner = self.times.time(Kind::Load, || self.inner.optimizer(inits, decay))?;
        Ok(Box::new(TimedOptimizer { inner, times: self.times.clone() }))
    }

    fn memory(&self) -> Option<Memory> {
        self.inner.memory()
    }

    fn urgent(&self) -> Option<Arc<dyn Backend>> {
        let inner = self.inner.urgent()?;
        Some(Arc::new(Self { inner, times: self.times.clone() }))
    }

    fn plan(&self, model: &Loaded, batch: usize) -> Option<String> {
        self.inner.plan(model, batch)
    }
}

#[cfg(test)]
mod tests;
