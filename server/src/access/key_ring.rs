//! The keys, and the projects of their owners, as this server knows them.
//!
//! They are read from the store again after [`FRESH`], so that a revocation, or a change of a project, by
//! another server of the same store takes effect here. All who wait share one reading and its result.
//! While the store does not answer, keys that are known stay good for [`GOOD_WHILE_AWAY`] after the last
//! reading, keys that are not known are refused as [`Error::DatabaseUnavailable`], and one reading at a
//! time looks whether the store is back, so that callers get their answers without waiting for it.

use std::{
    collections::HashMap,
    fmt,
    sync::{Arc, Mutex, MutexGuard, PoisonError},
    time::Duration,
};

use bendtwin_core::ids::KeyId;
use bendtwin_store::{Error, Key, Memberships, Quotas, Store};
use futures::{FutureExt as _, future::BoxFuture};
use jiff::Timestamp;
use tokio::{
    sync::watch,
    time::{Instant, timeout, timeout_at},
};

use crate::error::Result;

/// Time for which what was read counts.
const FRESH: Duration = Duration::from_secs(10);
/// Time for which it does where a key is not among it: another server may have made it meanwhile.
/// Strangers who show keys that nobody made cause one query in that time.
const FRESH_IF_UNKNOWN: Duration = Duration::from_secs(1);
/// Time for which it does while the store cannot be read. A revocation by another server is delayed
/// by this at most.
const GOOD_WHILE_AWAY: Duration = Duration::from_secs(300);
/// Longest time of one reading.
const READING: Duration = Duration::from_millis(4500);
/// Time after a reading that failed in which there is no other.
const AGAIN: Duration = Duration::from_secs(1);
/// Longest wait of a call with a known key for a reading.
const PATIENCE_IF_KNOWN: Duration = Duration::from_millis(500);
/// Longest wait of a call with an unknown key, and that after a reading that failed: the store may be
/// back.
const PATIENCE: Duration = Duration::from_secs(5);
const PATIENCE_WHILE_AWAY: Duration = Duration::from_secs(1);
/// Time after which a use is recorded again.
const USE_INTERVAL: Duration = Duration::from_secs(60);

/// Reads all keys, and the projects of all owners.
type Source = Arc<
    dyn Fn() -> BoxFuture<'static, bendtwin_store::Result<(Vec<Key>, Memberships)>> + Send + Sync,
>;

/// A key with what decides about those who hold it.
#[derive(Clone, Debug)]
pub(crate) struct Holder {
    pub(crate) key: Arc<Key>,
    /// The projects of all owners.
    pub(crate) memberships: Arc<Memberships>,
}

/// Keys by id, and the projects of their owners.
#[derive(Clone, Debug)]
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

/// The keys of a store. Clones share it.
#[derive(Clone)]
pub(crate) struct KeyRing {
    store: Store,
    source: Source,
    /// Bounds of keys that state none.
    defaults: Quotas,
    inner: Arc<Inner>,
}

#[derive(Default)]
struct Inner {
    state: Mutex<State>,
    /// Counts the readings that have ended.
    ended: watch::Sender<u64>,
    /// Uses that are not recorded yet.
    used: Mutex<HashMap<KeyId, Timestamp>>,
}

#[derive(Default)]
struct State {
    /// The keys and when their reading began; none before the first.
    keys: Option<(Known, Instant)>,
    /// True while a reading is under way.
    is_reading: bool,
    /// True if the projects have changed here since it began: then it does not count.
    is_outdated: bool,
    /// Keys that changed here since it began, which it may have missed.
    changed: Vec<Arc<Key>>,
    /// End of the last reading, if that failed.
    failed: Option<Instant>,
}

impl fmt::Debug for KeyRing {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("KeyRing").finish_non_exhaustive()
    }
}

impl KeyRing {
    /// `defaults` are the bounds of keys that state none.
    pub(crate) fn new(store: Store, defaults: Quotas) -> Self {
        let from = store.clone();
        let source = move || {
            let store = from.clone();
            let read = async move {
                // Memberships first: a key that is made meanwhile has none too many.
                let memberships = store.projects().memberships().await?;
                Ok((store.keys().all().await?, memberships))
            };
            read.boxed()
        };
        Self::with_source(Arc::new(source), store, defaults)
    }

    fn with_source(source: Source, store: Store, defaults: Quotas) -> Self {
        Self { store, source, defaults, inner: Arc::default() }
    }

    /// A key, with the bounds that hold for it; none if there is no such one.
    ///
    /// # Errors
    /// [`Error::DatabaseUnavailable`] if the store cannot be read and the key is not known, or has not
    /// been read for [`GOOD_WHILE_AWAY`].
    pub(crate) async fn find(&self, id: KeyId) -> Result<Option<Holder>> {
        let asked = Instant::now();
        let (is_known, is_away) = {
            let state = self.lock();
            (state.get(id, GOOD_WHILE_AWAY).is_some(), state.failed.is_some())
        };
        let patience = match (is_known, is_away) {
            (true, true) => Duration::ZERO,
            (true, false) => PATIENCE_IF_KNOWN,
            (false, true) => PATIENCE_WHILE_AWAY,
            (false, false) => PATIENCE,
        };
        loop {
            let reading = {
                let mut state = self.lock();
                if let Some(holder) = state.get(id, FRESH) {
                    return Ok(Some(holder));
                }
                if state.began().is_some_and(|began| began + FRESH_IF_UNKNOWN > asked) {
                    return Ok(None);
                }
                self.renew(&mut state)
            };
            let Some(mut ended) = reading else { break };
            if timeout_at(asked + patience, ended.changed()).await.is_err() {
                break;
            }
        }
        match self.lock().get(id, GOOD_WHILE_AWAY) {
            Some(holder) => Ok(Some(holder)),
            None => Err(Error::DatabaseUnavailable.into()),
        }
    }

