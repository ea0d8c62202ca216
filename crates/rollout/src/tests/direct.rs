//! A backend that simulates everything immediately, one instance after another, so that a time
//! limit ends between two of them.

use std::{
    sync::{
        Arc, Mutex,
        atomic::{AtomicBool, Ordering},
    },
    time::{Duration, Instant},
};

use bendtwin_core::{CancelToken, Environment, Params};
use bendtwin_engine::{
    Backend, Device, Loaded, Model,
    backend::{Error, Gradient, GradientRequest, Instance, Loss, Outputs, Rollout},
    optimizer::{Decay, Optimizer, OptimizerInit},
};

use crate::RolloutBackend;

/// A backend, and the time that it computed.
pub(super) struct Direct {
    backend: Arc<dyn Backend>,
    compute: Mutex<Duration>,
    /// True once forces were measured.
    pub(super) has_measured: AtomicBool,
}

impl Direct {
    pub(super) fn new(backend: Arc<dyn Backend>) -> Self {
        Self { backend, compute: Mutex::default(), has_measured: AtomicBool::default() }
    }
}

impl Backend for Direct {
    fn device(&self) -> Device {
        self.backend.device()
    }
    fn load(&self, model: Arc<Model>) -> Result<Loaded, Error> {
        self.backend.load(model)
    }
    fn with_params(&self, loaded: &Loaded, params: Params) -> Result<Loaded, Error> {
        self.backend.with_params(loaded, params)
    }
    fn with_environment(&self, loaded: &Loaded, to: Environment) -> Result<Loaded, Error> {
        self.backend.with_environment(loaded, to)
    }
    fn roll_out(
        &self,
        batch: &[Instance],
        outputs: &Outputs,
        cancel: &CancelToken,
    ) -> Result<Vec<Rollout>, Error> {
        self.has_measured.fetch_or(outputs.forces, Ordering::Relaxed);
        self.backend.roll_out(batch, outputs, cancel)
    }
    fn losses(&self, batch: &[Instance], cancel: &CancelToken) -> Result<Vec<Loss>, Error> {
        self.backend.losses(batch, cancel)
    }
    fn gradients(
        &self,
        batch: &[Instance],
        request: &GradientRequest,
        cancel: &CancelToken,
    ) -> Result<Vec<Gradient>, Error> {
        self.backend.gradients(batch, request, cancel)
    }
    fn optimizer(
        &self,
        inits: Vec<OptimizerInit>,
        decay: Decay,
    ) -> Result<Box<dyn Optimizer>, Error> {
        self.backend.optimizer(inits, decay)
    }
}

impl RolloutBackend for Direct {
    fn roll_out_in_time(
        &self,
        batch: &[Instance],
        outputs: &Outputs,
        cancel: &CancelToken,
    ) -> Result<Vec<Option<Rollout>>, Error> {
        let begun = Instant::now();
        let one = |instance| {
            if cancel.is_late() {
                return Ok(None);
            }
            match self.roll_out(std::slice::from_ref(instance), outputs, cancel) {
                Err(Error::Cancelled) if cancel.is_late() => Ok(None),
                rollouts => Ok(rollouts?.pop()),
            }
        };
        let rollouts = batch.iter().map(one).collect();
        *self.compute.lock().unwrap() += begun.elapsed();
        rollouts
    }

    fn compute(&self) -> Duration {
        *self.compute.lock().unwrap()
    }
}
