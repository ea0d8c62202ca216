//! Twins that are loaded and answer at once. They are kept while there is room: beyond a number,
//! beyond an amount of memory, or when the device has none left for others, the longest unused go.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use bendtwin_core::{Twin, ids::TwinId};
use bendtwin_engine::{Backend as _, Loaded, Model};
use bytes::Bytes;
use tokio::sync::OnceCell;

use super::{error::Error, lru::Lru};
use crate::{Limits, artifact, device::Device, device::Priority, server_client::ServerClient};

/// Memory of a loaded twin and its fast variant [times the file's size, estimated].
const LOADED_FACTOR: u64 = 6;

/// A twin on the device.
pub(crate) struct Warm {
    pub(super) id: TwinId,
    pub(super) twin: Twin,
    pub(super) loaded: Loaded,
    /// The fast variant, once somebody has asked for it.
    pub(super) fast: OnceCell<Loaded>,
}

type Shared = Arc<Mutex<Lru<TwinId, Arc<Warm>>>>;

/// The loaded twins, bounded by number and memory.
pub(crate) struct WarmTwins {
    server: ServerClient,
    device: Device,
    limits: Limits,
    twins: Shared,
    /// Held while a twin is loaded, so that a hundred calls for it load it once.
    loading: tokio::sync::Mutex<()>,
}

impl WarmTwins {
    pub(crate) fn new(server: ServerClient, device: Device, limits: Limits) -> Self {
        let lru = Lru::new(limits.warm_twins.max(1), limits.warm_bytes);
        let twins = Arc::new(Mutex::new(lru));
        let shared = Arc::clone(&twins);
        device.on_shortage(move |bytes| spare(&shared, bytes));
        Self { server, device, limits, twins, loading: tokio::sync::Mutex::default() }
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
        let file = artifact::fetch(&self.server, &id.to_string(), self.limits.twin_bytes).await?;
        self.load(id, file).await
    }

    /// Loads a twin's file and keeps it.
    async fn load(&self, id: TwinId, file: Bytes) -> Result<Arc<Warm>, Error> {
        let size = file.len() as u64 * LOADED_FACTOR;
        let device = self.device.clone();
        let warm = tokio::task::spawn_blocking(move || {
            let twin = Twin::decode(&file).map_err(Error::StoredTwin)?;
            let loaded =
                device.backend(Priority::Interactive).load(Arc::new(Model::from(&twin)))?;
            Ok::<_, Error>(Arc::new(Warm { id, twin, loaded, fast: OnceCell::new() }))
        })
        .await
        .map_err(|_| Error::Panicked)??;
        tracing::info!(twin = %id, nodes = warm.twin.graph.node_count(), "twin loaded");
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

/// Gives up twins for about so many bytes; false if none can be spared.
fn spare(twins: &Shared, bytes: u64) -> bool {
    // Those that a request is using would free nothing.
    let gone = lock(twins).evict(bytes, |warm| Arc::strong_count(warm) == 1);
    for warm in &gone {
        tracing::info!(twin = %warm.id, "twin unloaded: the device needs its memory");
    }
    !gone.is_empty()
}

#[cfg(test)]
mod tests;
