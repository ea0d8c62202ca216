//! The OS threads of a device: they take tasks off their queues until one breaks the device or it
//! is closed.

use std::{
    panic::{AssertUnwindSafe, catch_unwind},
    sync::{Arc, Mutex, OnceLock, PoisonError},
    time::{Duration, Instant},
};

use bendtwin_core::error::panic_text;
use bendtwin_engine::{Backend, Device as Description, backend::Memory};
use tokio::sync::mpsc;

use super::queue::{BrokenDevice, Queue};
use crate::{Error, priority};

/// Time between two samples of the device's memory; a sample may wait for the driver.
const MEMORY_SAMPLE_INTERVAL: Duration = Duration::from_secs(1);

/// Frees about the given number of bytes of the device's memory; false if there is nothing to free.
type Reclaim = Box<dyn Fn(u64) -> bool + Send + Sync>;

/// Properties of an opened backend.
pub(super) struct BackendInfo {
    pub(super) description: Description,
    /// The second queue of the backend.
    pub(super) urgent: Option<Arc<dyn Backend>>,
}

/// The queues, and the state that their threads share.
pub(super) struct Threads {
    pub(super) main: Queue,
    pub(super) urgent: Queue,
    memory: Mutex<Option<Memory>>,
    reclaim: OnceLock<Reclaim>,
    /// Channel for errors after which the process must restart.
    fatal: mpsc::UnboundedSender<Error>,
}

impl Threads {
    pub(super) fn new(fatal: mpsc::UnboundedSender<Error>, fit_share: f64) -> Self {
        Self {
            main: Queue::new(fit_share),
            urgent: Queue::new(fit_share),
            memory: Mutex::default(),
            reclaim: OnceLock::new(),
            fatal,
        }
    }

    /// Starts the main thread, which opens the backend and so owns what the backend binds to a
    /// thread.
    pub(super) fn start<F>(self: &Arc<Self>, open: F) -> Result<BackendInfo, Error>
    where
        F: FnOnce() -> Result<Arc<dyn Backend>, Error> + Send + 'static,
    {
        let (sender, opened) = std::sync::mpsc::sync_channel(1);
        let shared = Arc::clone(self);
        spawn("device", move || {
            let backend = match open() {
                Ok(backend) => backend,
                Err(e) => return drop(sender.send(Err(e))),
            };
            shared.sample_memory(&*backend);
            let opened = BackendInfo { description: backend.device(), urgent: backend.urgent() };
            let is_for_fits = opened.urgent.is_some();
            let _ = sender.send(Ok(opened));
            if is_for_fits {
                priority::as_fit();
            }
            shared.work(&shared.main, &*backend);
        })?;
        opened.recv().map_err(|_| {
            Error::DeviceFailed("its thread ended while the backend was opened".to_owned())
        })?
    }

    /// Starts the thread of the second queue.
    pub(super) fn start_urgent(self: &Arc<Self>, backend: Arc<dyn Backend>) -> Result<(), Error> {
        let shared = Arc::clone(self);
        let started = spawn("device urgent", move || shared.work(&shared.urgent, &*backend));
        if started.is_err() {
            self.close();
        }
        started
    }

    /// Accepts no more tasks and drops those that wait, which wakes their callers.
    pub(super) fn close(&self) {
        self.main.close();
        self.urgent.close();
    }

    /// The memory as last sampled.
    pub(super) fn memory(&self) -> Option<Memory> {
        *self.memory.lock().unwrap_or_else(PoisonError::into_inner)
    }

    pub(super) fn on_shortage(&self, reclaim: Reclaim) {
        // Set once, when the worker starts.
        let _ = self.reclaim.set(reclaim);
    }

    pub(super) fn reclaim(&self, bytes: u64) -> bool {
        self.reclaim.get().is_some_and(|reclaim| reclaim(bytes))
    }

    fn work(&self, queue: &Queue, backend: &dyn Backend) {
        let mut sampled = Instant::now();
        while let Some((flow, task)) = queue.next() {
            let started = Instant::now();
            let error = match catch_unwind(AssertUnwindSafe(|| task(backend))) {
                Ok(Ok(())) => None,
                Ok(Err(BrokenDevice(why))) => Some(Error::DeviceFailed(why)),
                Err(panic) => Some(Error::Panicked(panic_text(&*panic).to_owned())),
            };
            if let Some(error) = error {
                // Both queues: a device that one thread broke must not be used by the other.
                self.close();
                let _ = self.fatal.send(error);
                return;
            }
            let took = started.elapsed();
            queue.served(&flow, took);
            if sampled.elapsed() >= MEMORY_SAMPLE_INTERVAL {
                self.sample_memory(backend);
                sampled = Instant::now();
            }
        }
    }

    fn sample_memory(&self, backend: &dyn Backend) {
        self.set_memory(backend.memory());
    }

    pub(super) fn set_memory(&self, memory: Option<Memory>) {
        *self.memory.lock().unwrap_or_else(PoisonError::into_inner) = memory;
    }
}

fn spawn(name: &str, work: impl FnOnce() + Send + 'static) -> Result<(), Error> {
    let thread = std::thread::Builder::new().name(name.to_owned());
    let spawned = thread.spawn(work);
    spawned.map(drop).map_err(|source| Error::System { what: "start a device thread", source })
}
