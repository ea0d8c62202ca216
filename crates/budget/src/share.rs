//! A part of a budget, given back when it is dropped.

use std::sync::Arc;

use tokio::sync::{OwnedSemaphorePermit, Semaphore};

use crate::PAGE;

/// A part of a budget; dropping it gives it back.
#[derive(Debug)]
pub struct Share {
    permit: OwnedSemaphorePermit,
}

impl Share {
    pub(crate) fn try_new(pool: &Arc<Semaphore>, pages: u32) -> Option<Self> {
        Arc::clone(pool).try_acquire_many_owned(pages).ok().map(|permit| Self { permit })
    }

    /// `None` if the pool was closed, which never happens.
    pub(crate) async fn wait(pool: &Arc<Semaphore>, pages: u32) -> Option<Self> {
        Arc::clone(pool).acquire_many_owned(pages).await.ok().map(|permit| Self { permit })
    }

    /// Bytes of the share.
    pub fn bytes(&self) -> u64 {
        self.permit.num_permits() as u64 * PAGE
    }

    /// Gives back what goes beyond `bytes`.
    pub fn shrink(&mut self, bytes: u64) {
        let keep = usize::try_from(bytes.div_ceil(PAGE)).unwrap_or(usize::MAX);
        let surplus = self.permit.num_permits().saturating_sub(keep);
        drop(self.permit.split(surplus));
    }
}
