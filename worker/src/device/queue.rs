//! The queue in front of a device thread.

use std::{
    sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError},
    time::Duration,
};

use bendtwin_engine::Backend;

use super::turns::{Flow, Turns};

/// Work for a device thread.
pub(super) type Task = Box<dyn FnOnce(&dyn Backend) -> Result<(), BrokenDevice> + Send>;

/// Reason for which a device cannot be used any more.
pub(super) struct BrokenDevice(pub(super) String);

/// Priority of a task.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Priority {
    /// A person or a robot waits for it.
    Interactive,
    /// A fit.
    Background,
}

/// Tasks that wait for their [`Turns`].
pub(super) struct Queue {
    tasks: Mutex<Tasks>,
    arrived: Condvar,
}

struct Tasks {
    turns: Turns<Task>,
    closed: bool,
}

impl Queue {
    /// A queue in which fits have this share of the time.
    pub(super) fn new(fit_share: f64) -> Self {
        let turns = Turns::new(fit_share);
        let tasks = Tasks { turns, closed: false };
        Self { tasks: Mutex::new(tasks), arrived: Condvar::new() }
    }

    /// Adds a task; drops it if the queue is closed.
    pub(super) fn push(&self, flow: &Arc<Flow>, task: Task) {
        let mut tasks = self.lock();
        if tasks.closed {
            return;
        }
        tasks.turns.push(flow, task);
        drop(tasks);
        self.arrived.notify_one();
    }

    /// Waits for the next task; none once the queue is closed.
    pub(super) fn next(&self) -> Option<(Arc<Flow>, Task)> {
        let mut tasks = self.lock();
        loop {
            if tasks.closed {
                return None;
            }
            if let Some(next) = tasks.turns.take() {
                return Some(next);
            }
            tasks = self.arrived.wait(tasks).unwrap_or_else(PoisonError::into_inner);
        }
    }

    /// Notes the time that a task took.
    pub(super) fn served(&self, flow: &Arc<Flow>, took: Duration) {
        self.lock().turns.served(flow, took);
    }

    /// Accepts no more tasks and drops those that wait, which wakes their callers.
    pub(super) fn close(&self) {
        let mut tasks = self.lock();
        tasks.closed = true;
        let waiting = tasks.turns.drain();
        drop(tasks);
        drop(waiting);
        self.arrived.notify_all();
    }

    /// Tasks run outside the lock, so a panic cannot leave it half changed.
    fn lock(&self) -> MutexGuard<'_, Tasks> {
        self.tasks.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