    /// Takes over a key that was made or changed here, and that the store has.
    pub(crate) fn learn(&self, key: &Key) {
        let key = Arc::new(self.bounded(key.clone()));
        let mut state = self.lock();
        if state.is_reading {
            state.changed.push(Arc::clone(&key));
        }
        if let Some((known, _)) = &mut state.keys {
            put(&mut Arc::make_mut(known).keys, key);
        }
    }

    /// Forgets what was read: projects have changed here, and what a reading under way finds may be
    /// from before.
    pub(crate) fn forget(&self) {
        let mut state = self.lock();
        state.keys = None;
        state.is_outdated = state.is_reading;
    }

    /// The key with the bounds of keys that state none.
    fn bounded(&self, key: Key) -> Key {
        Key { quotas: key.quotas.or(&self.defaults), ..key }
    }

    /// Notes that a key is used now.
    pub(crate) fn note_use(&self, key: &Key) {
        let now = self.store.now();
        let is_recorded = key.used.is_some_and(|used| {
            now.duration_since(used)
                < jiff::SignedDuration::from_secs(USE_INTERVAL.as_secs() as i64)
        });
        if !is_recorded {
            self.uses().insert(key.id, now);
        }
    }

    /// Records the uses that were noted; those that cannot be recorded stay for the next time.
    pub(crate) async fn record_uses(&self) -> Result<()> {
        let uses = std::mem::take(&mut *self.uses());
        if uses.is_empty() {
            return Ok(());
        }
        let list: Vec<_> = uses.iter().map(|(id, time)| (*id, *time)).collect();
        let recorded = self.store.keys().used(&list).await;
        if recorded.is_err() {
            let mut noted = self.uses();
            for (id, time) in uses {
                noted.entry(id).or_insert(time);
            }
        }
        Ok(recorded?)
    }

    /// Notification of the end of the reading under way, which is begun if necessary; `None` soon after
    /// one that failed.
    fn renew(&self, state: &mut State) -> Option<watch::Receiver<u64>> {
        let ended = self.inner.ended.subscribe();
        if state.is_reading {
            return Some(ended);
        }
        if state.failed.is_some_and(|failed| failed.elapsed() < AGAIN) {
            return None;
        }
        state.is_reading = true;
        state.is_outdated = false;
        state.changed.clear();
        let ring = self.clone();
        tokio::spawn(async move {
            let _reading = Reading(&ring.inner);
            let began = Instant::now();
            let read = timeout(READING, (ring.source)()).await;
            let read =
                read.unwrap_or(Err(Error::DatabaseUnavailable)).map(|(keys, memberships)| {
                    let keys = keys.into_iter().map(|key| (key.id, Arc::new(ring.bounded(key))));
                    Everyone { keys: keys.collect(), memberships: Arc::new(memberships) }
                });
            ring.lock().settle(began, read);
        });
        Some(ended)
    }

    fn uses(&self) -> MutexGuard<'_, HashMap<KeyId, Timestamp>> {
        self.inner.used.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn lock(&self) -> MutexGuard<'_, State> {
        self.inner.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl State {
    /// Begin of the reading that counts.
    fn began(&self) -> Option<Instant> {
        self.keys.as_ref().map(|(_, began)| *began)
    }

    /// A key, if it was read within `fresh`.
    fn get(&self, id: KeyId, fresh: Duration) -> Option<Holder> {
        let (known, began) = self.keys.as_ref()?;
        if began.elapsed() < fresh { known.find(id) } else { None }
    }

    /// Takes over the result of a reading.
    fn settle(&mut self, began: Instant, read: bendtwin_store::Result<Everyone>) {
        match read {
            Ok(_) if self.is_outdated => {}
            Ok(mut everyone) => {
                for key in self.changed.drain(..) {
                    put(&mut everyone.keys, key);
                }
                self.keys = Some((Arc::new(everyone), began));
                if self.failed.take().is_some() {
                    tracing::info!("the keys of clients can be read again");
                }
            }
            Err(error) => {
                if self.failed.is_none() {
                    tracing::error!(%error, "cannot read the keys of clients; trying again");
                }
                self.failed = Some(Instant::now());
            }
        }
    }
}

/// Puts a key among others. A revocation is never taken back.
fn put(keys: &mut HashMap<KeyId, Arc<Key>>, key: Arc<Key>) {
    if keys.get(&key.id).is_none_or(|found| found.revoked.is_none()) {
        keys.insert(key.id, key);
    }
}

/// Marks a reading as ended, also if it panicked.
struct Reading<'a>(&'a Inner);

impl Drop for Reading<'_> {
    fn drop(&mut self) {
        self.0.state.lock().unwrap_or_else(PoisonError::into_inner).is_reading = false;
        self.0.ended.send_modify(|ended| *ended += 1);
    }
}

#[cfg(test)]
mod tests;
