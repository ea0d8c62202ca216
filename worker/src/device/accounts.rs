//! Accounts of requests: the owners for whom a device computes, who take turns at it.

use std::{
    collections::HashMap,
    sync::{Arc, Mutex, PoisonError, Weak},
};

use super::turns::Standing;

/// Number of accounts from which those without requests are forgotten.
const MANY: usize = 64;

/// The owner of a request, as the server names it in [`ACCOUNT`](bendtwin_contract::rollout::ACCOUNT).
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(crate) struct Account(Arc<str>);

impl Account {
    /// The account of this name.
    pub(crate) fn new(name: &str) -> Self {
        Self(name.into())
    }
}

/// Accounts with requests under way.
#[derive(Debug, Default)]
pub(super) struct Accounts(Mutex<HashMap<Account, Weak<Standing>>>);

impl Accounts {
    /// Turns of an account, which last as long as something holds them.
    pub(super) fn standing(&self, account: &Account) -> Arc<Standing> {
        let mut known = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(standing) = known.get(account).and_then(Weak::upgrade) {
            return standing;
        }
        if known.len() >= MANY {
            known.retain(|_, standing| standing.strong_count() > 0);
        }
        let standing = Arc::default();
        known.insert(account.clone(), Arc::downgrade(&standing));
        standing
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_account_has_one_standing_while_it_has_requests() {
        let accounts = Accounts::default();
        let ada = accounts.standing(&Account::new("ada"));
        assert!(Arc::ptr_eq(&ada, &accounts.standing(&Account::new("ada"))));
        assert!(!Arc::ptr_eq(&ada, &accounts.standing(&Account::new("bob"))));
        for name in 0..10 * MANY {
            accounts.standing(&Account::new(&name.to_string()));
        }
        assert!(accounts.0.lock().unwrap().len() <= MANY);
        assert!(Arc::ptr_eq(&ada, &accounts.standing(&Account::new("ada"))));
    }
}
