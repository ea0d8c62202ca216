//! Twins that are loaded and answer at once.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use bendtwin_core::{Twin, ids::TwinId};
use bendtwin_engine::{Backend, Loaded, Model};
use tokio::sync::OnceCell;

use super::{error::Error, lru::Lru};
use crate::{Limits, artifact, device::Device, device::Priority, link::Link};

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

/// The loaded twins, bounded by number and memory.
pub(crate) struct WarmTwins {
    link: Link,
    device: Device,
    limits: Limits,
    twins: Mutex<Lru<TwinId, Arc<Warm>>>,
    /// Held while a twin is loaded, so that a hundred calls for it load it once.
    loading: tokio::sync::Mutex<()>,
}

impl WarmTwins {
    pub(crate) fn new(link: Link, device: Device, limits: Limits) -> Self {
        let twins = Mutex::new(Lru::new(limits.warm_twins.max(1), limits.warm_bytes));
        Self { link, device, limits, twins, loading: tokio::sync::Mutex::default() }
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
        let file = artifact::fetch(&self.link, &id.to_string(), self.limits.twin_bytes).await?;
        let size = file.len() as u64 * LOADED_FACTOR;
        let device = self.device.clone();
        let warm = tokio::task::spawn_blocking(move || {
            let twin = Twin::decode(&file).map_err(Error::StoredTwin)?;
            let loaded = device.lane(Priority::Interactive).load(Arc::new(Model::from(&twin)))?;
            Ok::<_, Error>(Arc::new(Warm { id, twin, loaded, fast: OnceCell::new() }))
        })
        .await
        .map_err(|_| Error::Panicked)??;
        tracing::info!(twin = %id, nodes = warm.twin.graph.node_count(), "twin loaded");
        self.lock().insert(id, Arc::clone(&warm), size);
        Ok(warm)
    }

    fn lock(&self) -> MutexGuard<'_, Lru<TwinId, Arc<Warm>>> {
        self.twins.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
