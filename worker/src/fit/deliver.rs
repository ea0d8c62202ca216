//! The last word on a job, repeated until the server has acknowledged it.

use std::time::Duration;

use bendtwin_core::Fault;
use tokio::time::Instant;
use tokio_util::sync::CancellationToken;

use super::{compute::Finished, job::Job};
use crate::link::{Backoff, LinkError};

/// How long a worker that is told to end still tries.
const DRAIN_PATIENCE: Duration = Duration::from_secs(10);

/// What kind of end a job came to, if not a twin.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Failure {
    /// The input's fault: another attempt would fail alike.
    Permanent,
    /// Another attempt may succeed.
    Passing,
    /// A user cancelled it.
    Cancelled,
    /// This worker ends and hands it back.
    Released,
}

/// Sends the last word.
pub(super) struct Delivery<'a> {
    pub(super) job: &'a Job,
    pub(super) drain: &'a CancellationToken,
    pub(super) patience: Duration,
}

impl Delivery<'_> {
    /// Stores the twin, which ends the job. Sending it twice is safe: the second answer is the
    /// same, or says that the lease is stale.
    pub(super) async fn complete(&self, finished: Finished) {
        let sent = self.repeat("the twin", || self.job.complete(&finished)).await;
        if let Some(twin) = sent {
            tracing::info!(twin, bytes = finished.file.len(), "fit succeeded");
        }
    }

    /// Says that there will be no twin from this attempt.
    pub(super) async fn fail(&self, fault: Fault, kind: Failure) {
        self.repeat("the failure", || self.job.fail(&fault, kind)).await;
    }

    async fn repeat<T, F>(&self, what: &str, send: impl Fn() -> F) -> Option<T>
    where
        F: Future<Output = Result<T, LinkError>>,
    {
        let started = Instant::now();
        let mut drain_since: Option<Instant> = None;
        let mut backoff = Backoff::default();
        loop {
            match send().await {
                Ok(answer) => return Some(answer),
                Err(LinkError::Stale) => {
                    tracing::warn!("the lease is stale: {what} is dropped");
                    return None;
                }
                Err(LinkError::Refused(fault)) => {
                    tracing::error!(reason = fault.reason, "the server refuses {what}: {fault}");
                    return None;
                }
                Err(LinkError::Unavailable(fault)) => {
                    tracing::warn!("cannot deliver {what} yet: {fault}");
                }
            }
            if self.drain.is_cancelled() {
                drain_since.get_or_insert_with(Instant::now);
            }
            let given_up = drain_since.is_some_and(|since| since.elapsed() > DRAIN_PATIENCE)
                || started.elapsed() > self.patience;
            if given_up {
                tracing::error!("gave up delivering {what}: the job is done again elsewhere");
                return None;
            }
            backoff.wait().await;
        }
    }
}
