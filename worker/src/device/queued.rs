//! A [`Backend`] that queues its batches for the device thread in slices.
//!
//! The effect of cutting on the bits of results is described in [`cut`](bendtwin_rollout::cut): rollouts of a
//! GPU with an urgent queue are cut by work alone, never by measured time. Instances of similar
//! work share a slice, so that no core idles long.

mod optimizer;

use std::{
    sync::{Arc, Mutex, PoisonError},
    time::Duration,
};

use bendtwin_core::{CancelToken, Environment, Params};
use bendtwin_engine::{
    Backend, Device as Description, Loaded, Model,
    backend::{Error, Gradient, GradientRequest, Instance, Loss, Memory, Outputs, Rollout},
    optimizer::{Decay, Optimizer, OptimizerInit},
};
use bendtwin_rollout::{RolloutBackend, cut::next_run};

use self::optimizer::QueuedOptimizer;
use super::{Device, turns::Flow};

/// Direction of a pass through the frames: a gradient costs several times a rollout.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Pass {
    Forward,
    Backward,
}

/// Device time that a backend has used.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Usage {
    /// Time in which the device computed for this backend.
    pub(crate) compute: Duration,
    /// Work done in it, in element substeps.
    work: f64,
}

/// A backend whose calls are queued for the device as those of one request or fit.
pub(crate) struct QueuedBackend(Arc<Shared>);

/// State that the backend and its descents share.
struct Shared {
    device: Device,
    flow: Arc<Flow>,
    forward: Mutex<Usage>,
    backward: Mutex<Usage>,
}

impl QueuedBackend {
    pub(super) fn new(device: Device, flow: Arc<Flow>) -> Self {
        let (forward, backward) = (Mutex::default(), Mutex::default());
        Self(Arc::new(Shared { device, flow, forward, backward }))
    }

    /// Runs a short piece of work on the cores of the processor, in the turns of this backend if the processor is
    /// the device. Beside another device, which it must not keep waiting, pieces take turns in the order of arrival.
    /// Blocks its thread, which must not be one of the runtime's own.
    ///
    /// # Errors
    /// If the device has failed.
    pub(crate) fn on_processor<R: Send + 'static>(
        &self,
        work: impl FnOnce() -> R + Send + 'static,
    ) -> Result<R, Error> {
        if self.0.device.is_processor() {
            return Ok(self.0.call_once(move |_| Ok(work()))?.0);
        }
        let _turn = self.0.device.beside.blocking_lock();
        Ok(work())
    }

    /// Results, none of what is not done by the time of the token.
    fn sliced<R: Send + 'static>(
        &self,
        batch: &[Instance],
        pass: Pass,
        cancel: &CancelToken,
        run: impl Fn(&dyn Backend, &[Instance]) -> Result<Vec<R>, Error> + Clone + Send + 'static,
    ) -> Result<Vec<Option<R>>, Error> {
        let work: Vec<f64> = batch.iter().map(instance_work).collect();
        let mut order: Vec<usize> = (0..batch.len()).collect();
        // Stable, so that equal instances keep their order.
        order.sort_by(|a, b| work[*b].total_cmp(&work[*a]));
        self.0.in_slices(batch, &work, &order, pass, cancel, |instances| {
            let (instances, run) = (Arc::new(instances), run.clone());
            self.0.call(move |backend| run(backend, &instances))
        })
    }
}

impl Shared {
    /// Runs a task on the device. If memory is lacking, other users of the device free some and the
    /// task runs again: first the estimated amount, then everything.
    fn call<R: Send + 'static>(
        &self,
        task: impl Fn(&dyn Backend) -> Result<R, Error> + Clone + Send + 'static,
    ) -> Result<(R, Duration), Error> {
        let mut result = self.call_once(task.clone());
        for all in [false, true] {
            let Err(Error::OutOfMemory { needed, available }) = result else { break };
            let lacking = if all { u64::MAX } else { needed.saturating_sub(available) };
            let hopeless = self.device.memory().is_some_and(|m| needed > m.total);
            if !hopeless && self.device.reclaim(lacking) {
                result = self.call_once(task.clone());
            }
        }
        result
    }

    fn token(&self, cancel: &CancelToken) -> CancelToken {
        self.device.token(self.flow.priority, cancel)
    }

    fn usage(&self, pass: Pass) -> &Mutex<Usage> {
        match pass {
            Pass::Forward => &self.forward,
            Pass::Backward => &self.backward,
        }
    }

    /// Runs a task that cannot be repeated.
    fn call_once<R: Send + 'static>(
        &self,
        task: impl FnOnce(&dyn Backend) -> Result<R, Error> + Send + 'static,
    ) -> Result<(R, Duration), Error> {
        self.device.call(&self.flow, task)
    }

    /// Runs a batch in slices, in this order; `run` takes a slice to the device. Results are in the
    /// batch's order, none of what is not done by the time of the token.
    fn in_slices<T: Clone, R>(
        &self,
        batch: &[T],
        work: &[f64],
        order: &[usize],
        pass: Pass,
        cancel: &CancelToken,
        run: impl Fn(Vec<T>) -> Result<(Vec<R>, Duration), Error>,
    ) -> Result<Vec<Option<R>>, Error> {
        let usage = self.usage(pass);
        let mut results: Vec<Option<R>> = batch.iter().map(|_| None).collect();
        let mut rest = order;
        while !rest.is_empty() {
            if cancel.is_late() {
                break;
            }
            if cancel.is_cancelled() {
                return Err(Error::Cancelled);
            }
            let speed = lock(usage).speed();
            let budget = self.device.slice_work(self.flow.priority, speed);
            let count = slice_len(rest, work, budget, self.device.description().lanes);
            let (slice, later) = rest.split_at(count);
            rest = later;
            let (values, took) = match run(slice.iter().map(|i| batch[*i].clone()).collect()) {
                Err(Error::Cancelled) if cancel.is_late() => break,
                done => done?,
            };
            if values.len() != slice.len() {
                let fault = format!("{} results for {} instances", values.len(), slice.len());
                return Err(Error::Device(fault));
            }
            let slice_work = slice.iter().map(|i| work[*i]).sum();
            lock(usage).add(took, slice_work);
            for (index, value) in slice.iter().zip(values) {
                results[*index] = Some(value);
            }
        }
        Ok(results)
    }
}

