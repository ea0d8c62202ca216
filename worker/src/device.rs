//! The compute device: one OS thread that owns the backend, behind a queue
//! with two priorities. Callers see a [`Backend`] again, a [`Lane`], which cuts
//! their batches into slices; between two slices of a fit a rollout gets its turn.

mod lane;
mod queue;

use std::{
    panic::{AssertUnwindSafe, catch_unwind},
    sync::Arc,
    time::{Duration, Instant},
};

use bendtwin_engine::{Backend, Device as Description, backend};
use tokio::sync::mpsc;

pub(crate) use self::lane::Lane;
pub(crate) use self::queue::Priority;
use self::queue::Queue;
use crate::Error;

/// How long one slice should take: what a rollout waits for at most, unless a
/// single instance takes longer.
const SLICE: Duration = Duration::from_millis(100);

/// A handle on the device thread; clones share it. The thread ends on [`Device::close`].
#[derive(Clone)]
pub(crate) struct Device {
    queue: Arc<Queue>,
    description: Description,
}

impl Device {
    /// Starts the thread and opens the backend on it.
    ///
    /// A panic in a job is caught: its caller gets an error, the device takes
    /// no more work, and `fatal` is told, for the state of a device is unknown then.
    pub(crate) fn spawn<F>(open: F, fatal: mpsc::UnboundedSender<Error>) -> Result<Self, Error>
    where
        F: FnOnce() -> Result<Arc<dyn Backend>, backend::Error> + Send + 'static,
    {
        let queue = Arc::new(Queue::default());
        let (opened, description) = std::sync::mpsc::sync_channel(1);
        let jobs = Arc::clone(&queue);
        std::thread::Builder::new()
            .name("device".to_owned())
            .spawn(move || {
                let backend = match open() {
                    Ok(backend) => backend,
                    Err(e) => return drop(opened.send(Err(e))),
                };
                let _ = opened.send(Ok(backend.device()));
                while let Some(job) = jobs.next() {
                    if let Err(panic) = catch_unwind(AssertUnwindSafe(|| job(&*backend))) {
                        jobs.close();
                        let _ = fatal.send(Error::Panicked(panic_text(&*panic)));
                        return;
                    }
                }
            })
            .map_err(|source| Error::System { what: "start the device thread", source })?;
        let description = description.recv().map_err(|_| {
            backend::Error::Device("the device thread ended while the backend was opened".into())
        })??;
        Ok(Self { queue, description })
    }

    /// What the backend runs on.
    pub(crate) fn description(&self) -> &Description {
        &self.description
    }

    /// A backend whose calls run on the device thread with this priority.
    pub(crate) fn lane(&self, priority: Priority) -> Lane {
        Lane::new(self.clone(), priority)
    }

    /// Ends the thread once its current job is done; waiting and later callers get an error.
    pub(crate) fn close(&self) {
        self.queue.close();
    }

    /// Runs a job on the thread and waits for it. Also says how long it ran.
    fn call<R: Send + 'static>(
        &self,
        priority: Priority,
        job: impl FnOnce(&dyn Backend) -> R + Send + 'static,
    ) -> Result<(R, Duration), backend::Error> {
        let (reply, result) = std::sync::mpsc::sync_channel(1);
        self.queue.push(
            priority,
            Box::new(move |backend| {
                let started = Instant::now();
                let value = job(backend);
                // The caller waits below, so sending cannot fail while it lives.
                let _ = reply.send((value, started.elapsed()));
            }),
        );
        result.recv().map_err(|_| backend::Error::Device("the device thread has ended".to_owned()))
    }
}

/// What a panic said.
pub(crate) fn panic_text(panic: &(dyn std::any::Any + Send)) -> String {
    let text = panic.downcast_ref::<&str>().copied();
    text.or_else(|| panic.downcast_ref::<String>().map(String::as_str))
        .unwrap_or("no message")
        .to_owned()
}

#[cfg(test)]
mod tests;
