//! The rate of requests that make the server call the identity provider, or look up who signs in: in
//! total, and for each network, so that one cannot use up the rate of all.

use std::{
    collections::HashMap,
    net::IpAddr,
    sync::{Mutex, PoisonError},
    time::Instant,
};

/// Requests that may come together.
const BURST: f64 = 240.0;
/// Requests a second over longer times.
const RATE: f64 = 8.0;
/// Share of a network.
const SHARE: f64 = 0.5;
/// Most networks that are distinguished.
const NETWORKS: usize = 1024;

/// The requests of late.
#[derive(Debug, Default)]
pub(super) struct Rate(Mutex<Buckets>);

#[derive(Debug, Default)]
struct Buckets {
    all: Bucket,
    networks: HashMap<Option<IpAddr>, Bucket>,
}

/// Requests that count against a bound; they fade with time.
#[derive(Debug, Default)]
struct Bucket {
    level: f64,
    at: Option<Instant>,
}

impl Bucket {
    fn fade(&mut self, share: f64, now: Instant) {
        let passed = self.at.map_or(0.0, |at| now.saturating_duration_since(at).as_secs_f64());
        self.level = (self.level - passed * RATE * share).max(0.0);
        self.at = Some(now);
    }

    fn has_room(&self, share: f64) -> bool {
        self.level + 1.0 <= BURST * share
    }
}

impl Rate {
    /// Counts a request of a network. False if it is one too many.
    pub(super) fn admit(&self, network: Option<IpAddr>, now: Instant) -> bool {
        let mut buckets = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let Buckets { all, networks } = &mut *buckets;
        all.fade(1.0, now);
        if networks.len() >= NETWORKS && !networks.contains_key(&network) {
            networks.retain(|_, bucket| {
                bucket.fade(SHARE, now);
                bucket.level > 0.0
            });
        }
        if networks.len() >= NETWORKS && !networks.contains_key(&network) {
            return false;
        }
        let own = networks.entry(network).or_default();
        own.fade(SHARE, now);
        if !own.has_room(SHARE) || !all.has_room(1.0) {
            return false;
        }
        own.level += 1.0;
        all.level += 1.0;
        true
    }
}

#[cfg(test)]
mod tests {
    use std::{net::Ipv4Addr, time::Duration};

    use super::*;

    fn network(n: u32) -> Option<IpAddr> {
        Some(Ipv4Addr::from(n).into())
    }

    #[test]
    fn one_network_has_half_and_all_together_the_whole() {
        let (rate, now) = (Rate::default(), Instant::now());
        let admitted = |n| (0..1000).filter(|_| rate.admit(network(n), now)).count();
        assert_eq!((admitted(1), admitted(2), admitted(3)), (120, 120, 0));
        let later = now + Duration::from_secs(1);
        assert_eq!((0..1000).filter(|_| rate.admit(network(1), later)).count(), 4);
        assert_eq!((0..1000).filter(|_| rate.admit(network(3), later)).count(), 4);
    }

    #[test]
    fn a_limited_number_of_networks_is_remembered() {
        let (rate, start) = (Rate::default(), Instant::now());
        for n in 0..10 * NETWORKS as u32 {
            rate.admit(network(n), start + Duration::from_millis(n.into()));
        }
        assert!(rate.0.lock().unwrap().networks.len() <= NETWORKS);
    }
}
