//! Keys of clients: made, listed, revoked. `access` decides what they allow, `usage` tells what their
//! owners have.

pub(super) mod usage;

mod sign_ins;

use std::time::Duration;

use bendtwin_core::{Category, Problem as _, ids::KeyId};
use bendtwin_store::{Key, NewKey, Page, PageRequest, Quotas};
use jiff::Timestamp;
use tokio::time::MissedTickBehavior;

use super::{App, Error, Result, labels};
use crate::{
    access::{Ended, Grant, MOST_PRIORITY, Scope, key},
    audit,
    context::Context,
};

pub(crate) use sign_ins::WhoAmI;

/// Interval at which the key of a long call is checked.
const CHECK_INTERVAL: Duration = Duration::from_secs(2);

/// A requested key.
#[derive(Clone, Debug, Default)]
pub(crate) struct KeyOrder {
    pub(crate) display_name: String,
    /// Empty means the display name.
    pub(crate) owner: String,
    pub(crate) scopes: Vec<String>,
    pub(crate) expires: Option<Timestamp>,
    pub(crate) quotas: Quotas,
}

impl App {
    /// Makes a key. Its text is returned here and nowhere else.
    pub(crate) async fn create_key(&self, order: KeyOrder) -> Result<(Key, String)> {
        let done: Result<(Key, String)> = async {
            let KeyOrder { display_name, owner, scopes, expires, quotas } = order;
            let display_name = labels::display_name(display_name)?;
            if display_name.trim().is_empty() {
                return Err(Error::invalid("display_name", "is empty: say whose key it is"));
            }
            let owner = labels::owner(if owner.is_empty() { display_name.clone() } else { owner })?;
            check_scopes(&scopes)?;
            check_quotas(&quotas)?;
            if expires.is_some_and(|end| end <= self.store.now()) {
                return Err(Error::invalid("expire_time", "is past: choose a later time"));
            }
            self.require_room(0)?;
            let made = key::make().map_err(|e| Error::Internal(format!("random numbers: {e}")))?;
            let new = NewKey {
                id: made.id,
                display_name,
                owner,
                hash: made.hash,
                scopes,
                quotas,
                expires,
                signed_in_as: None,
            };
            let store = self.store.clone();
            let key = self.change(async move { store.keys().create(new).await }).await?;
            self.keys.learn(&key);
            tracing::info!(key = %key.id, owner = key.owner, "key made");
            Ok((key, made.text))
        }
        .await;
        audit::made("CreateKey", &done, |(key, _)| key.id.to_string());
        done
    }

    pub(crate) async fn key(&self, name: &str) -> Result<Key> {
        Ok(self.store.keys().get(super::name(name)?).await?)
    }

    pub(crate) async fn list_keys(&self, page: &PageRequest) -> Result<Page<Key>> {
        Ok(self.store.keys().list(page).await?)
    }

    /// Revokes a key, and the shares that were made with it.
    pub(crate) async fn revoke_key(&self, name: &str) -> Result<()> {
        let done: Result<()> = async {
            let (id, store) = (super::name(name)?, self.store.clone());
            let revoked =
                self.change(async move { store.keys().revoke_with_shares(id).await }).await?;
            for key in &revoked {
                self.keys.learn(key);
                tracing::info!(key = %key.id, owner = key.owner, "key revoked");
            }
            Ok(())
        }
        .await;
        audit::changed("DeleteKey", name, &done);
        done
    }

    /// Waits until the key of the caller has ended, or the twin that it is limited to is gone; for ever
    /// if it has none. What cannot be found out now, since the database does not answer, ends nothing.
    pub(crate) async fn key_ended(&self) -> Error {
        let caller = Context::current().caller;
        let Some(id) = caller.key else { return std::future::pending().await };
        let mut tick = tokio::time::interval(CHECK_INTERVAL);
        tick.set_missed_tick_behavior(MissedTickBehavior::Delay);
        loop {
            tick.tick().await;
            if let Ok(Some(holder)) = self.keys.find(id).await
                && let Some(ended) = Ended::of(&holder.key, self.store.now())
            {
                return ended.into();
            }
            if let Some(share) = caller.share
                && let Err(error) = self.store.twins().get(share.twin).await
                && error.category() == Category::NotFound
            {
                return error.into();
            }
        }
    }

    /// Revokes a key, here immediately, and at other servers once they read it again.
    pub(super) async fn revoke(&self, id: KeyId) -> Result<Key> {
        let store = self.store.clone();
        let key = self.change(async move { store.keys().revoke(id).await }).await?;
        self.keys.learn(&key);
        Ok(key)
    }
}

fn check_quotas(quotas: &Quotas) -> Result<()> {
    if quotas.running_jobs == Some(0) {
        let fault = "is 0, with which no job would ever run: give at least 1";
        return Err(Error::invalid("quotas.running_jobs", fault));
    }
    if quotas.fit_run_s == Some(0) {
        return Err(Error::invalid("quotas.fit_run_s", "is 0: give at least 1"));
    }
    match quotas.priority {
        Some(priority) if priority > MOST_PRIORITY => {
            let fault = format!("is {priority}: use 0..={MOST_PRIORITY}");
            Err(Error::invalid("quotas.priority", fault))
        }
        _ => Ok(()),
    }
}

fn check_scopes(scopes: &[String]) -> Result<()> {
    let words = || {
        let words = Scope::ALL.map(Scope::as_str).join(", ");
        format!("{words}; {}", Grant::CONFINED)
    };
    if scopes.is_empty() {
        return Err(Error::invalid("scopes", format!("is empty: name some of {}", words())));
    }
    match scopes.iter().find(|word| Grant::parse(word).is_none()) {
        None => Ok(()),
        Some(word) => {
            let word: String = word.chars().take(40).collect();
            Err(Error::invalid("scopes", format!("has `{word}`, which is not one of {}", words())))
        }
    }
}
