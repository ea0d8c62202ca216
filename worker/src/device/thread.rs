//! The OS threads of a device: they take jobs off their queues until one breaks the device or it is closed.

use std::{
    panic::{AssertUnwindSafe, catch_unwind},
    sync::{Arc, Mutex, OnceLock, PoisonError},
    time::{Duration, Instant},
};

use bendtwin_core::error::panic_text;
use bendtwin_engine::{Backend, Device as Description, backend::Memory};
use tokio::sync::mpsc;

use super::queue::{Broken, Queue};
use crate::Error;

/// Between two looks at the device's memory; a look may wait for the driver.
const LOOK_EVERY: Duration = Duration::from_secs(1);

/// Gives up about so many bytes of the device's memory; false if there is nothing to give up.
type Spare = Box<dyn Fn(u64) -> bool + Send + Sync>;

/// What an opened backend says of itself.
pub(super) struct Opened {
    pub(super) description: Description,
    /// Its second queue.
    pub(super) urgent: Option<Arc<dyn Backend>>,
}

/// The queues and what their threads share.
pub(super) struct Threads {
    pub(super) main: Queue,
    pub(super) urgent: Queue,
    memory: Mutex<Option<Memory>>,
    spare: OnceLock<Spare>,
    /// Told why the process must restart.
    fatal: mpsc::UnboundedSender<Error>,
}

impl Threads {
    pub(super) fn new(fatal: mpsc::UnboundedSender<Error>) -> Self {
        Self {
            main: Queue::default(),
            urgent: Queue::default(),
            memory: Mutex::default(),
            spare: OnceLock::new(),
            fatal,
        }
    }

    /// Starts the main thread, which opens the backend and so owns what the backend binds to a thread.
    pub(super) fn start<F>(self: &Arc<Self>, open: F) -> Result<Opened, Error>
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
            shared.look(&*backend);
            let opened = Opened { description: backend.device(), urgent: backend.urgent() };
            let _ = sender.send(Ok(opened));
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

    /// Takes no more jobs and drops those that wait, which wakes their callers.
    pub(super) fn close(&self) {
        self.main.close();
        self.urgent.close();
    }

    /// The memory as last seen.
    pub(super) fn memory(&self) -> Option<Memory> {
        *self.memory.lock().unwrap_or_else(PoisonError::into_inner)
    }

    pub(super) fn on_shortage(&self, spare: Spare) {
        // Set once, when the worker starts.
        let _ = self.spare.set(spare);
    }

    pub(super) fn reclaim(&self, bytes: u64) -> bool {
        self.spare.get().is_some_and(|spare| spare(bytes))
    }

    fn work(&self, queue: &Queue, backend: &dyn Backend) {
        let mut looked = Instant::now();
        while let Some(job) = queue.next() {
            let error = match catch_unwind(AssertUnwindSafe(|| job(backend))) {
                Ok(Ok(())) => None,
                Ok(Err(Broken(why))) => Some(Error::DeviceFailed(why)),
                Err(panic) => Some(Error::Panicked(panic_text(&*panic).to_owned())),
            };
            if let Some(error) = error {
                // Both queues: what one thread broke, the other must not use.
                self.close();
                let _ = self.fatal.send(error);
                return;
            }
            if looked.elapsed() >= LOOK_EVERY {
                self.look(backend);
                looked = Instant::now();
            }
        }
    }

    fn look(&self, backend: &dyn Backend) {
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