impl Backend for QueuedBackend {
    fn device(&self) -> Description {
        self.0.device.description().clone()
    }

    fn load(&self, model: Arc<Model>) -> Result<Loaded, Error> {
        Ok(self.0.call(move |backend| backend.load(Arc::clone(&model)))?.0)
    }

    fn with_params(&self, loaded: &Loaded, params: Params) -> Result<Loaded, Error> {
        let (loaded, params) = (loaded.clone(), Arc::new(params));
        Ok(self.0.call(move |backend| backend.with_params(&loaded, Params::clone(&params)))?.0)
    }

    fn with_environment(&self, loaded: &Loaded, environment: Environment) -> Result<Loaded, Error> {
        let loaded = loaded.clone();
        Ok(self.0.call(move |backend| backend.with_environment(&loaded, environment))?.0)
    }

    fn roll_out(
        &self,
        batch: &[Instance],
        outputs: &Outputs,
        cancel: &CancelToken,
    ) -> Result<Vec<Rollout>, Error> {
        all(self.roll_out_in_time(batch, outputs, cancel)?)
    }

    fn losses(&self, batch: &[Instance], cancel: &CancelToken) -> Result<Vec<Loss>, Error> {
        let token = self.0.token(cancel);
        all(self.sliced(batch, Pass::Forward, cancel, move |backend, slice| {
            backend.losses(slice, &token)
        })?)
    }

    fn gradients(
        &self,
        batch: &[Instance],
        request: &GradientRequest,
        cancel: &CancelToken,
    ) -> Result<Vec<Gradient>, Error> {
        let (request, token) = (request.clone(), self.0.token(cancel));
        all(self.sliced(batch, Pass::Backward, cancel, move |backend, slice| {
            backend.gradients(slice, &request, &token)
        })?)
    }

    fn optimizer(
        &self,
        inits: Vec<OptimizerInit>,
        decay: Decay,
    ) -> Result<Box<dyn Optimizer>, Error> {
        Ok(Box::new(QueuedOptimizer::new(self.0.clone(), inits, decay)?))
    }

    fn memory(&self) -> Option<Memory> {
        self.0.call_once(|backend| Ok(backend.memory())).ok()?.0
    }

    fn plan(&self, model: &Loaded, batch: usize) -> Option<String> {
        let model = model.clone();
        self.0.call_once(move |backend| Ok(backend.plan(&model, batch))).ok()?.0
    }
}

impl RolloutBackend for QueuedBackend {
    /// Slices are those of the whole batch, so finished instances have the same bits.
    fn roll_out_in_time(
        &self,
        batch: &[Instance],
        outputs: &Outputs,
        cancel: &CancelToken,
    ) -> Result<Vec<Option<Rollout>>, Error> {
        let (outputs, token) = (outputs.clone(), self.0.token(cancel));
        self.sliced(batch, Pass::Forward, cancel, move |backend, slice| {
            backend.roll_out(slice, &outputs, &token)
        })
    }

    fn compute(&self) -> Duration {
        lock(&self.0.forward).compute + lock(&self.0.backward).compute
    }
}

impl Usage {
    fn add(&mut self, took: Duration, work: f64) {
        self.compute += took;
        self.work += work;
    }

    /// Work per second, once there was any.
    fn speed(&self) -> Option<f64> {
        let seconds = self.compute.as_secs_f64();
        (seconds > 0.0).then(|| self.work / seconds)
    }
}

/// All results of a call that has to come to its end.
fn all<R>(results: Vec<Option<R>>) -> Result<Vec<R>, Error> {
    results.into_iter().collect::<Option<_>>().ok_or(Error::Cancelled)
}

/// Number of instances in `rest` that the next slice takes: whole rounds of SIMD lanes that fit the
/// budget, and at least one round. The first round measures the speed if it is unknown.
fn slice_len(rest: &[usize], work: &[f64], budget: f64, lanes: usize) -> usize {
    let mut sum = 0.0;
    next_run(rest.len(), lanes, |round| {
        sum += rest[round].iter().map(|i| work[*i]).sum::<f64>();
        sum <= budget
    })
}

/// Estimated work of an instance, in element substeps.
fn instance_work(instance: &Instance) -> f64 {
    let model = instance.model.model();
    let elements =
        model.graph.node_count() + model.graph.springs.len() + 2 * model.graph.triplets.len();
    elements.max(1) as f64 * f64::from(model.timing.substeps) * instance.frames.max(1) as f64
}

fn lock(usage: &Mutex<Usage>) -> std::sync::MutexGuard<'_, Usage> {
    usage.lock().unwrap_or_else(PoisonError::into_inner)
}
