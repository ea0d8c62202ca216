//! Calls of the identity provider under way. A slow provider keeps them for long, so they are bounded,
//! and a network has the fewer of them the fewer are left: a few networks cannot take them all.

use std::{
    collections::HashMap,
    net::IpAddr,
    sync::{Mutex, PoisonError},
};

use super::rate::site_of;

/// Calls at a time, of networks that have several.
const SHARED: usize = 64;
/// Calls at a time, with the first one of each network.
const MOST: usize = 256;

/// Calls under way, by network.
#[derive(Debug, Default)]
pub(super) struct Calls(Mutex<HashMap<Option<IpAddr>, usize>>);

/// A call under way.
#[derive(Debug)]
pub(super) struct Call<'a> {
    calls: &'a Calls,
    network: Option<IpAddr>,
}

impl Calls {
    /// Counts a call of a network as long as the result is held; `None` if it is one too many.
    pub(super) fn begin(&self, network: Option<IpAddr>) -> Option<Call<'_>> {
        let network = network.map(site_of);
        let mut calls = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let all: usize = calls.values().sum();
        let may = match calls.get(&network) {
            None => all < MOST,
            // One network gets a third.
            Some(own) => 2 * own < SHARED.saturating_sub(all),
        };
        if !may {
            return None;
        }
        *calls.entry(network).or_default() += 1;
        Some(Call { calls: self, network })
    }
}

impl Drop for Call<'_> {
    fn drop(&mut self) {
        let mut calls = self.calls.0.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(own) = calls.get_mut(&self.network) {
            *own -= 1;
            if *own == 0 {
                calls.remove(&self.network);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use std::net::Ipv4Addr;

    use super::*;

    #[test]
    fn no_network_and_no_few_networks_have_all() {
        let calls = Calls::default();
        let begun = |n: u32| {
            let network = Some(Ipv4Addr::from(n).into());
            (0..1000).map_while(|_| calls.begin(network)).collect::<Vec<_>>()
        };
        let (first, second) = (begun(1), begun(2));
        assert_eq!((first.len(), second.len()), (22, 14));
        let others: Vec<_> = (3..100).map(begun).collect();
        assert!(others.iter().all(|calls| !calls.is_empty()));
        let many: Vec<_> = (100..1000).map(begun).collect();
        let all = [first, second].into_iter().chain(others).chain(many);
        assert_eq!(all.map(|calls| calls.len()).sum::<usize>(), MOST);
        assert!(calls.0.lock().unwrap().is_empty());
        assert_eq!(begun(1).len(), 22);
    }
}
