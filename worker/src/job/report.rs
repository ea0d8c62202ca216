//! Renews a job's lease, reports progress and learns of cancellation, in a task of its own and
//! often enough that a cancelled job ends within a second.

use std::{
    sync::{Arc, Mutex, PoisonError},
    time::Duration,
};

use bendtwin_core::Progress;
use tokio::{task::JoinHandle, time::MissedTickBehavior};

use super::{
    Job,
    stop::{Reason, Stop},
};
use crate::server_client::CallError;

/// Time between two reports. A lease lasts tens of seconds, so many may be missed.
const REPORT_INTERVAL: Duration = Duration::from_millis(500);

/// The latest progress, set by the work and read by the reporting task.
#[derive(Clone, Default)]
pub(crate) struct LatestProgress(Arc<Mutex<Option<Progress>>>);

impl LatestProgress {
    pub(crate) fn set(&self, progress: Progress) {
        *self.0.lock().unwrap_or_else(PoisonError::into_inner) = Some(progress);
    }

    fn get(&self) -> Option<Progress> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }
}

/// Starts reporting, which goes on until the task is aborted.
pub(crate) fn start(job: Job, stop: Stop) -> (LatestProgress, JoinHandle<()>) {
    let latest = LatestProgress::default();
    let task = tokio::spawn(run(job, stop, latest.clone()));
    (latest, task)
}

async fn run(job: Job, stop: Stop, latest: LatestProgress) {
    let mut ticks = tokio::time::interval(REPORT_INTERVAL);
    ticks.set_missed_tick_behavior(MissedTickBehavior::Delay);
    let mut reachable = true;
    loop {
        ticks.tick().await;
        match job.report(latest.get().as_ref()).await {
            Ok(cancel_requested) => {
                reachable = true;
                if cancel_requested {
                    stop.stop(Reason::Cancelled);
                }
            }
            Err(CallError::Stale) => return stop.stop(Reason::Stale),
            // Deleted, or never known to this server: the result is not needed.
            Err(CallError::Refused(fault)) => {
                tracing::warn!(reason = fault.reason, "the server refuses this job: {fault}");
                return stop.stop(Reason::Stale);
            }
            Err(CallError::Unavailable(fault)) => {
                if std::mem::replace(&mut reachable, false) {
                    tracing::warn!("cannot report ({fault}); the work continues");
                }
            }
        }
    }
}
