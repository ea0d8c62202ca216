//! Bounds on the connections of a listener, in total and for each peer. If there is no place
//! left, the connection that has waited longest for its client makes room; if all are at work, the
//! new one is refused.

use std::{
    collections::HashMap,
    net::IpAddr,
    sync::{Arc, Mutex, MutexGuard, PoisonError},
};

use tokio_util::sync::CancellationToken;

use super::activity::Activity;
use crate::{context::network_of, metrics::Metrics};

/// The places of a listener. Clones share them.
#[derive(Clone, Debug)]
pub(super) struct Places {
    shared: Arc<Shared>,
}

#[derive(Debug)]
struct Shared {
    listener: &'static str,
    total: usize,
    per_peer: usize,
    metrics: Metrics,
    taken: Mutex<Occupancy>,
}

#[derive(Debug, Default)]
struct Occupancy {
    next_id: u64,
    by_id: HashMap<u64, Holder>,
    by_peer: HashMap<IpAddr, usize>,
}

#[derive(Debug)]
struct Holder {
    peer: IpAddr,
    activity: Arc<Activity>,
    evicted: CancellationToken,
}

/// A place, held as long as the connection is open.
#[derive(Debug)]
pub(super) struct Place {
    id: u64,
    pub(super) activity: Arc<Activity>,
    /// Cancelled when another connection has taken the place.
    pub(super) evicted: CancellationToken,
    shared: Arc<Shared>,
}

impl Places {
    pub(super) fn new(
        listener: &'static str,
        total: usize,
        per_peer: usize,
        metrics: Metrics,
    ) -> Self {
        let taken = Mutex::default();
        Self { shared: Arc::new(Shared { listener, total, per_peer, metrics, taken }) }
    }

    /// A place for a connection of that peer, if there is one or one can be made.
    pub(super) fn take(&self, peer: IpAddr) -> Option<Place> {
        let peer = network_of(peer);
        let mut taken = self.shared.taken();
        if taken.by_peer.get(&peer).is_some_and(|held| *held >= self.shared.per_peer) {
            self.shared.evict(&mut taken, Some(peer))?;
        }
        if taken.by_id.len() >= self.shared.total {
            self.shared.evict(&mut taken, None)?;
        }
        let (id, activity, evicted) = (taken.next_id, Activity::new(), CancellationToken::new());
        taken.next_id += 1;
        let holder = Holder { peer, activity: activity.clone(), evicted: evicted.clone() };
        taken.by_id.insert(id, holder);
        *taken.by_peer.entry(peer).or_default() += 1;
        self.shared.show(&taken);
        Some(Place { id, activity, evicted, shared: self.shared.clone() })
    }
}

impl Place {
    /// Name of the listener.
    pub(super) fn listener(&self) -> &'static str {
        self.shared.listener
    }

    /// Counts the end of the connection by the server.
    pub(super) fn ended(&self, why: &'static str) {
        self.shared.metrics.connection_ended(self.shared.listener, why);
    }
}

impl Drop for Place {
    fn drop(&mut self) {
        let mut taken = self.shared.taken();
        taken.remove(self.id);
        self.shared.show(&taken);
    }
}

impl Occupancy {
    fn remove(&mut self, id: u64) -> Option<Holder> {
        let holder = self.by_id.remove(&id)?;
        if let Some(held) = self.by_peer.get_mut(&holder.peer) {
            *held = held.saturating_sub(1);
            if *held == 0 {
                self.by_peer.remove(&holder.peer);
            }
        }
        Some(holder)
    }
}

impl Shared {
    fn taken(&self) -> MutexGuard<'_, Occupancy> {
        self.taken.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Closes the connection that has been quiet longest, of that peer if one is given.
    fn evict(&self, taken: &mut Occupancy, peer: Option<IpAddr>) -> Option<()> {
        let of_peer = taken.by_id.iter().filter(|(_, h)| peer.is_none_or(|peer| h.peer == peer));
        let quiet = of_peer.filter_map(|(id, h)| Some((h.activity.quiet_since()?, *id)));
        let longest = quiet.min().map(|(_, id)| id);
        let Some(holder) = longest.and_then(|id| taken.remove(id)) else {
            self.metrics.connection_ended(self.listener, "refused");
            return None;
        };
        holder.evicted.cancel();
        self.metrics.connection_ended(self.listener, "evicted");
        Some(())
    }

    fn show(&self, taken: &Occupancy) {
        self.metrics.connections(self.listener, taken.by_id.len());
    }
}

#[cfg(test)]
mod tests;
