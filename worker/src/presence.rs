//! Makes the worker known to the server, and keeps it so.

use std::{
    sync::{
        Arc,
        atomic::{AtomicU64, Ordering},
    },
    time::Duration,
};

use bendtwin_core::Category;
use bendtwin_proto::worker::v1::{BeatRequest, RegisterRequest};
use tokio::time::Instant;
use tokio_util::sync::CancellationToken;

use crate::{
    Error,
    device::Device,
    link::{Backoff, Link, LinkError},
    rollout::Rollouts,
};

/// The worker's entry in the server's list.
#[derive(Clone)]
pub(crate) struct Presence {
    link: Link,
    registration: Arc<RegisterRequest>,
    rollouts: Rollouts,
    device: Device,
    /// As the server asked for [ms].
    beat_every_ms: Arc<AtomicU64>,
}

impl Presence {
    pub(crate) fn new(
        link: Link,
        registration: RegisterRequest,
        rollouts: Rollouts,
        device: Device,
    ) -> Self {
        let beat_every_ms = Arc::new(AtomicU64::new(5_000));
        Self { link, registration: Arc::new(registration), rollouts, device, beat_every_ms }
    }

    /// Registers, trying again while the server cannot be reached.
    pub(crate) async fn register(&self, patience: Duration) -> Result<(), Error> {
        let started = Instant::now();
        let mut backoff = Backoff::default();
        loop {
            match self.link.register((*self.registration).clone()).await {
                Ok(answer) => {
                    let limits = answer.rollout_limits.as_ref();
                    self.rollouts.set_limits(limits.map(Into::into).unwrap_or_default());
                    // A server's nonsense must not make this worker spin or fall silent.
                    let every = answer.beat_interval_s;
                    let every = if every.is_finite() { every.clamp(0.05, 60.0) } else { 5.0 };
                    self.beat_every_ms.store((every * 1000.0) as u64, Ordering::Relaxed);
                    return Ok(());
                }
                Err(LinkError::Unavailable(fault)) if started.elapsed() < patience => {
                    tracing::info!("waiting for the server: {fault}");
                    backoff.wait().await;
                }
                Err(error) => return Err(Error::Refused(error.fault().message)),
            }
        }
    }

    /// Says that the worker lives, until the task is aborted. A server that asks the worker to
    /// end cancels `drain`.
    pub(crate) async fn beat(self, drain: CancellationToken) {
        loop {
            let every = Duration::from_millis(self.beat_every_ms.load(Ordering::Relaxed));
            tokio::time::sleep(every).await;
            let memory = self.device.memory();
            let request = BeatRequest {
                worker: self.registration.worker.clone(),
                warm_twins: self.rollouts.warm_twins().iter().map(ToString::to_string).collect(),
                rollouts_in_flight: u32::try_from(self.rollouts.in_flight()).unwrap_or(u32::MAX),
                memory_used_bytes: memory.map_or(0, |m| m.used),
                memory_total_bytes: memory.map_or(0, |m| m.total),
            };
            match self.link.beat(request).await {
                Ok(answer) if answer.drain => {
                    tracing::info!("the server asks this worker to end");
                    return drain.cancel();
                }
                Ok(_) => {}
                Err(error) if is_unknown(&error) => self.register_again().await,
                Err(error) => tracing::warn!("no answer to a beat: {}", error.fault()),
            }
        }
    }

    /// After the server has forgotten the worker (it was away for long, say).
    pub(crate) async fn register_again(&self) {
        tracing::info!("the server does not know this worker: registering again");
        if let Err(error) = self.register(Duration::ZERO).await {
            tracing::warn!("{error}");
        }
    }
}

/// Whether the server says that it does not know this worker.
pub(crate) fn is_unknown(error: &LinkError) -> bool {
    matches!(error, LinkError::Refused(fault)
        if matches!(fault.category, Category::NotFound | Category::FailedPrecondition))
}
