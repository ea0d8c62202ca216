//! The queue in front of a device thread.

use std::{
    collections::VecDeque,
    sync::{Condvar, Mutex, MutexGuard, PoisonError},
    time::{Duration, Instant},
};

use bendtwin_engine::Backend;

/// Work for a device thread.
pub(super) type Task = Box<dyn FnOnce(&dyn Backend) -> Result<(), Broken> + Send>;

/// Reason for which a device cannot be used any more.
pub(super) struct Broken(pub(super) String);

/// A background task that has waited this long goes first once, so that a
/// stream of rollouts slows a fit down but never stops it.
const STARVATION_LIMIT: Duration = Duration::from_secs(2);

/// Priority of a task.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Priority {
    /// A person or a robot waits for it.
    Interactive,
    /// A fit.
    Background,
}

/// Tasks by priority, first in, first out within each.
#[derive(Default)]
pub(super) struct Queue {
    tasks: Mutex<Tasks>,
    arrived: Condvar,
}

#[derive(Default)]
struct Tasks {
    interactive: VecDeque<Task>,
    background: VecDeque<(Instant, Task)>,
    closed: bool,
}

impl Queue {
    /// Adds a task; drops it if the queue is closed.
    pub(super) fn push(&self, priority: Priority, task: Task) {
        let mut tasks = self.lock();
        if tasks.closed {
            return;
        }
        match priority {
            Priority::Interactive => tasks.interactive.push_back(task),
            Priority::Background => tasks.background.push_back((Instant::now(), task)),
        }
        drop(tasks);
        self.arrived.notify_one();
    }

    /// Waits for the next task; none once the queue is closed.
    pub(super) fn next(&self) -> Option<Task> {
        let mut tasks = self.lock();
        loop {
            if tasks.closed {
                return None;
            }
            if let Some(task) = tasks.take() {
                return Some(task);
            }
            tasks = self.arrived.wait(tasks).unwrap_or_else(PoisonError::into_inner);
        }
    }

    /// Accepts no more tasks and drops those that wait, which wakes their callers.
    pub(super) fn close(&self) {
        let mut tasks = self.lock();
        tasks.closed = true;
        let waiting =
            (std::mem::take(&mut tasks.interactive), std::mem::take(&mut tasks.background));
        drop(tasks);
        drop(waiting);
        self.arrived.notify_all();
    }

    /// Tasks run outside the lock, so a panic cannot leave it half changed.
    fn lock(&self) -> MutexGuard<'_, Tasks> {
        self.tasks.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Tasks {
    fn take(&mut self) -> Option<Task> {
        let starving =
            self.background.front().is_some_and(|(since, _)| since.elapsed() > STARVATION_LIMIT);
        if starving || self.interactive.is_empty() {
            return self.background.pop_front().map(|(_, task)| task);
        }
        self.interactive.pop_front()
    }
}
