//! Durable checkpoints that do not delay the work. The latest one wins; one is saved every few
//! seconds, and always at the end of a stage.

use std::{
    sync::{Arc, Mutex, PoisonError},
    time::Duration,
};

use bytes::Bytes;
use tokio::{sync::Notify, task::JoinHandle, time::Instant};
use tracing::Instrument as _;

use super::{
    LeasedJob,
    stop::{Reason, Stop},
};
use crate::server_client::{Backoff, CallError};

/// Largest checkpoint that is accepted [bytes].
pub(crate) const MAX_BYTES: u64 = 1 << 30;
/// Least time between two checkpoints inside a stage.
const CHECKPOINT_INTERVAL: Duration = Duration::from_secs(2);
/// Longest time for the last checkpoint when a worker ends.
const FLUSH_TIMEOUT: Duration = Duration::from_secs(10);

/// The work's end of the slot, where it leaves checkpoints.
#[derive(Clone)]
pub(crate) struct Checkpoints(Arc<Slot>);

struct Slot {
    waiting: Mutex<Option<PendingCheckpoint>>,
    /// Taken from `waiting` and not acknowledged yet.
    sending: Mutex<Option<Bytes>>,
    changed: Notify,
}

struct PendingCheckpoint {
    content: Bytes,
    /// Must not be delayed: a stage ends, or the worker does.
    urgent: bool,
}

/// The saving task.
pub(super) struct Saver {
    slot: Arc<Slot>,
    job: LeasedJob,
    task: JoinHandle<()>,
}

impl Checkpoints {
    /// Leaves a checkpoint to be saved in place of any that still waits.
    pub(crate) fn submit(&self, content: Vec<u8>, stage_ended: bool) {
        self.0.put(PendingCheckpoint { content: content.into(), urgent: stage_ended });
    }
}

impl Slot {
    fn put(&self, new: PendingCheckpoint) {
        let mut waiting = self.waiting.lock().unwrap_or_else(PoisonError::into_inner);
        let urgent = new.urgent || waiting.as_ref().is_some_and(|w| w.urgent);
        *waiting = Some(PendingCheckpoint { urgent, ..new });
        drop(waiting);
        self.changed.notify_one();
    }

    fn is_urgent(&self) -> bool {
        let waiting = self.waiting.lock().unwrap_or_else(PoisonError::into_inner);
        waiting.as_ref().is_some_and(|w| w.urgent)
    }

    /// The newest checkpoint that is not saved yet; it stays with the slot until it is.
    fn take(&self) -> Option<Bytes> {
        let waiting = self.waiting.lock().unwrap_or_else(PoisonError::into_inner).take();
        let mut sending = self.sending.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(waiting) = waiting {
            *sending = Some(waiting.content);
        }
        sending.clone()
    }

    /// Marks the content that was taken as saved.
    fn acknowledge(&self) {
        *self.sending.lock().unwrap_or_else(PoisonError::into_inner) = None;
    }
}

/// Starts the saving task, whose lines in the log name the job.
pub(super) fn start(job: LeasedJob, stop: Stop) -> (Checkpoints, Saver) {
    let slot = Arc::new(Slot {
        waiting: Mutex::default(),
        sending: Mutex::default(),
        changed: Notify::new(),
    });
    let task = tokio::spawn(run(Arc::clone(&slot), job.clone(), stop).in_current_span());
    (Checkpoints(Arc::clone(&slot)), Saver { slot, job, task })
}

impl Saver {
    /// Drops the checkpoint that waits: it is not needed any more.
    pub(super) fn abort(&self) {
        self.task.abort();
    }

    /// Saves the checkpoint that waits, so that the next worker loses nothing, unless that takes
    /// too long.
    pub(super) async fn flush(self) {
        self.task.abort();
        // What it was sending is sent again at worst.
        let _ = self.task.await;
        if let Some(content) = self.slot.take() {
            let saved =
                tokio::time::timeout(FLUSH_TIMEOUT, self.job.save_checkpoint(content)).await;
            if !matches!(saved, Ok(Ok(()))) {
                tracing::warn!("the last checkpoint was not saved: the one before it counts");
            }
        }
    }
}

async fn run(slot: Arc<Slot>, job: LeasedJob, stop: Stop) {
    let mut next = Instant::now();
    loop {
        slot.changed.notified().await;
        while !slot.is_urgent() && Instant::now() < next {
            tokio::select! {
                () = tokio::time::sleep_until(next) => {}
                () = slot.changed.notified() => {}
            }
        }
        let mut backoff = Backoff::default();
        // Taken again for each attempt: a newer one may have arrived in the meantime.
        while let Some(content) = slot.take() {
            let bytes = content.len();
            match job.save_checkpoint(content).await {
                Ok(()) => tracing::debug!(bytes, "checkpoint saved"),
                Err(CallError::Stale) => return stop.stop(Reason::Stale),
                Err(CallError::Refused(fault)) => {
                    tracing::warn!(reason = fault.reason, "checkpoint refused: {fault}");
                }
                Err(CallError::Unavailable(fault)) => {
                    tracing::debug!("cannot save a checkpoint yet: {fault}");
                    backoff.wait().await;
                    continue;
                }
            }
            slot.acknowledge();
        }
        next = Instant::now() + CHECKPOINT_INTERVAL;
    }
}
