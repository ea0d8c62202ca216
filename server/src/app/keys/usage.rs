//! Usage by owner: for users what their owner has, for operators that of all, and for metrics the
//! largest, computed at intervals and not for each request.

use std::{sync::Arc, time::Duration};

use bendtwin_store::{OwnerUsage, Page, PageRequest};
use tokio::{sync::Mutex, time::Instant};

use super::super::{App, Result};
use crate::context::Context;

/// Age up to which the usage of all owners is reused for metrics.
const FRESH: Duration = Duration::from_secs(60);

/// The usage of all owners as it was computed last, and when.
#[derive(Debug, Default)]
pub(in crate::app) struct KnownUsage(Mutex<Option<(Instant, Arc<[OwnerUsage]>)>>);

impl App {
    /// Usage of the caller's owner, with the bounds of the key that is used.
    pub(crate) async fn usage(&self) -> Result<OwnerUsage> {
        let context = Context::current();
        let usage = self.store.usage().of(&context.caller.owner).await?;
        Ok(OwnerUsage { quotas: context.caller.quotas, ..usage })
    }

    /// Usage of all owners.
    pub(crate) async fn owner_usage(&self, page: &PageRequest) -> Result<Page<OwnerUsage>> {
        Ok(self.store.usage().list(&self.options.quotas.to_store(), page).await?)
    }

    /// Usage of all owners, at most a minute old.
    pub(in crate::app) async fn recent_usage(&self) -> Result<Arc<[OwnerUsage]>> {
        // Those who ask meanwhile wait for the one who computes it.
        let mut known = self.known_usage.0.lock().await;
        if let Some((_, usage)) = known.as_ref().filter(|(made, _)| made.elapsed() < FRESH) {
            return Ok(usage.clone());
        }
        let usage: Arc<[OwnerUsage]> =
            self.store.usage().all(&self.options.quotas.to_store()).await?.into();
        *known = Some((Instant::now(), usage.clone()));
        Ok(usage)
    }
}
