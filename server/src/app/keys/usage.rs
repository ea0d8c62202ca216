//! Usage by owner: for users what their owner has, for operators that of all, and for metrics the
//! largest, computed at intervals and not for each request.

use std::{sync::Arc, time::Duration};

use bendtwin_store::{OwnerUsage, Page, PageRequest};

use super::super::{App, Result, renewed::Renewed};
use crate::context::Context;

/// Age up to which the usage of all owners is reused for metrics.
const FRESH: Duration = Duration::from_secs(60);
/// Longest wait for a newer one.
const PATIENCE: Duration = Duration::from_secs(1);

/// The usage of all owners as it was computed last.
pub(in crate::app) type KnownUsage = Renewed<Arc<[OwnerUsage]>>;

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

    /// Usage of all owners, a minute old or, while the database does not answer, older; none before the
    /// first.
    pub(in crate::app) async fn recent_usage(&self) -> Option<Arc<[OwnerUsage]>> {
        let make = || {
            let (store, defaults) = (self.store.clone(), self.options.quotas.to_store());
            async move {
                let read = store.usage().all(&defaults).await;
                let read = read.inspect_err(|error| tracing::warn!(%error, "no metrics by owner"));
                read.ok().map(Into::into)
            }
        };
        Some(self.known_usage.get(FRESH, PATIENCE, make).await?.value)
    }
}
