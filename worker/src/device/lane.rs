//! A [`Backend`] that sends its batches to the device thread in slices.
//!
//! Instances are independent, so a batch may be cut anywhere and run in any
//! order without changing a bit of any result. Slices are cut by estimated
//! work: instances of like size run side by side, so that no core idles long.

mod descent;

use std::{
    sync::{Arc, Mutex, PoisonError},
    time::Duration,
};

use bendtwin_core::{CancelToken, Params};
use bendtwin_engine::{
    Backend, Device as Description, Loaded, Model,
    backend::{Error, Gradient, GradientRequest, Instance, Loss, Memory, Recording, Rollout},
    descent::{Decay, Descent, Start},
};

use self::descent::LaneDescent;

use super::{Device, Priority};

/// Which way through the frames, for a gradient costs several times a rollout.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Way {
    Forward,
    Backward,
}

/// Device time that a lane has used.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Usage {
    /// Time in which the device computed for this lane.
    pub(crate) compute: Duration,
    /// Work done in it, in element substeps.
    work: f64,
}

/// The device as one caller sees it.
pub(crate) struct Lane(Arc<Access>);

/// What a lane and its descents share.
struct Access {
    device: Device,
    priority: Priority,
    forward: Mutex<Usage>,
    backward: Mutex<Usage>,
}

impl Lane {
    pub(super) fn new(device: Device, priority: Priority) -> Self {
        let (forward, backward) = (Mutex::default(), Mutex::default());
        Self(Arc::new(Access { device, priority, forward, backward }))
    }

    /// Device time used so far.
    pub(crate) fn compute(&self) -> Duration {
        lock(&self.0.forward).compute + lock(&self.0.backward).compute
    }

    fn sliced<R: Send + 'static>(
        &self,
        batch: &[Instance],
        way: Way,
        cancel: &CancelToken,
        run: impl Fn(&dyn Backend, &[Instance]) -> Result<Vec<R>, Error> + Clone + Send + 'static,
    ) -> Result<Vec<R>, Error> {
        let work: Vec<f64> = batch.iter().map(instance_work).collect();
        let mut order: Vec<usize> = (0..batch.len()).collect();
        // Stable, so that equal instances keep their order.
        order.sort_by(|a, b| work[*b].total_cmp(&work[*a]));
        self.0.in_slices(batch, &work, &order, way, cancel, |instances| {
            let (instances, run) = (Arc::new(instances), run.clone());
            self.0.call(move |backend| run(backend, &instances))
        })
    }
}

impl Access {
    /// Runs a job on the device. If it lacks memory, what can be spared there is given up and the job
    /// runs again: first as much as was lacking, by estimate, then everything.
    fn call<R: Send + 'static>(
        &self,
        job: impl Fn(&dyn Backend) -> Result<R, Error> + Clone + Send + 'static,
    ) -> Result<(R, Duration), Error> {
        let mut result = self.call_once(job.clone());
        for all in [false, true] {
            let Err(Error::OutOfMemory { needed, available }) = result else { break };
            let lacking = if all { u64::MAX } else { needed.saturating_sub(available) };
            let hopeless = self.device.memory().is_some_and(|m| needed > m.total);
            if !hopeless && self.device.reclaim(lacking) {
                result = self.call_once(job.clone());
            }
        }
        result
    }

    fn usage(&self, way: Way) -> &Mutex<Usage> {
        match way {
            Way::Forward => &self.forward,
            Way::Backward => &self.backward,
        }
    }

    /// Runs a job that cannot run twice.
    fn call_once<R: Send + 'static>(
        &self,
        job: impl FnOnce(&dyn Backend) -> Result<R, Error> + Send + 'static,
    ) -> Result<(R, Duration), Error> {
        self.device.call(self.priority, job)
    }

    /// Runs a batch in slices, in this order; `run` takes a slice to the device. Results come in the batch's order.
    fn in_slices<T: Clone, R>(
        &self,
        batch: &[T],
        work: &[f64],
        order: &[usize],
        way: Way,
        cancel: &CancelToken,
        run: impl Fn(Vec<T>) -> Result<(Vec<R>, Duration), Error>,
    ) -> Result<Vec<R>, Error> {
        let usage = self.usage(way);
        let mut results: Vec<Option<R>> = batch.iter().map(|_| None).collect();
        let mut rest = order;
        while !rest.is_empty() {
            if cancel.is_cancelled() {
                return Err(Error::Cancelled);
            }
            let speed = lock(usage).speed();
            let budget = self.device.slice_work(self.priority, speed);
            let count = slice_len(rest, work, budget, self.device.description().lanes);
            let (slice, later) = rest.split_at(count);
            rest = later;
            let (values, took) = run(slice.iter().map(|i| batch[*i].clone()).collect())?;
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
        Ok(results.into_iter().flatten().collect())
    }
}

impl Backend for Lane {
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

    fn roll_out(
        &self,
        batch: &[Instance],
        recording: &Recording,
        cancel: &CancelToken,
    ) -> Result<Vec<Rollout>, Error> {
        let (recording, token) = (recording.clone(), cancel.clone());
        self.sliced(batch, Way::Forward, cancel, move |backend, slice| {
            backend.roll_out(slice, &recording, &token)
        })
    }

    fn losses(&self, batch: &[Instance], cancel: &CancelToken) -> Result<Vec<Loss>, Error> {
        let token = cancel.clone();
        self.sliced(batch, Way::Forward, cancel, move |backend, slice| {
            backend.losses(slice, &token)
        })
    }

    fn gradients(
        &self,
        batch: &[Instance],
        request: &GradientRequest,
        cancel: &CancelToken,
    ) -> Result<Vec<Gradient>, Error> {
        let (request, token) = (request.clone(), cancel.clone());
        self.sliced(batch, Way::Backward, cancel, move |backend, slice| {
            backend.gradients(slice, &request, &token)
        })
    }

    fn descent(&self, starts: Vec<Start>, decay: Decay) -> Result<Box<dyn Descent>, Error> {
        Ok(Box::new(LaneDescent::new(self.0.clone(), starts, decay)?))
    }

    fn memory(&self) -> Option<Memory> {
        self.0.call_once(|backend| Ok(backend.memory())).ok()?.0
    }

    fn plan(&self, model: &Loaded, batch: usize) -> Option<String> {
        let model = model.clone();
        self.0.call_once(move |backend| Ok(backend.plan(&model, batch))).ok()?.0
    }
}

impl Usage {
    fn add(&mut self, took: Duration, work: f64) {
        self.compute += took;
        self.work += work;
    }

    /// Work a second, once there was any.
    fn speed(&self) -> Option<f64> {
        let seconds = self.compute.as_secs_f64();
        (seconds > 0.0).then(|| self.work / seconds)
    }
}

/// How many of the instances in `rest` the next slice takes: whole rounds of lanes while they fit the
/// budget, and one round at least: where no speed is known yet, it is found out with that.
fn slice_len(rest: &[usize], work: &[f64], budget: f64, lanes: usize) -> usize {
    let lanes = lanes.max(1);
    let mut taken = lanes.min(rest.len());
    let mut sum: f64 = rest[..taken].iter().map(|i| work[*i]).sum();
    while taken < rest.len() {
        let next = (taken + lanes).min(rest.len());
        sum += rest[taken..next].iter().map(|i| work[*i]).sum::<f64>();
        if sum > budget {
            break;
        }
        taken = next;
    }
    taken
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
