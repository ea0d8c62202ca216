//! Calls under way of owners whose keys bound them.

use std::{
    collections::HashMap,
    sync::{Arc, Mutex, PoisonError},
    time::Duration,
};

use bendtwin_core::{Category, Fault};

use crate::refusal::Refusal;

/// Counts by owner. Clones share them.
#[derive(Clone, Debug, Default)]
pub(crate) struct InFlight(Arc<Mutex<HashMap<Arc<str>, u64>>>);

/// A call under way, counted until it is dropped.
#[derive(Debug)]
pub(crate) struct Flight {
    all: InFlight,
    owner: Arc<str>,
}

impl InFlight {
    /// Counts one more call of an owner.
    ///
    /// # Errors
    /// If there are `limit` already.
    pub(super) fn enter(&self, owner: &Arc<str>, limit: u64) -> Result<Flight, Refusal> {
        self.count(owner, limit).ok_or_else(|| {
            let refusal = Refusal::new(Fault {
                category: Category::ResourceExhausted,
                reason: "QUOTA_ROLLOUTS".to_owned(),
                message: format!(
                    "{limit} rollouts of {owner} are under way, which is what its key allows: wait \
                     for one to end"
                ),
            });
            refusal.retry_after(Some(Duration::from_secs(1)))
        })
    }

    /// Counts one more of an owner; none if there are `limit` already.
    pub(crate) fn count(&self, owner: &Arc<str>, limit: u64) -> Option<Flight> {
        let mut counts = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let count = counts.get(owner).copied().unwrap_or_default();
        if count >= limit {
            return None;
        }
        counts.insert(owner.clone(), count + 1);
        Some(Flight { all: self.clone(), owner: owner.clone() })
    }
}

impl Drop for Flight {
    fn drop(&mut self) {
        let mut counts = self.all.0.lock().unwrap_or_else(PoisonError::into_inner);
        match counts.get_mut(&self.owner) {
            Some(count) if *count > 1 => *count -= 1,
            _ => drop(counts.remove(&self.owner)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn owners_have_as_many_calls_as_their_keys_allow() {
        let (all, ada, bob) = (InFlight::default(), "ada".into(), "bob".into());
        let first = all.enter(&ada, 2).unwrap();
        let _second = all.enter(&ada, 2).unwrap();
        assert!(all.enter(&ada, 2).is_err());
        let _other = all.enter(&bob, 1).unwrap();
        drop(first);
        drop(all.enter(&ada, 2).unwrap());
        assert!(all.enter(&bob, 0).is_err());
        assert_eq!(all.0.lock().unwrap().len(), 2);
    }
}
