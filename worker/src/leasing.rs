//! Leases jobs of one kind from the server, one after another.

use std::time::Duration;

use bendtwin_core::Category;
use bendtwin_proto::worker::v1::lease_job_request::Kind;
use tokio_util::sync::CancellationToken;
use tracing::Instrument as _;

use crate::{
    Error,
    job::LeasedJob,
    registration::{Offer, Registration, is_unknown},
    server_client::{Backoff, CallError},
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
    /// True if brief jobs alone are leased, which heartbeats do not name.
    const BRIEF: bool = false;
    /// Longest time for which the server may hold a call for a job.
    const WAIT: Duration = LEASE_WAIT;

    /// Waits until a job may be leased.
    fn until_open(&self) -> impl Future<Output = ()> + Send {
        std::future::ready(())
    }

    /// Works on a job until it has ended, here or elsewhere. `drain` asks to hand it back.
    fn execute(&self, job: LeasedJob, drain: &CancellationToken)
    -> impl Future<Output = ()> + Send;
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
        let lease = async {
            executor.until_open().await;
            registration.lease_job(E::KIND, E::WAIT, E::BRIEF).await
        };
        let leased = tokio::select! {
            leased = lease => leased,
            () = stop.closed.cancelled() => return Ok(()),
        };
        match leased {
            Ok(Offer::Drain) => stop.end_as_asked(),
            Ok(Offer::Nothing) => backoff = Backoff::default(),
            Ok(Offer::Job(job)) => {
                backoff = Backoff::default();
                let _at_work = (!E::BRIEF).then(|| registration.at_work(E::KIND, &job));
                let span = job.span(E::KIND);
                executor.execute(job, &stop.drained).instrument(span).await;
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
