//! Leases jobs of one kind from the server, one after another.

use std::time::Duration;

use bendtwin_core::Category;
use bendtwin_proto::worker::v1::{Lease, lease_job_request::Kind};
use tokio_util::sync::CancellationToken;

use crate::{
    Error,
    registration::{Registration, is_unknown},
    server_client::{Backoff, CallError, ServerClient},
};

/// Longest time for which the server may hold a call for a job.
const LEASE_WAIT: Duration = Duration::from_secs(20);

/// Signals to stop leasing.
#[derive(Clone, Debug)]
pub(crate) struct StopSignals {
    /// No further job is leased.
    pub(crate) closed: CancellationToken,
    /// The job under way is handed back, too.
    pub(crate) drained: CancellationToken,
    /// A server asked for it.
    pub(crate) asked: CancellationToken,
}

impl StopSignals {
    /// Ends the worker, since a server asks for it.
    pub(crate) fn end_as_asked(&self) {
        if !self.asked.is_cancelled() {
            tracing::info!("the server asks this worker to end");
        }
        self.asked.cancel();
        self.drained.cancel();
    }

    /// True if a server asked for it.
    pub(crate) fn is_asked(&self) -> bool {
        self.asked.is_cancelled()
    }
}

/// Executor of jobs of one kind.
pub(crate) trait Execute: Send + Sync {
    /// The kind of jobs.
    const KIND: Kind;

    fn server(&self) -> &ServerClient;

    /// workers/{uuid}
    fn worker(&self) -> &str;

    /// Works on a job until it has ended, here or elsewhere. `drain` asks to hand it back.
    fn execute(&self, lease: Lease, drain: &CancellationToken) -> impl Future<Output = ()> + Send;
}

/// Leases and executes jobs.
///
/// # Errors
/// If the server refuses this worker permanently.
pub(crate) async fn lease<E: Execute>(
    executor: &E,
    registration: &Registration,
    stop: &StopSignals,
) -> Result<(), Error> {
    let mut backoff = Backoff::default();
    while !stop.closed.is_cancelled() {
        let leased = tokio::select! {
            leased = executor.server().lease_job(E::KIND, executor.worker().to_owned(), LEASE_WAIT) => leased,
            () = stop.closed.cancelled() => return Ok(()),
        };
        match leased {
            Ok(answer) if answer.drain => {
                stop.end_as_asked();
            }
            Ok(answer) => {
                backoff = Backoff::default();
                if let Some(lease) = answer.lease {
                    let _at_work = registration.at_work(E::KIND, &lease);
                    executor.execute(lease, &stop.drained).await;
                }
            }
            Err(CallError::Refused(fault))
                if matches!(
                    fault.category,
                    Category::Unauthenticated | Category::PermissionDenied
                ) =>
            {
                return Err(Error::Refused(fault.message));
            }
            Err(error) => {
                if is_unknown(&error) {
                    registration.register_again().await;
                } else {
                    tracing::debug!("no job: {}", error.fault());
                }
                tokio::select! {
                    () = backoff.wait() => {}
                    () = stop.closed.cancelled() => return Ok(()),
                }
            }
        }
    }
    Ok(())
}
