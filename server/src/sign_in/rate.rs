//! Requests that those who sign in may make in a time: fair shares for all networks, so that a few
//! networks cannot use up the rate of the others.

use std::{
    collections::HashMap,
    net::{IpAddr, Ipv6Addr},
    sync::{Mutex, PoisonError},
    time::Instant,
};

/// Largest share of a network, so that there is room for another.
const LARGEST_SHARE: f64 = 0.5;
/// Most networks that are distinguished. A further one takes the place of the least active.
const NETWORKS: usize = 1024;

/// Bounds on requests.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bounds {
    /// Requests that may come together, of all networks.
    burst: f64,
    /// Requests a second over longer times, of all networks.
    rate: f64,
    /// Burst that a network has in any case.
    own_burst: f64,
    /// Rate that a network has in any case.
    own_rate: f64,
}

/// Bounds on requests that make the server call the provider. What a network has in any case is
/// enough for a device that waits for its person.
pub(super) const OF_CALLS: Bounds =
    Bounds { burst: 240.0, rate: 8.0, own_burst: 8.0, own_rate: 0.25 };
/// Bounds on requests that the server answers from what it knows of the provider.
pub(super) const OF_STARTS: Bounds =
    Bounds { burst: 1200.0, rate: 40.0, own_burst: 60.0, own_rate: 2.0 };

/// Recent requests.
#[derive(Debug)]
pub(super) struct Rate {
    bounds: Bounds,
    networks: Mutex<HashMap<Option<IpAddr>, Bucket>>,
}

/// Recent requests of a network; they fade with time.
#[derive(Debug)]
struct Bucket {
    level: f64,
    at: Instant,
}

impl Rate {
    pub(super) fn new(bounds: Bounds) -> Self {
        Self { bounds, networks: Mutex::default() }
    }

    /// Counts a request of a network. False if it is one too many.
    ///
    /// Networks with recent requests share the rate equally. A further network takes part of their
    /// share, and does not have to wait until they pause.
    pub(super) fn admit(&self, network: Option<IpAddr>, now: Instant) -> bool {
        let Bounds { burst, rate, own_burst, own_rate } = self.bounds;
        let network = network.map(site_of);
        let mut networks = self.networks.lock().unwrap_or_else(PoisonError::into_inner);
        let share = |active: usize| LARGEST_SHARE.min(1.0 / active.max(1) as f64);
        let fading = (rate * share(networks.len())).max(own_rate);
        networks.retain(|_, bucket| {
            let passed = now.saturating_duration_since(bucket.at).as_secs_f64();
            bucket.level -= passed * fading;
            bucket.at = bucket.at.max(now);
            bucket.level > 0.0
        });
        if networks.len() >= NETWORKS && !networks.contains_key(&network) {
            let least = networks.iter().min_by(|(_, a), (_, b)| a.level.total_cmp(&b.level));
            let least = least.map(|(network, _)| *network);
            least.and_then(|least| networks.remove(&least));
        }
        let own = networks.entry(network).or_insert(Bucket { level: 0.0, at: now });
        let level = own.level;
        let bound = (burst * share(networks.len())).max(own_burst);
        if level + 1.0 > bound {
            return false;
        }
        if let Some(own) = networks.get_mut(&network) {
            own.level += 1.0;
        }
        true
    }
}

/// The addresses that one organisation or household may have: of IPv6 a network of 48 bits.
pub(super) fn site_of(network: IpAddr) -> IpAddr {
    match network {
        IpAddr::V6(v6) => IpAddr::V6(Ipv6Addr::from_bits(v6.to_bits() >> 80 << 80)),
        v4 => v4,
    }
}

#[cfg(test)]
mod tests {
    use std::{net::Ipv4Addr, time::Duration};

    use super::*;

    fn network(n: u32) -> Option<IpAddr> {
        Some(Ipv4Addr::from(n).into())
    }

    fn admitted(rate: &Rate, n: u32, now: Instant) -> usize {
        (0..2000).filter(|_| rate.admit(network(n), now)).count()
    }

    #[test]
    fn one_network_has_half_and_a_few_do_not_exclude_others() {
        let (rate, now) = (Rate::new(OF_CALLS), Instant::now());
        assert_eq!([1, 2, 3, 4].map(|n| admitted(&rate, n, now)), [120, 120, 80, 60]);
        assert_eq!(admitted(&rate, 1, now), 0);
        // The active ones share the rate equally.
        let later = now + Duration::from_secs(10);
        assert_eq!([5].map(|n| admitted(&rate, n, later)), [48]);
        assert_eq!(admitted(&rate, 1, later), 0);
    }

    #[test]
    fn a_network_has_enough_for_a_device_however_many_there_are() {
        let (rate, start) = (Rate::new(OF_CALLS), Instant::now());
        for n in 0..500 {
            admitted(&rate, n, start);
        }
        for step in 0..100 {
            let now = start + Duration::from_secs(5 * step);
            assert!(rate.admit(network(1000), now), "{step}");
            for n in 0..500 {
                rate.admit(network(n), now);
            }
        }
    }

    #[test]
    fn networks_of_one_site_count_together() {
        let (rate, now) = (Rate::new(OF_CALLS), Instant::now());
        let of = |n: u16| Some(IpAddr::from([0x2001, 0xdb8, 1, n, 0, 0, 0, 0]));
        assert_eq!((0..1000).filter(|n| rate.admit(of(*n), now)).count(), 120);
        assert!(rate.admit(Some(IpAddr::from([0x2001, 0xdb8, 2, 0, 0, 0, 0, 0])), now));
    }

    #[test]
    fn a_limited_number_of_networks_is_remembered_and_a_further_one_is_admitted() {
        let (rate, now) = (Rate::new(OF_CALLS), Instant::now());
        for n in 0..10 * NETWORKS as u32 {
            assert!(rate.admit(network(n), now));
        }
        assert!(rate.networks.lock().unwrap().len() <= NETWORKS);
    }
}
