//! The compute device: OS threads that own the backend, each behind a queue. Callers use it through
//! a [`QueuedBackend`], which cuts their batches into slices.
//!
//! If [`Backend::urgent`] gives a second queue, as those of the CPU and of CUDA do, rollouts have a
//! separate thread, and fits pause for them between two frames: [`alternation`]. On a device with
//! one queue one thread does everything, slice by slice. Either way the slices of a queue take
//! [`turns`].

mod accounts;
mod alternation;
mod blame;
mod queue;
mod queued;
mod thread;
mod turns;

use std::{
    sync::{Arc, Mutex, PoisonError},
    time::{Duration, Instant},
};

use bendtwin_contract::rollout::split;
use bendtwin_core::CancelToken;
use bendtwin_engine::{
    Backend, Device as Description,
    backend::{self, Memory},
};
use tokio::sync::mpsc;

pub(crate) use self::accounts::Account;
pub(crate) use self::queue::Priority;
pub(crate) use self::queued::QueuedBackend;
use self::{
    accounts::Accounts,
    alternation::Alternation,
    blame::Blame,
    queue::{BrokenDevice, Queue},
    thread::{BackendInfo, Threads},
    turns::Flow,
};
use crate::Error;

/// Target time of a slice for which another rollout waits: one of a rollout on the CPU, and any on
/// a device with one queue. Rollouts should wait at most 50 ms beyond their computing time;
/// estimates of a slice's time may be off by half. A single instance that takes longer cannot be
/// cut.
const SHARED_SLICE: Duration = Duration::from_millis(30);
/// Work of a rollout's slice on a GPU with a second queue, in element substeps. By work and not by
/// time, because the last bits of a GPU's results depend on the number of instances in a batch: the
/// same request must always be cut in the same way, and a server that shares a batch among workers
/// cuts it at the ends of slices.
const URGENT_WORK: f64 = split::SLICE_WORK;
/// Kind of the device whose results do not depend on how a batch is cut.
const CPU: &str = "cpu";

/// A handle on the device; clones share it. Its threads end on [`Device::close`].
#[derive(Clone)]
pub(crate) struct Device {
    threads: Arc<Threads>,
    description: Description,
    /// Pauses of fits and rollouts, if rollouts have a separate thread.
    alternation: Option<Alternation>,
    accounts: Arc<Accounts>,
    blame: Blame,
    /// Turns of work for the processor, if that is not the device.
    beside: Arc<tokio::sync::Mutex<()>>,
}

/// Work for a device's thread, which keeps its result itself.
type Computation = Box<dyn FnOnce(&dyn Backend) -> Result<(), backend::Error> + Send>;

impl Device {
    /// Starts the threads and opens the backend on them. Fits get `fit_share` of the device's time,
    /// 0 to below 1, while rollouts want all of it.
    ///
    /// A panic in a task is caught: its caller gets an error, the device takes no more work, and
    /// the error is sent to `fatal`, because the state of the device is unknown then.
    /// [`backend::Error::Device`] ends the device, too: a CUDA context does not recover from a
    /// failed launch.
    pub(crate) fn spawn<F>(
        open: F,
        fatal: mpsc::UnboundedSender<Error>,
        fit_share: f64,
    ) -> Result<Self, Error>
    where
        F: FnOnce() -> Result<Arc<dyn Backend>, Error> + Send + 'static,
    {
        let threads = Arc::new(Threads::new(fatal, fit_share));
        let BackendInfo { description, urgent } = threads.start(open)?;
        let alternation = urgent.is_some().then(|| Alternation::new(fit_share));
        if let Some(urgent) = urgent {
            threads.start_urgent(urgent)?;
        }
        let (accounts, blame, beside) = (Arc::default(), Blame::default(), Arc::default());
        Ok(Self { threads, description, alternation, accounts, blame, beside })
    }

    /// Description of the backend's hardware.
    pub(crate) fn description(&self) -> &Description {
        &self.description
    }

    /// True if the device is the processor, on whose cores everything else runs as well.
    pub(crate) fn is_processor(&self) -> bool {
        self.description.kind == CPU
    }

    /// Priority of the task that broke the device, if one has.
    pub(crate) fn broken_by(&self) -> Option<Priority> {
        self.blame.get()
    }

    /// The device's memory as of its last task, at most about a second old; never waits.
    pub(crate) fn memory(&self) -> Option<Memory> {
        self.threads.memory()
    }

    /// Samples the memory immediately.
    #[cfg(test)]
    pub(crate) fn sample_memory_now(&self) {
        let memory = self.backend(Priority::Interactive).memory();
        self.threads.set_memory(memory);
    }

