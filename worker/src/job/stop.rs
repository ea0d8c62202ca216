//! Stopping a job: the first reason counts.

use std::sync::{
    Arc, OnceLock,
    atomic::{AtomicBool, Ordering},
};

use bendtwin_core::CancelToken;
use tokio::task::JoinHandle;
use tokio_util::sync::CancellationToken;

/// Reason for which a job is stopped.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Reason {
    /// A user cancelled the job.
    Cancelled,
    /// The server has ended the attempt, or another worker has the job.
    Stale,
    /// This worker ends and hands the job back.
    Drained,
    /// A job of another owner waits for this worker.
    MakesWay,
}

/// Stop signal of a job, both for the engine's computation and for waiting tasks.
#[derive(Clone, Debug, Default)]
pub(crate) struct Stop {
    reason: Arc<OnceLock<Reason>>,
    token: CancelToken,
    signal: CancellationToken,
    makes_way: Arc<AtomicBool>,
}

impl Stop {
    pub(crate) fn stop(&self, reason: Reason) {
        // A second reason changes nothing: the work is ending already.
        let _ = self.reason.set(reason);
        self.token.cancel();
        self.signal.cancel();
    }

    /// Lets the job make way for another at its next checkpoint, or no longer.
    pub(crate) fn make_way(&self, asked: bool) {
        self.makes_way.store(asked, Ordering::Relaxed);
    }

    /// Stops the job if it is to make way: nothing that it has done so far is lost.
    pub(crate) fn at_checkpoint(&self) {
        if self.makes_way.load(Ordering::Relaxed) {
            self.stop(Reason::MakesWay);
        }
    }

    /// Stops the job when the worker hands its jobs back. The task waits until it is aborted.
    pub(crate) fn on_drain(&self, drain: &CancellationToken) -> JoinHandle<()> {
        let (drain, stop) = (drain.clone(), self.clone());
        tokio::spawn(async move {
            drain.cancelled().await;
            stop.stop(Reason::Drained);
        })
    }

    pub(crate) fn reason(&self) -> Option<Reason> {
        self.reason.get().copied()
    }

    /// The token that the engine checks.
    pub(crate) fn token(&self) -> &CancelToken {
        &self.token
    }

    pub(crate) async fn stopped(&self) {
        self.signal.cancelled().await;
    }
}
