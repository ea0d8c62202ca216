//! A small least-recently-used map, bounded by entries and by total size.

use std::{collections::HashMap, hash::Hash};

/// Keeps the most recently used values.
pub(super) struct Lru<K, V> {
    entries: HashMap<K, Entry<V>>,
    max_entries: usize,
    max_size: u64,
    clock: u64,
}

struct Entry<V> {
    value: V,
    size: u64,
    used: u64,
}

impl<K: Copy + Eq + Hash, V: Clone> Lru<K, V> {
    pub(super) fn new(max_entries: usize, max_size: u64) -> Self {
        Self { entries: HashMap::new(), max_entries, max_size, clock: 0 }
    }

    /// The value, which now counts as just used.
    pub(super) fn get(&mut self, key: &K) -> Option<V> {
        self.clock += 1;
        let entry = self.entries.get_mut(key)?;
        entry.used = self.clock;
        Some(entry.value.clone())
    }

    /// Adds a value and drops the longest unused ones that no longer fit. The newest always stays:
    /// its user holds it anyway.
    pub(super) fn insert(&mut self, key: K, value: V, size: u64) {
        self.clock += 1;
        self.entries.insert(key, Entry { value, size, used: self.clock });
        while self.entries.len() > 1 && self.is_over() {
            if self.pop(|_| true).is_none() {
                break;
            }
        }
    }

    /// Takes out the longest unused values for which `may_go` is true, until `size` is reached or
    /// no such value is left.
    pub(super) fn evict(&mut self, size: u64, may_go: impl Fn(&V) -> bool) -> Vec<V> {
        let (mut gone, mut freed) = (Vec::new(), 0u64);
        // At least one: sizes are estimates.
        while let Some(entry) = self.pop(&may_go) {
            freed = freed.saturating_add(entry.size);
            gone.push(entry.value);
            if freed >= size {
                break;
            }
        }
        gone
    }

    fn pop(&mut self, may_go: impl Fn(&V) -> bool) -> Option<Entry<V>> {
        let candidates = self.entries.iter().filter(|(_, e)| may_go(&e.value));
        let oldest = candidates.min_by_key(|(_, e)| e.used).map(|(k, _)| *k)?;
        self.entries.remove(&oldest)
    }

    /// All keys, the most recently used first.
    pub(super) fn keys(&self) -> Vec<K> {
        let mut keys: Vec<_> = self.entries.iter().map(|(k, e)| (e.used, *k)).collect();
        keys.sort_by_key(|(used, _)| std::cmp::Reverse(*used));
        keys.into_iter().map(|(_, k)| k).collect()
    }

    fn is_over(&self) -> bool {
        let size: u64 = self.entries.values().map(|e| e.size).sum();
        self.entries.len() > self.max_entries || size > self.max_size
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_longest_unused_goes_first() {
        let mut lru = Lru::new(2, 100);
        lru.insert(1, 'a', 1);
        lru.insert(2, 'b', 1);
        assert_eq!(lru.get(&1), Some('a'));
        lru.insert(3, 'c', 1);
        assert_eq!((lru.get(&1), lru.get(&2), lru.get(&3)), (Some('a'), None, Some('c')));
        assert_eq!(lru.keys(), [3, 1]);
    }

    #[test]
    fn size_counts_but_the_newest_stays() {
        let mut lru = Lru::new(10, 100);
        lru.insert(1, 'a', 60);
        lru.insert(2, 'b', 500);
        assert_eq!(lru.keys(), [2]);
    }

    #[test]
    fn eviction_frees_enough_and_spares_what_must_stay() {
        let mut lru = Lru::new(10, 1000);
        for (key, value) in [(1, 'a'), (2, 'b'), (3, 'c'), (4, 'd')] {
            lru.insert(key, value, 10);
        }
        assert_eq!(lru.evict(0, |_| true), ['a']);
        assert_eq!(lru.evict(15, |v| *v != 'b'), ['c', 'd']);
        assert_eq!(lru.keys(), [2]);
        assert_eq!(lru.evict(u64::MAX, |v| *v != 'b'), []);
        assert_eq!(lru.evict(u64::MAX, |_| true), ['b']);
    }
}
