//! Asks the server for fits, one after another.

use std::time::Duration;

use bendtwin_core::Category;
use tokio_util::sync::CancellationToken;

use crate::{
    Error,
    fit::Fits,
    link::{Backoff, LinkError},
    presence::{Presence, is_unknown},
};

/// How long the server may hold a call for a job.
const WAIT: Duration = Duration::from_secs(20);

/// When to stop.
#[derive(Clone, Debug)]
pub(crate) struct Until {
    /// No further job is leased.
    pub(crate) closed: CancellationToken,
    /// The job under way is handed back, too.
    pub(crate) drained: CancellationToken,
}

/// Leases and executes fits.
///
/// # Errors
/// If the server refuses this worker for good.
pub(crate) async fn lease(fits: &Fits, presence: &Presence, until: &Until) -> Result<(), Error> {
    let mut backoff = Backoff::default();
    while !until.closed.is_cancelled() {
        let leased = tokio::select! {
            leased = fits.link.lease_fit(fits.worker.clone(), WAIT) => leased,
            () = until.closed.cancelled() => return Ok(()),
        };
        match leased {
            Ok(lease) => {
                backoff = Backoff::default();
                if let Some(lease) = lease {
                    fits.execute(lease, &until.drained).await;
                }
            }
            Err(LinkError::Refused(fault))
                if matches!(
                    fault.category,
                    Category::Unauthenticated | Category::PermissionDenied
                ) =>
            {
                return Err(Error::Refused(fault.message));
            }
            Err(error) => {
                if is_unknown(&error) {
                    presence.register_again().await;
                } else {
                    tracing::debug!("no job: {}", error.fault());
                }
                tokio::select! {
                    () = backoff.wait() => {}
                    () = until.closed.cancelled() => return Ok(()),
                }
            }
        }
    }
    Ok(())
}
