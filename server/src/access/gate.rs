//! The identity of a caller, from what its request shows.

use axum::http::HeaderMap;
use bendtwin_core::{Category, Fault};
use bendtwin_store::Store;

use super::{Caller, InFlight, KeyRing, key, refusals::Refusals};
use crate::{
    client_token::{self, ClientToken},
    error::Refusal,
};

/// Token and keys that requests are compared with.
#[derive(Clone, Debug)]
pub(crate) struct Gate {
    /// None if everyone may call.
    token: Option<ClientToken>,
    keys: KeyRing,
    store: Store,
    in_flight: InFlight,
    refusals: Refusals,
}

impl Gate {
    pub(crate) fn new(token: Option<&str>, keys: KeyRing, store: Store) -> Self {
        let (token, in_flight) = (token.map(ClientToken::new), InFlight::default());
        Self { token, keys, store, in_flight, refusals: Refusals::default() }
    }

    /// The caller, by the client token or the key that the request shows.
    pub(crate) async fn identify(&self, headers: &HeaderMap) -> Result<Caller, Refusal> {
        let caller = self.shown_by(headers).await?;
        Ok(Caller { refusals: self.refusals.clone(), ..caller })
    }

    async fn shown_by(&self, headers: &HeaderMap) -> Result<Caller, Refusal> {
        let Some(token) = &self.token else { return Ok(Caller::anyone()) };
        let shown = client_token::shown(headers)
            .ok_or_else(|| client_token::refusal("the client token or key is missing"))?;
        if token.matches(&shown) {
            return Ok(Caller::with_token());
        }
        let shown = key::read(&shown).map_err(|fault| {
            client_token::refusal(match fault {
                key::Unreadable::Other => "the client token is wrong",
                key::Unreadable::Mistyped => {
                    "the key is mistyped: letters of it are missing or others"
                }
            })
        })?;
        // Hashes are compared, which takes the same time wherever they differ.
        let found = self.keys.find(shown.id).await?.filter(|key| key.hash == shown.hash);
        let found = found.ok_or_else(|| client_token::refusal("the key is not known here"))?;
        if found.revoked.is_some() {
            let what = format!("{} was revoked", found.id);
            return Err(refused(Category::Unauthenticated, "KEY_REVOKED", what));
        }
        if let Some(end) = found.expires.filter(|end| *end <= self.store.now()) {
            let what = format!("{} expired at {end:.0}", found.id);
            return Err(refused(Category::Unauthenticated, "KEY_EXPIRED", what));
        }
        self.keys.note_use(&found);
        Ok(Caller::with_key(&found, self.in_flight.clone()))
    }
}

fn refused(category: Category, reason: &str, what: String) -> Refusal {
    Refusal::new(Fault {
        category,
        reason: reason.to_owned(),
        message: format!("{what}: have another key made with `bendtwin key create`"),
    })
}
