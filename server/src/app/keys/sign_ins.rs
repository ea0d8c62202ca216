//! Sign-in of people: what `sign_in` finds out about a person becomes a key that ends by itself.

use std::time::{Duration, Instant};

use bendtwin_core::Problem as _;
use bendtwin_store::{Key, NewKey};
use jiff::{SignedDuration, Timestamp};

use crate::{
    access::{Refused, Scope, key},
    app::{App, Error, Result, labels},
    audit,
    context::Context,
    options,
    sign_in::{self, Challenge, Device, Proof, SignIn},
};

/// Time for which an ended sign-in or share is kept, so that its holder learns that it has ended.
const REMEMBERED: Duration = Duration::from_secs(30 * 86_400);

/// The caller, as people ask for it.
#[derive(Clone, Debug)]
pub(crate) struct WhoAmI {
    pub(crate) owner: String,
    pub(crate) scopes: Vec<String>,
    /// Key of the caller; `None` with the client token, or where nothing is required.
    pub(crate) key: Option<Key>,
}

impl App {
    /// Options of the identity provider, if people can sign in.
    pub(crate) fn sign_in_options(&self) -> Option<&options::SignIn> {
        self.sign_in.as_ref().map(SignIn::options)
    }

    /// The address of the provider for a browser.
    pub(crate) async fn start_sign_in(&self, challenge: &Challenge) -> Result<String> {
        let sign_in = self.provider()?;
        if !challenge.is_well_formed() {
            let fault = "are to be 43 characters of base64url each";
            return Err(Error::invalid("state, nonce and code_challenge", fault));
        }
        Ok(sign_in.address(challenge).await.inspect_err(|error| self.warn(error))?)
    }

    /// Begins the sign-in of a device.
    pub(crate) async fn start_device_sign_in(&self) -> Result<Device> {
        Ok(self.provider()?.begin_device().await.inspect_err(|error| self.warn(error))?)
    }

    /// Signs a person in. The text of their key is returned here and nowhere else.
    pub(crate) async fn create_sign_in(&self, proof: Proof) -> Result<(Key, String)> {
        let sign_in = self.provider()?;
        if !proof.is_well_formed() {
            let fault = "is not what a browser or a device has: send code, code_verifier and \
                         nonce, or device_code";
            return Err(Error::invalid("body", fault));
        }
        self.require_room(0)?;
        let done: Result<(Key, String)> = async {
            let person = sign_in.person(&proof).await.inspect_err(|error| self.warn(error))?;
            let made = key::make().map_err(|e| Error::Internal(format!("random numbers: {e}")))?;
            let new = NewKey {
                id: made.id,
                display_name: "sign-in".to_owned(),
                owner: labels::owner(person.owner)?,
                hash: made.hash,
                scopes: person.scopes,
                quotas: sign_in.options().quotas.to_store(),
                expires: Some(later(self.store.now(), sign_in.options().session())),
                signed_in_as: Some(person.id),
            };
            let store = self.store.clone();
            let done = self.change(async move { store.keys().sign_in(new).await }).await?;
            self.keys.learn(&done.key);
            for ended in &done.ended {
                self.keys.learn(ended);
            }
            tracing::info!(key = %done.key.id, owner = done.key.owner, "signed in");
            Ok((done.key, made.text))
        }
        .await;
        if let Some(times) = self.audited(&done) {
            let name = |(key, _): &(Key, String)| format!("{} of {}", key.id, key.owner);
            audit::signed_in("CreateSignIn", &done, times, name);
        }
        done
    }

    /// Signs the caller out: revokes the key of a sign-in. Other keys stay valid, and so do the shares
    /// that the person has made.
    pub(crate) async fn delete_sign_in(&self) -> Result<()> {
        let Some(id) = Context::current().caller.key else { return Ok(()) };
        if self.store.keys().get(id).await?.signed_in_as.is_none() {
            return Ok(());
        }
        let done: Result<()> = async {
            let key = self.revoke(id).await?;
            tracing::info!(key = %key.id, owner = key.owner, "signed out");
            Ok(())
        }
        .await;
        audit::changed("DeleteSignIn", id, &done);
        done
    }

    /// The caller of this request.
    pub(crate) async fn who_am_i(&self) -> Result<WhoAmI> {
        let caller = Context::current().caller;
        let key = match caller.key {
            Some(id) => Some(self.store.keys().get(id).await?),
            None => None,
        };
        let all = || Scope::ALL.map(|scope| scope.as_str().to_owned()).into();
        let scopes = key.as_ref().map_or_else(all, |key| key.scopes.clone());
        // Visitors do not learn who has invited them.
        let owner = if caller.share.is_some() { "" } else { &*caller.owner };
        Ok(WhoAmI { owner: owner.to_owned(), scopes, key })
    }

    /// Deletes sign-ins and shares that ended long ago.
    pub(in crate::app) async fn forget_ended_keys(&self) -> Result<()> {
        let before = self.store.now() - REMEMBERED;
        let forgotten = self.store.keys().forget_ended(before).await?;
        if forgotten > 0 {
            tracing::info!(forgotten, "sign-ins and shares that had ended are removed");
        }
        Ok(())
    }

    fn provider(&self) -> Result<&SignIn> {
        self.sign_in.as_ref().ok_or_else(|| sign_in::Error::Off.into())
    }

    /// The number of equal sign-ins since the last line of the audit, if there is to be another one.
    /// Anyone can cause refusals without end, so they are condensed. Those beyond the rate, which are
    /// not even looked at, and devices that wait for their person are left out.
    fn audited<T>(&self, done: &Result<T>) -> Option<u64> {
        use sign_in::Error as E;
        match done {
            Ok(_) => Some(1),
            Err(Error::SignIn(E::Pending { .. } | E::SlowDown { .. } | E::Busy)) => None,
            Err(error) => self.refused_sign_ins.note(
                Refused::Stranger(Context::current().network),
                error.reason(),
                Instant::now(),
            ),
        }
    }

    /// Says in the log why a sign-in failed: once for a reason and a network, and after that not more
    /// than every ten minutes. What people do wrong is in the audit, with the reason alone.
    fn warn(&self, error: &sign_in::Error) {
        use sign_in::Error as E;
        if matches!(error, E::Pending { .. } | E::SlowDown { .. } | E::Off) {
            return;
        }
        let network = Context::current().network;
        let reason = error.reason();
        // The fault of a provider is the same for all networks.
        let of = match error {
            E::Away(_) | E::Unusable { .. } | E::Client(_) | E::NoDevices => None,
            _ => network,
        };
        let noted = self.failed_sign_ins.note(Refused::Stranger(of), reason, Instant::now());
        if let Some(times) = noted {
            let client = network.map(|network| network.to_string()).unwrap_or_default();
            tracing::warn!(reason, %error, client, times, "a sign-in failed");
        }
    }
}

fn later(now: Timestamp, by: Duration) -> Timestamp {
    let by = SignedDuration::try_from(by).unwrap_or(SignedDuration::MAX);
    now.saturating_add(by).unwrap_or(Timestamp::MAX)
}
