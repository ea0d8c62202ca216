//! The compute device: OS threads that own the backend, each behind a queue. Callers see a
//! [`Backend`] again, a [`Lane`], which cuts their batches into slices.
//!
//! Most devices have one queue: then one thread does everything, with two priorities, and between two
//! slices of a fit a rollout gets its turn. Where [`Backend::urgent`] gives a second one, rollouts have
//! a thread of their own and run while fits do.

mod lane;
mod queue;
mod thread;

use std::{
    sync::Arc,
    time::{Duration, Instant},
};

use bendtwin_engine::{
    Backend, Device as Description,
    backend::{self, Memory},
};
use tokio::sync::mpsc;

pub(crate) use self::lane::Lane;
pub(crate) use self::queue::Priority;
use self::{
    queue::{Broken, Queue},
    thread::{Opened, Threads},
};
use crate::Error;

/// How long a slice should take on a device with one queue, where it is what a rollout waits for beside
/// a fit. Rollouts are to be answered within 50 ms of their own time; estimates of a slice's time may
/// be off by half. A single instance that takes longer cannot be cut.
const SHARED_SLICE: Duration = Duration::from_millis(30);
/// Work of a rollout's slice where rollouts have a queue of their own, in element substeps: a fraction of a
/// second on a large GPU. By work and not by time, since how a GPU computes a batch, and with it the last
/// bits of the result, depends on how many instances there are: the same request must be cut alike.
const URGENT_WORK: f64 = 5e10;

/// A handle on the device; clones share it. Its threads end on [`Device::close`].
#[derive(Clone)]
pub(crate) struct Device {
    threads: Arc<Threads>,
    description: Description,
    /// Whether rollouts have a thread of their own.
    has_urgent: bool,
}

impl Device {
    /// Starts the threads and opens the backend on them.
    ///
    /// A panic in a job is caught: its caller gets an error, the device takes no more work, and `fatal`
    /// is told, for the state of a device is unknown then. [`backend::Error::Device`] ends it alike: a
    /// failed launch leaves a CUDA context that does not heal.
    pub(crate) fn spawn<F>(open: F, fatal: mpsc::UnboundedSender<Error>) -> Result<Self, Error>
    where
        F: FnOnce() -> Result<Arc<dyn Backend>, Error> + Send + 'static,
    {
        let threads = Arc::new(Threads::new(fatal));
        let Opened { description, urgent } = threads.start(open)?;
        let has_urgent = urgent.is_some();
        if let Some(urgent) = urgent {
            threads.start_urgent(urgent)?;
        }
        Ok(Self { threads, description, has_urgent })
    }

    /// What the backend runs on.
    pub(crate) fn description(&self) -> &Description {
        &self.description
    }

    /// The device's memory as of its last job, give or take a second; never waits.
    pub(crate) fn memory(&self) -> Option<Memory> {
        self.threads.memory()
    }

    /// Looks at the memory before the next job asks.
    #[cfg(test)]
    pub(crate) fn look_now(&self) {
        let memory = self.lane(Priority::Interactive).memory();
        self.threads.set_memory(memory);
    }

    /// A backend whose calls run on the device with this priority.
    pub(crate) fn lane(&self, priority: Priority) -> Lane {
        Lane::new(self.clone(), priority)
    }

    /// Says how the device's users give up memory that they can spare: about so many bytes, or nothing and
    /// false. The first word counts.
    pub(crate) fn on_shortage(&self, spare: impl Fn(u64) -> bool + Send + Sync + 'static) {
        self.threads.on_shortage(Box::new(spare));
    }

    fn reclaim(&self, bytes: u64) -> bool {
        self.threads.reclaim(bytes)
    }

    /// Ends the threads once their current jobs are done; waiting and later callers get an error.
    pub(crate) fn close(&self) {
        self.threads.close();
    }

    /// Work of a slice, in element substeps, for a caller who has seen this speed.
    fn slice_work(&self, priority: Priority, speed: Option<f64>) -> f64 {
        match (self.has_urgent, priority) {
            (false, _) => speed.unwrap_or(0.0) * SHARED_SLICE.as_secs_f64(),
            (true, Priority::Interactive) => URGENT_WORK,
            // Nobody waits for it; such a backend hears of cancellations while it computes.
            (true, Priority::Background) => f64::INFINITY,
        }
    }

    fn queue(&self, priority: Priority) -> &Queue {
        match (self.has_urgent, priority) {
            (true, Priority::Interactive) => &self.threads.urgent,
            _ => &self.threads.main,
        }
    }

    /// Runs a job on the device and waits for it. Also says how long it ran.
    fn call<R: Send + 'static>(
        &self,
        priority: Priority,
        job: impl FnOnce(&dyn Backend) -> Result<R, backend::Error> + Send + 'static,
    ) -> Result<(R, Duration), backend::Error> {
        let (reply, result) = std::sync::mpsc::sync_channel(1);
        let job = move |backend: &dyn Backend| {
            let started = Instant::now();
            let value = job(backend);
            let took = started.elapsed();
            let broken = match &value {
                Err(backend::Error::Device(why)) => Err(Broken(why.clone())),
                _ => Ok(()),
            };
            // The caller waits below, so sending cannot fail while it lives.
            let _ = reply.send(value.map(|value| (value, took)));
            broken
        };
        self.queue(priority).push(priority, Box::new(job));
        result.recv().unwrap_or_else(|_| {
            let why = "it failed in other work, or the worker ends: try again";
            Err(backend::Error::Device(why.to_owned()))
        })
    }
}

#[cfg(test)]
mod tests;
