//! The identity of a caller, from what its request shows.

use std::time::Instant;

use axum::http::HeaderMap;
use bendtwin_core::Problem as _;
use bendtwin_store::Store;

use super::{
    Caller, Ended, InFlight, KeyRing,
    client_token::{self, ClientToken},
    key,
    refusals::{Refusals, Refused},
};
use crate::{audit, context::Context, refusal::Refusal};

/// Token and keys that requests are compared with.
#[derive(Clone, Debug)]
pub(crate) struct Gate {
    /// `None` if everyone may call.
    token: Option<ClientToken>,
    keys: KeyRing,
    store: Store,
    in_flight: InFlight,
    refusals: Refusals,
    /// Refusals of those who show no key of this server's.
    strangers: Refusals,
}

impl Gate {
    pub(crate) fn new(token: Option<&str>, keys: KeyRing, store: Store) -> Self {
        let (token, in_flight) = (token.map(ClientToken::new), InFlight::default());
        let (refusals, strangers) = (Refusals::default(), Refusals::default());
        Self { token, keys, store, in_flight, refusals, strangers }
    }

    /// The caller, by the client token or the key that the request shows.
    pub(crate) async fn identify(&self, headers: &HeaderMap) -> Result<Caller, Refusal> {
        match self.shown_by(headers).await {
            Ok(caller) => Ok(Caller { refusals: self.refusals.clone(), ..caller }),
            Err(denial) => {
                self.note(&denial);
                Err(denial.refusal)
            }
        }
    }

    async fn shown_by(&self, headers: &HeaderMap) -> Result<Caller, Denial> {
        let Some(token) = &self.token else { return Ok(Caller::anyone()) };
        let shown = client_token::shown(headers)
            .ok_or_else(|| client_token::refusal("the client token or key is missing"))?;
        if token.matches(&shown) {
            return Ok(Caller::with_token());
        }
        let shown = key::read(&shown).map_err(|fault| {
            Denial::of_stranger(match fault {
                key::Unreadable::Other => "the client token is wrong",
                key::Unreadable::Mistyped => {
                    "the key is mistyped: letters of it are missing or others"
                }
            })
        })?;
        // Hashes are compared, which takes the same time wherever they differ.
        let found = self.keys.find(shown.id).await.map_err(Refusal::from)?;
        let found = found.filter(|holder| holder.key.hash == shown.hash);
        let found = found.ok_or_else(|| Denial::of_stranger("the key is not known here"))?;
        let caller = Caller::with_key(&found, self.in_flight.clone());
        let found = found.key;
        if let Some(ended) = Ended::of(&found, self.store.now()) {
            return Err(Denial { refusal: Refusal::new(ended.fault()), of: Some(caller) });
        }
        self.keys.note_use(&found);
        Ok(caller)
    }

    /// Reports it to the audit, unless that was done recently. Requests without credentials are not
    /// reported: every browser begins with one.
    fn note(&self, denial: &Denial) {
        let Some(caller) = &denial.of else { return };
        // Strangers are remembered by themselves, so that however many there are they take no place
        // of a key.
        let (refusals, refused) = match caller.key {
            None => (&self.strangers, Refused::Stranger(Context::current().network)),
            key => (&self.refusals, Refused::Holder(key)),
        };
        let reason = denial.refusal.reason();
        if let Some(times) = refusals.note(refused, reason, Instant::now()) {
            audit::not_admitted(caller, reason, times);
        }
    }
}

/// Refusal of a request for what it shows, or does not.
struct Denial {
    refusal: Refusal,
    /// Sender of an invalid key, or of something that is no key; `None` if nothing was sent.
    of: Option<Caller>,
}

impl Denial {
    fn of_stranger(fault: &str) -> Self {
        Self { refusal: client_token::refusal(fault), of: Some(Caller::default()) }
    }
}

impl From<Refusal> for Denial {
    fn from(refusal: Refusal) -> Self {
        Self { refusal, of: None }
    }
}

#[cfg(test)]
mod tests;
