//! Delivery of a job's result or failure, repeated until the server has acknowledged it.

use std::time::Duration;

use bendtwin_core::{Category, Fault};
use tokio::time::Instant;

use super::{Attempt, stop::Reason};
use crate::server_client::{Backoff, CallError};

/// Time for which a worker that has to end still tries.
const DRAIN_TIMEOUT: Duration = Duration::from_secs(10);
/// Time for which an attempt that lacked disk or memory keeps its job: three immediate attempts
/// would find the same shortage three times.
const SHORTAGE_PAUSE: Duration = Duration::from_secs(20);

/// Kind of a job's end without a result.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Failure {
    /// A fault of the input: every attempt would fail.
    Permanent,
    /// Another attempt may succeed.
    Passing,
    /// A user cancelled it.
    Cancelled,
    /// Handed back in good order.
    Released,
    /// Leased as brief, but takes longer.
    Outgrown,
    /// Other work of this worker, which has to end, broke what the job needs.
    Interrupted,
}

/// Reason for which a result was not delivered.
pub(crate) enum Undelivered {
    /// The server does not accept it.
    Refused(Fault),
    /// Another worker has the job, or the server could not be reached for too long.
    GivenUp,
}

impl Attempt<'_> {
    /// Reports that this attempt has no result.
    pub(crate) async fn fail(&self, fault: Fault, kind: Failure) {
        let _ = self.send_until_acknowledged("the failure", || self.job.fail(&fault, kind)).await;
    }

    /// Ends an attempt of `work` without a result. The kind of failure follows from the reason to
    /// stop, else from the category of the fault. The last checkpoint is saved first, unless the job
    /// was cancelled.
    pub(crate) async fn fail_unfinished(&mut self, work: &str, fault: Fault) {
        let kind = match self.stop.reason() {
            Some(Reason::Cancelled) => {
                self.drop_checkpoint();
                tracing::info!("{work} cancelled");
                return self.fail(fault, Failure::Cancelled).await;
            }
            Some(Reason::Drained) => {
                tracing::info!("{work} handed back");
                Failure::Released
            }
            Some(Reason::MakesWay) => {
                tracing::info!("{work} makes way for that of another owner");
                Failure::Released
            }
            Some(Reason::Stale) | None => {
                tracing::warn!(reason = fault.reason, "{work} failed: {fault}");
                let permanent = fault.category == Category::InvalidArgument;
                if permanent { Failure::Permanent } else { Failure::Passing }
            }
        };
        self.save_last_checkpoint().await;
        if kind == Failure::Passing && fault.category == Category::ResourceExhausted {
            tokio::select! {
                () = tokio::time::sleep(SHORTAGE_PAUSE) => {}
                () = self.drain.cancelled() => {}
            }
        }
        self.fail(fault, kind).await;
    }

    /// Hands back a job that was leased as brief and takes longer, with its last checkpoint.
    pub(crate) async fn hand_on(&mut self, fault: Fault) {
        tracing::info!("it takes longer than a brief job may: handed back");
        self.save_last_checkpoint().await;
        self.fail(fault, Failure::Outgrown).await;
    }

    /// Sends until the server has acknowledged. Sending twice must do no harm.
    pub(crate) async fn send_until_acknowledged<T, F>(
        &self,
        what: &str,
        send: impl Fn() -> F,
    ) -> Result<T, Undelivered>
    where
        F: Future<Output = Result<T, CallError>>,
    {
        let started = Instant::now();
        let mut drain_since: Option<Instant> = None;
        let mut backoff = Backoff::default();
        loop {
            match send().await {
                Ok(answer) => return Ok(answer),
                Err(CallError::Stale) => {
                    tracing::warn!("the lease is stale: {what} is dropped");
                    return Err(Undelivered::GivenUp);
                }
                Err(CallError::Refused(fault)) => {
                    tracing::error!(reason = fault.reason, "the server refuses {what}: {fault}");
                    return Err(Undelivered::Refused(fault));
                }
                Err(CallError::Unavailable(fault)) => {
                    tracing::warn!("cannot deliver {what} yet: {fault}");
                }
            }
            if self.drain.is_cancelled() {
                drain_since.get_or_insert_with(Instant::now);
            }
            let given_up = drain_since.is_some_and(|since| since.elapsed() > DRAIN_TIMEOUT)
                || started.elapsed() > self.delivery_timeout;
            if given_up {
                tracing::error!("gave up delivering {what}: the job is done again elsewhere");
                return Err(Undelivered::GivenUp);
            }
            backoff.wait().await;
        }
    }
}
