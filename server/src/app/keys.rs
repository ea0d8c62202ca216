//! Keys of clients: made, listed, revoked. `access` decides what they allow, `usage` tells what their
//! owners have.

pub(super) mod usage;

mod sign_ins;

use bendtwin_core::ids::KeyId;
use bendtwin_store::{Key, NewKey, Page, PageRequest, Quotas};
use jiff::Timestamp;

use super::{App, Error, Result, labels};
use crate::{
    access::{Grant, MOST_PRIORITY, Scope, key},
    audit,
};

pub(crate) use sign_ins::WhoAmI;

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

    pub(crate) async fn revoke_key(&self, name: &str) -> Result<()> {
        let done: Result<()> = async {
            let key = self.revoke(super::name(name)?).await?;
            tracing::info!(key = %key.id, owner = key.owner, "key revoked");
            Ok(())
        }
        .await;
        audit::changed("DeleteKey", name, &done);
        done
    }

    /// Revokes a key, here immediately, and at other servers once they read it again.
    async fn revoke(&self, id: KeyId) -> Result<Key> {
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
