//! A call with one reply: its place among those under way, its memory, and the token that stops its
//! work when the caller goes away.

use std::sync::Arc;

use bendtwin_core::CancelToken;
use tokio::sync::OwnedSemaphorePermit;

use super::{RequestHold, blocking};
use crate::{
    device::{Account, Device, QueuedBackend},
    rollout::error::Error,
};

/// A call with one reply. Dropped with the call, by a deadline or a caller that goes away, it stops
/// the work.
pub(in crate::rollout) struct Unary {
    pub(super) held: RequestHold,
    /// Account whose turns it takes.
    pub(super) account: Option<Account>,
    /// Released when the work has ended, also when the caller is gone.
    pub(super) slot: Arc<OwnedSemaphorePermit>,
    pub(super) cancel: CancelToken,
}

impl Unary {
    /// The token that stops the work.
    pub(in crate::rollout) fn cancel(&self) -> &CancelToken {
        &self.cancel
    }

    /// A backend whose calls take the turns of the call's account.
    pub(in crate::rollout) fn backend(&self, device: &Device) -> QueuedBackend {
        device.backend_for(self.account.as_ref())
    }

    /// Runs work beside the tasks of the runtime, with the call's place and memory.
    pub(in crate::rollout) async fn blocking<T: Send + 'static>(
        &self,
        work: impl FnOnce(&CancelToken) -> Result<T, Error> + Send + 'static,
    ) -> Result<T, Error> {
        let (slot, cancel) = (Arc::clone(&self.slot), self.cancel.clone());
        blocking(&self.held, move || {
            let _slot = slot;
            work(&cancel)
        })
        .await
    }
}

impl Drop for Unary {
    fn drop(&mut self) {
        self.cancel.cancel();
    }
}
