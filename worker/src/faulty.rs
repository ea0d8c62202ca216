//! A backend for tests that fails on request, as devices do. Everything else is the CPU's.

use std::sync::{
    Arc, Mutex,
    atomic::{AtomicUsize, Ordering},
};

use bendtwin_core::{CancelToken, Environment, Params};
use bendtwin_engine::{
    Backend, Device, Loaded, Model,
    backend::{
        Divergence, Error, Gradient, GradientRequest, Instance, Loss, Memory, Outputs, Rollout,
    },
    optimizer::{Decay, HostOptimizer, Optimizer, OptimizerInit},
};

/// A fault injected into a rollout.
#[derive(Clone, Debug)]
pub(crate) enum InjectedFault {
    Fails(Error),
    /// Every instance leaves the finite numbers.
    Diverges,
}

/// State shared with the test.
#[derive(Default)]
pub(crate) struct Script {
    /// Number of models that fit in memory together, one byte each.
    pub(crate) room: AtomicUsize,
    resident: AtomicUsize,
    /// Faults of the next rollouts, in order.
    pub(crate) rollouts: Mutex<Vec<InjectedFault>>,
}

impl Script {
    /// Models on the device.
    pub(crate) fn resident(&self) -> usize {
        self.resident.load(Ordering::SeqCst)
    }
}

/// The backend.
#[derive(Clone)]
pub(crate) struct Faulty {
    cpu: Arc<dyn Backend>,
    script: Arc<Script>,
}

/// A model that takes room until it is dropped.
struct CountedModel {
    inner: Loaded,
    script: Arc<Script>,
}

impl Drop for CountedModel {
    fn drop(&mut self) {
        self.script.resident.fetch_sub(1, Ordering::SeqCst);
    }
}

impl Faulty {
    /// A device with memory for `room` models.
    pub(crate) fn new(room: usize) -> (Self, Arc<Script>) {
        let script = Arc::new(Script { room: room.into(), ..Script::default() });
        (Self { cpu: bendtwin_engine::cpu_with_threads(1), script: Arc::clone(&script) }, script)
    }

    fn hold(&self, load: impl FnOnce() -> Result<Loaded, Error>) -> Result<Loaded, Error> {
        let room = self.script.room.load(Ordering::SeqCst);
        if self.script.resident() >= room {
            return Err(Error::OutOfMemory { needed: 1, available: 0 });
        }
        let inner = load()?;
        self.script.resident.fetch_add(1, Ordering::SeqCst);
        let model = Arc::clone(inner.model());
        Ok(Loaded::new(model, Arc::new(CountedModel { inner, script: Arc::clone(&self.script) })))
    }

    fn inner(loaded: &Loaded) -> Loaded {
        loaded.resident::<CountedModel>().unwrap().inner.clone()
    }

    fn batch(batch: &[Instance]) -> Vec<Instance> {
        let one = |i: &Instance| Instance { model: Self::inner(&i.model), ..i.clone() };
        batch.iter().map(one).collect()
    }
}

impl Backend for Faulty {
    fn device(&self) -> Device {
        Device { kind: "cuda".into(), name: "faulty".into(), lanes: 4 }
    }
    fn load(&self, model: Arc<Model>) -> Result<Loaded, Error> {
        self.hold(|| self.cpu.load(model))
    }
    fn with_params(&self, loaded: &Loaded, params: Params) -> Result<Loaded, Error> {
        self.hold(|| self.cpu.with_params(&Self::inner(loaded), params))
    }
    fn with_environment(&self, loaded: &Loaded, environment: Environment) -> Result<Loaded, Error> {
        self.hold(|| self.cpu.with_environment(&Self::inner(loaded), environment))
    }
    fn roll_out(
        &self,
        batch: &[Instance],
        outputs: &Outputs,
        cancel: &CancelToken,
    ) -> Result<Vec<Rollout>, Error> {
        let mut script = self.script.rollouts.lock().unwrap();
        let injected = (!script.is_empty()).then(|| script.remove(0));
        drop(script);
        match injected {
            Some(InjectedFault::Fails(error)) => Err(error),
            Some(InjectedFault::Diverges) => {
                let nan = Rollout {
                    cost: f64::NAN,
                    diverged: Some(Divergence { frame: 1, node: 0 }),
                    ..Rollout::default()
                };
                Ok(vec![nan; batch.len()])
            }
            None => self.cpu.roll_out(&Self::batch(batch), outputs, cancel),
        }
    }
    fn losses(&self, batch: &[Instance], cancel: &CancelToken) -> Result<Vec<Loss>, Error> {
        self.cpu.losses(&Self::batch(batch), cancel)
    }
    fn gradients(
        &self,
        batch: &[Instance],
        request: &GradientRequest,
        cancel: &CancelToken,
    ) -> Result<Vec<Gradient>, Error> {
        self.cpu.gradients(&Self::batch(batch), request, cancel)
    }
    fn optimizer(
        &self,
        inits: Vec<OptimizerInit>,
        decay: Decay,
    ) -> Result<Box<dyn Optimizer>, Error> {
        Ok(Box::new(HostOptimizer::new(Arc::new(self.clone()), inits, decay)?))
    }
    fn memory(&self) -> Option<Memory> {
        let total = self.script.room.load(Ordering::SeqCst) as u64;
        Some(Memory { used: self.script.resident() as u64, total })
    }
}