    /// A backend whose calls run on the device with this priority.
    pub(crate) fn backend(&self, priority: Priority) -> QueuedBackend {
        QueuedBackend::new(self.clone(), Flow::new(priority))
    }

    /// A backend for a request, whose calls take the turns of an account; without one it
    /// has separate turns.
    pub(crate) fn backend_for(&self, account: Option<&Account>) -> QueuedBackend {
        let flow = match account {
            Some(account) => Flow::of(Priority::Interactive, self.accounts.standing(account)),
            None => Flow::new(Priority::Interactive),
        };
        QueuedBackend::new(self.clone(), flow)
    }

    /// Sets how memory is freed on a shortage. `reclaim` frees about the given number of bytes, or
    /// returns false if there is nothing to free. Only the first call has an effect.
    pub(crate) fn on_shortage(&self, reclaim: impl Fn(u64) -> bool + Send + Sync + 'static) {
        self.threads.on_shortage(Box::new(reclaim));
    }

    fn reclaim(&self, bytes: u64) -> bool {
        self.threads.reclaim(bytes)
    }

    /// Ends the threads once their current tasks are done; waiting and later callers get an error.
    pub(crate) fn close(&self) {
        self.threads.close();
    }

    /// Work of a slice, in element substeps, for a caller with this measured speed.
    fn slice_work(&self, priority: Priority, speed: Option<f64>) -> f64 {
        let has_urgent = self.alternation.is_some();
        match (has_urgent, priority) {
            // Nothing waits for it: it pauses while it computes, and checks for cancellation.
            (true, Priority::Background) => f64::INFINITY,
            (true, Priority::Interactive) if !self.is_processor() => URGENT_WORK,
            _ => speed.unwrap_or(0.0) * SHARED_SLICE.as_secs_f64(),
        }
    }

    /// The token to compute with at this priority: who checks it pauses for work of the other one.
    fn token(&self, priority: Priority, cancel: &CancelToken) -> CancelToken {
        match &self.alternation {
            Some(alternation) => alternation.token(priority, cancel),
            None => cancel.clone(),
        }
    }

    fn queue(&self, priority: Priority) -> &Queue {
        match (&self.alternation, priority) {
            (Some(_), Priority::Interactive) => &self.threads.urgent,
            _ => &self.threads.main,
        }
    }

    /// Runs a task on the device and waits for it. Also returns the time it ran.
    fn call<R: Send + 'static>(
        &self,
        flow: &Arc<Flow>,
        task: impl FnOnce(&dyn Backend) -> Result<R, backend::Error> + Send + 'static,
    ) -> Result<(R, Duration), backend::Error> {
        // Only this is compiled for each type of a value; the channel is not.
        let value = Arc::new(Mutex::new(None));
        let slot = Arc::clone(&value);
        let task = move |backend: &dyn Backend| {
            let value = task(backend)?;
            *slot.lock().unwrap_or_else(PoisonError::into_inner) = Some(value);
            Ok(())
        };
        let took = self.run(flow, Box::new(task))?;
        let value = value.lock().unwrap_or_else(PoisonError::into_inner).take();
        Ok((value.ok_or_else(dropped)?, took))
    }

    /// Runs a task on the device and waits for it. Returns the time it ran.
    fn run(&self, flow: &Arc<Flow>, task: Computation) -> Result<Duration, backend::Error> {
        let (reply, result) = std::sync::mpsc::sync_channel(1);
        let watch = self.blame.watch(flow.priority);
        let rollouts = self.alternation.as_ref().filter(|_| flow.priority == Priority::Interactive);
        let under_way = rollouts.map(Alternation::begin);
        let task = move |backend: &dyn Backend| {
            // Also ends where the task is dropped before its turn.
            let _under_way = under_way;
            let watch = watch;
            let started = Instant::now();
            let done = task(backend);
            let took = started.elapsed();
            let broken = match &done {
                Err(backend::Error::Device(why)) => {
                    watch.broke();
                    Err(BrokenDevice(why.clone()))
                }
                _ => Ok(()),
            };
            // The caller waits below, so sending cannot fail while it lives.
            let _ = reply.send(done.map(|()| took));
            broken
        };
        self.queue(flow.priority).push(flow, Box::new(task));
        result.recv().unwrap_or_else(|_| Err(dropped()))
    }
}

/// The error of a task that was dropped before its end.
fn dropped() -> backend::Error {
    let why = "it failed in other work, or the worker ends: try again";
    backend::Error::Device(why.to_owned())
}

#[cfg(test)]
mod tests;
