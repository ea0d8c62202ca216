//! Why and how a fit is stopped: the first reason counts.

use std::sync::{Arc, OnceLock};

use bendtwin_engine::backend::CancelToken;
use tokio_util::sync::CancellationToken;

/// Why a fit is stopped.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Reason {
    /// A user cancelled the job.
    Cancelled,
    /// Another worker has the job.
    Stale,
    /// This worker ends and hands the job back.
    Drained,
}

/// Stops a fit: the engine's work, and whoever waits in a task.
#[derive(Clone, Debug, Default)]
pub(super) struct Stop {
    reason: Arc<OnceLock<Reason>>,
    token: CancelToken,
    signal: CancellationToken,
}

impl Stop {
    pub(super) fn stop(&self, reason: Reason) {
        // A second reason changes nothing: the work is ending already.
        let _ = self.reason.set(reason);
        self.token.cancel();
        self.signal.cancel();
    }

    pub(super) fn reason(&self) -> Option<Reason> {
        self.reason.get().copied()
    }

    /// What the engine checks.
    pub(super) fn token(&self) -> &CancelToken {
        &self.token
    }

    pub(super) async fn stopped(&self) {
        self.signal.cancelled().await;
    }
}
