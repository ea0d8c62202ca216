//! The keys, and the projects of their owners, as this server knows them. They are read from the store
//! again after a while, so a revocation, or a change of a project, by another server of the same store
//! takes effect here within [`FRESH`].

use std::{
    collections::HashMap,
    sync::{Arc, Mutex, PoisonError, RwLock},
    time::Duration,
};

use bendtwin_core::ids::KeyId;
use bendtwin_store::{Key, Memberships, Quotas, Store};
use jiff::Timestamp;
use tokio::time::Instant;

use crate::error::Result;

/// Time for which what was read counts.
const FRESH: Duration = Duration::from_secs(10);
/// Time for which it does where a key is not among it: another server may have made it meanwhile.
/// Strangers who show keys that nobody made cause one query in that time.
const FRESH_IF_UNKNOWN: Duration = Duration::from_secs(1);
/// Time after which a use is recorded again.
const USE_INTERVAL: Duration = Duration::from_secs(60);

/// The keys of a store. Clones share it.
#[derive(Clone, Debug)]
pub(crate) struct KeyRing {
    store: Store,
    /// Bounds of keys that state none.
    defaults: Quotas,
    inner: Arc<Inner>,
}

#[derive(Debug, Default)]
struct Inner {
    known: RwLock<Snapshot>,
    /// Held by the one who reads.
    reading: tokio::sync::Mutex<()>,
    /// Uses that are not recorded yet.
    used: Mutex<HashMap<KeyId, Timestamp>>,
}

/// A key with what decides about those who hold it.
#[derive(Clone, Debug)]
pub(crate) struct Holder {
    pub(crate) key: Arc<Key>,
    /// The projects of all owners.
    pub(crate) memberships: Arc<Memberships>,
}

/// Keys by id, and the projects of their owners.
#[derive(Debug)]
struct Everyone {
    keys: HashMap<KeyId, Arc<Key>>,
    memberships: Arc<Memberships>,
}

impl Everyone {
    fn find(&self, id: KeyId) -> Option<Holder> {
        let key = Arc::clone(self.keys.get(&id)?);
        Some(Holder { key, memberships: Arc::clone(&self.memberships) })
    }
}

type Known = Arc<Everyone>;

/// Keys as they were read.
#[derive(Debug, Default)]
struct Snapshot {
    /// The keys and when they were read; none if they are to be read.
    keys: Option<(Known, Instant)>,
    /// Grows with every change here: what was read before one does not count after it.
    changes: u64,
}

impl KeyRing {
    pub(crate) fn new(store: Store, defaults: Quotas) -> Self {
        Self { store, defaults, inner: Arc::default() }
    }

    /// A key, with the bounds that hold for it; none if there is no such one.
    ///
    /// # Errors
    /// If the store cannot be read: then no key counts.
    pub(crate) async fn find(&self, id: KeyId) -> Result<Option<Holder>> {
        if let Some(holder) = self.known(FRESH).and_then(|known| known.find(id)) {
            return Ok(Some(holder));
        }
        Ok(self.read(FRESH_IF_UNKNOWN).await?.find(id))
    }

    /// Notes that a key is used now.
    pub(crate) fn note_use(&self, key: &Key) {
        let now = self.store.now();
        let is_recorded = key.used.is_some_and(|used| {
            now.duration_since(used)
                < jiff::SignedDuration::from_secs(USE_INTERVAL.as_secs() as i64)
        });
        if !is_recorded {
            self.inner.used.lock().unwrap_or_else(PoisonError::into_inner).insert(key.id, now);
        }
    }

    /// Records the uses that were noted.
    pub(crate) async fn record_uses(&self) -> Result<()> {
        let uses =
            std::mem::take(&mut *self.inner.used.lock().unwrap_or_else(PoisonError::into_inner));
        if uses.is_empty() {
            return Ok(());
        }
        Ok(self.store.keys().used(&uses.into_iter().collect::<Vec<_>>()).await?)
    }

    /// Forgets what was read: keys or projects have changed here.
    pub(crate) fn forget(&self) {
        let mut known = self.inner.known.write().unwrap_or_else(PoisonError::into_inner);
        known.keys = None;
        known.changes += 1;
    }

    /// The keys, if they were read within `fresh`.
    fn known(&self, fresh: Duration) -> Option<Known> {
        let known = self.inner.known.read().unwrap_or_else(PoisonError::into_inner);
        known.keys.as_ref().filter(|(_, read)| read.elapsed() < fresh).map(|(keys, _)| keys.clone())
    }

    /// The keys, read again unless that was done within `fresh`, by one of all who wait for it.
    async fn read(&self, fresh: Duration) -> Result<Known> {
        let _reading = self.inner.reading.lock().await;
        if let Some(keys) = self.known(fresh) {
            return Ok(keys);
        }
        let changes = self.inner.known.read().unwrap_or_else(PoisonError::into_inner).changes;
        let read = Instant::now();
        let memberships = Arc::new(self.store.projects().memberships().await?);
        let keys = self.store.keys().all().await?;
        let bounded = |key: Key| Key { quotas: key.quotas.or(&self.defaults), ..key };
        let keys = keys.into_iter().map(|key| (key.id, Arc::new(bounded(key)))).collect();
        let keys = Arc::new(Everyone { keys, memberships });
        let mut known = self.inner.known.write().unwrap_or_else(PoisonError::into_inner);
        if known.changes == changes {
            known.keys = Some((keys.clone(), read));
        }
        Ok(keys)
    }
}
