//! The queue in front of a device thread.

use std::{
    collections::VecDeque,
    sync::{Condvar, Mutex, MutexGuard, PoisonError},
    time::{Duration, Instant},
};

use bendtwin_engine::Backend;

/// Work for a device thread.
pub(super) type Job = Box<dyn FnOnce(&dyn Backend) -> Result<(), Broken> + Send>;

/// Why a device is of no use any more.
pub(super) struct Broken(pub(super) String);

/// A background job that has waited this long goes first once, so that a
/// stream of rollouts slows a fit down but never stops it.
const PATIENCE: Duration = Duration::from_secs(2);

/// Whose work goes first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Priority {
    /// A person or a robot waits for it.
    Interactive,
    /// A fit.
    Background,
}

/// Jobs by priority, first in, first out within each.
#[derive(Default)]
pub(super) struct Queue {
    jobs: Mutex<Jobs>,
    arrived: Condvar,
}

#[derive(Default)]
struct Jobs {
    interactive: VecDeque<Job>,
    background: VecDeque<(Instant, Job)>,
    closed: bool,
}

impl Queue {
    /// Adds a job; drops it if the queue is closed.
    pub(super) fn push(&self, priority: Priority, job: Job) {
        let mut jobs = self.lock();
        if jobs.closed {
            return;
        }
        match priority {
            Priority::Interactive => jobs.interactive.push_back(job),
            Priority::Background => jobs.background.push_back((Instant::now(), job)),
        }
        drop(jobs);
        self.arrived.notify_one();
    }

    /// Waits for the next job; none once the queue is closed.
    pub(super) fn next(&self) -> Option<Job> {
        let mut jobs = self.lock();
        loop {
            if jobs.closed {
                return None;
            }
            if let Some(job) = jobs.take() {
                return Some(job);
            }
            jobs = self.arrived.wait(jobs).unwrap_or_else(PoisonError::into_inner);
        }
    }

    /// Takes no more jobs and drops those that wait, which wakes their callers.
    pub(super) fn close(&self) {
        let mut jobs = self.lock();
        jobs.closed = true;
        let waiting = (std::mem::take(&mut jobs.interactive), std::mem::take(&mut jobs.background));
        drop(jobs);
        drop(waiting);
        self.arrived.notify_all();
    }

    /// Jobs run outside the lock, so a panic cannot leave it half changed.
    fn lock(&self) -> MutexGuard<'_, Jobs> {
        self.jobs.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Jobs {
    fn take(&mut self) -> Option<Job> {
        let starving = self.background.front().is_some_and(|(since, _)| since.elapsed() > PATIENCE);
        if starving || self.interactive.is_empty() {
            return self.background.pop_front().map(|(_, job)| job);
        }
        self.interactive.pop_front()
    }
}
