//! Loaded twins, which answer immediately. They are kept while there is memory: beyond a number,
//! beyond an amount of memory, or when the device has none left for others, the longest unused go.

use std::{
    path::PathBuf,
    sync::{Arc, Mutex, MutexGuard, PoisonError},
};

use bendtwin_budget::{Exhausted, Share};
use bendtwin_core::{Twin, ids::TwinId};
use bendtwin_rollout::Warm;
use bytes::Bytes;

use super::{error::Error, lru::Lru};
use crate::{
    Limits,
    artifact::{self, FetchError},
    budget::{self, Memory},
    device::{Device, Priority},
    server_client::ServerClient,
};

/// Memory of a loaded twin and its fast variant [times the file's size, estimated].
const LOADED_FACTOR: u64 = 6;

type Shared = Arc<Mutex<Lru<TwinId, Arc<Warm>>>>;

/// The loaded twins, bounded by number and memory.
pub(crate) struct WarmTwins {
    server: ServerClient,
    device: Device,
    limits: Limits,
    memory: Memory,
    /// Folder for files while they are read.
    dir: PathBuf,
    twins: Shared,
    /// Held while a twin is loaded, so that a hundred calls for it load it once.
    loading: tokio::sync::Mutex<()>,
}

impl WarmTwins {
    pub(crate) fn new(
        server: ServerClient,
        device: Device,
        limits: Limits,
        memory: Memory,
        dir: PathBuf,
    ) -> Self {
        let bytes = limits.warm_bytes.min(memory.twins.total());
        let lru = Lru::new(limits.warm_twins.max(1), bytes);
        let twins = Arc::new(Mutex::new(lru));
        let shared = Arc::clone(&twins);
        device.on_shortage(move |bytes| spare(&shared, bytes));
        Self { server, device, limits, memory, dir, twins, loading: tokio::sync::Mutex::default() }
    }

    /// The twins that are loaded, the most recently used first.
    pub(crate) fn ids(&self) -> Vec<TwinId> {
        self.lock().keys()
    }

    /// A twin, loaded if need be.
    pub(super) async fn get(&self, id: TwinId) -> Result<Arc<Warm>, Error> {
        if let Some(warm) = self.lock().get(&id) {
            return Ok(warm);
        }
        let _loading = self.loading.lock().await;
        if let Some(warm) = self.lock().get(&id) {
            return Ok(warm);
        }
        let (name, limit) = (id.to_string(), self.limits.twin_bytes);
        let file = artifact::fetch_file(&self.server, &name, None, &self.dir).await?;
        // Its memory is taken when its size is known, before any of it is read.
        let size = file.as_file().metadata().map_or(u64::MAX, |m| m.len());
        if size > limit {
            return Err(FetchError::TooLarge { name, limit }.into());
        }
        let share = self.room(size.saturating_mul(LOADED_FACTOR)).await?;
        let read = tokio::task::spawn_blocking(move || std::fs::read(file.path()));
        let read = read.await.map_err(|_| Error::Panicked)?;
        let content = read.map_err(|source| FetchError::Disk { name, source })?;
        self.load(id, content.into(), Some(share)).await
    }

    /// Memory for a twin; longest unused ones make room for it.
    async fn room(&self, bytes: u64) -> Result<Share, Error> {
        let budget = &self.memory.twins;
        loop {
            match budget.try_take(bytes) {
                Ok(share) => return Ok(share),
                Err(Exhausted::InUse { .. }) if spare(&self.twins, bytes) => {}
                Err(_) => break,
            }
        }
        budget::take(budget, bytes, "loading the twin: raise --memory-mib of the worker").await
    }

    /// Loads a twin's file and keeps it.
    async fn load(
        &self,
        id: TwinId,
        file: Bytes,
        share: Option<Share>,
    ) -> Result<Arc<Warm>, Error> {
        let size = share.as_ref().map_or(file.len() as u64 * LOADED_FACTOR, Share::bytes);
        let device = self.device.clone();
        let warm = tokio::task::spawn_blocking(move || {
            let twin = Twin::decode(&file).map_err(Error::StoredTwin)?;
            let warm = Warm::load(id, twin, &device.backend(Priority::Interactive), share)?;
            Ok::<_, Error>(Arc::new(warm))
        })
        .await
        .map_err(|_| Error::Panicked)??;
        tracing::info!(twin = %id, nodes = warm.twin().graph.node_count(), "twin loaded");
        self.lock().insert(id, Arc::clone(&warm), size);
        Ok(warm)
    }

    fn lock(&self) -> MutexGuard<'_, Lru<TwinId, Arc<Warm>>> {
        lock(&self.twins)
    }
}

fn lock(twins: &Shared) -> MutexGuard<'_, Lru<TwinId, Arc<Warm>>> {
    twins.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Unloads twins for about `bytes`; false if none can be spared.
fn spare(twins: &Shared, bytes: u64) -> bool {
    // Those that a request is using would free nothing.
    let gone = lock(twins).evict(bytes, |warm| Arc::strong_count(warm) == 1);
    for warm in &gone {
        tracing::info!(twin = %warm.id(), "twin unloaded: others need its memory");
    }
    !gone.is_empty()
}

#[cfg(test)]
mod tests;
