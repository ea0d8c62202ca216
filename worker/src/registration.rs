//! Registration of the worker with the server, kept up by heartbeats.

use std::{
    sync::{
        Arc,
        atomic::{AtomicU64, Ordering},
    },
    time::Duration,
};

use bendtwin_core::Category;
use bendtwin_proto::worker::v1::{LeaseJobResponse, RegisterRequest, lease_job_request::Kind};
use tokio::time::Instant;

use crate::{
    Error,
    job::LeasedJob,
    leasing::StopSignals,
    rollout::{Rollouts, StatusGuard},
    server_client::{Backoff, CallError, ServerClient},
};

/// This worker's entry in the server's list.
#[derive(Clone)]
pub(crate) struct Registration {
    server: ServerClient,
    request: Arc<RegisterRequest>,
    rollouts: Rollouts,
    /// Interval that the server asked for [ms].
    heartbeat_interval_ms: Arc<AtomicU64>,
}

/// Answer of a server to a worker that asks for a job.
pub(crate) enum Offer {
    /// A job, which is leased to the worker.
    Job(LeasedJob),
    /// No job within the wait.
    Nothing,
    /// The worker is to end.
    Drain,
}

impl Registration {
    pub(crate) fn new(server: ServerClient, request: RegisterRequest, rollouts: Rollouts) -> Self {
        let heartbeat_interval_ms = Arc::new(AtomicU64::new(5_000));
        let request = Arc::new(request);
        Self { server, request, rollouts, heartbeat_interval_ms }
    }

    /// Registers, trying again while the server cannot be reached.
    pub(crate) async fn register(&self, timeout: Duration) -> Result<(), Error> {
        let started = Instant::now();
        let mut backoff = Backoff::default();
        loop {
            match self.server.register((*self.request).clone()).await {
                Ok(answer) => {
                    let limits = answer.rollout_limits.as_ref();
                    self.rollouts.set_limits(limits.map(Into::into).unwrap_or_default());
                    // An absurd answer must not make this worker spin or fall silent.
                    let every = answer.heartbeat_interval_s;
                    let every = if every.is_finite() { every.clamp(0.05, 60.0) } else { 5.0 };
                    self.heartbeat_interval_ms.store((every * 1000.0) as u64, Ordering::Relaxed);
                    return Ok(());
                }
                Err(CallError::Unavailable(fault)) if started.elapsed() < timeout => {
                    tracing::info!("waiting for the server: {fault}");
                    backoff.wait().await;
                }
                Err(error) => return Err(Error::Refused(error.fault().message)),
            }
        }
    }

    /// Sends heartbeats until the task is aborted, and passes on that a server asks the worker to
    /// end.
    pub(crate) async fn heartbeat(self, stop: StopSignals) {
        loop {
            let every = Duration::from_millis(self.heartbeat_interval_ms.load(Ordering::Relaxed));
            tokio::time::sleep(every).await;
            let heartbeat = self.rollouts.heartbeat();
            match self.server.heartbeat(heartbeat).await {
                Ok(answer) if answer.drain => {
                    stop.end_as_asked();
                }
                Ok(_) => {}
                Err(error) if is_unknown(&error) => self.register_again().await,
                Err(error) => tracing::warn!("no answer to a heartbeat: {}", error.fault()),
            }
        }
    }

    /// Waits for a job of a kind, or for a brief one.
    pub(crate) async fn lease_job(
        &self,
        kind: Kind,
        wait: Duration,
        brief: bool,
    ) -> Result<Offer, CallError> {
        let worker = &self.request.worker;
        let LeaseJobResponse { lease, drain } =
            self.server.lease_job(kind, worker.clone(), wait, brief).await?;
        Ok(match lease {
            _ if drain => Offer::Drain,
            Some(lease) => Offer::Job(LeasedJob::new(self.server.clone(), worker, lease)),
            None => Offer::Nothing,
        })
    }

    /// Reports a job to servers, until it ends.
    pub(crate) fn at_work(&self, kind: Kind, job: &LeasedJob) -> StatusGuard {
        self.rollouts.at_work(kind, job)
    }

    /// Registers after the server has forgotten the worker, for example because it was away for
    /// long.
    pub(crate) async fn register_again(&self) {
        tracing::info!("the server does not know this worker: registering again");
        if let Err(error) = self.register(Duration::ZERO).await {
            tracing::warn!("{error}");
        }
    }
}

/// True if the server answered that it does not know this worker.
pub(crate) fn is_unknown(error: &CallError) -> bool {
    matches!(error, CallError::Refused(fault)
        if matches!(fault.category, Category::NotFound | Category::FailedPrecondition))
}
