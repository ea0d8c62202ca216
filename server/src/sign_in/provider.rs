//! What the provider states about itself: its endpoints and its keys. Both are read when they are
//! first needed, kept for an hour, and used for a day if the provider is away. Keys are read again
//! for a key that is not among them, but not more than once a minute.

use std::{
    sync::{Arc, PoisonError, RwLock},
    time::Duration,
};

use axum::http::StatusCode;
use jsonwebtoken::jwk::Jwk;
use serde::{Deserialize, de::DeserializeOwned};
use tokio::{sync::Mutex, time::Instant};
use url::{Host, Url};

use super::{
    error::{Error, plain},
    http::Http,
};
use crate::options::is_protected;

/// Time for which what was read counts.
const FRESH: Duration = Duration::from_secs(3600);
/// Time for which it does while the provider is away.
const STALE: Duration = Duration::from_secs(86_400);
/// Time after a failure in which the provider is not asked again.
const PAUSE: Duration = Duration::from_secs(5);
/// Least time between two readings of keys because of a key that is not known.
const UNKNOWN_KEY_INTERVAL: Duration = Duration::from_secs(60);
const DISCOVERY: &str = "a discovery document";
/// Most keys that are kept.
const MOST_KEYS: usize = 100;

/// The parts of the discovery document that are used.
#[derive(Clone, Debug, Deserialize)]
pub(super) struct Metadata {
    pub(super) issuer: String,
    pub(super) authorization_endpoint: String,
    pub(super) token_endpoint: String,
    pub(super) jwks_uri: String,
    pub(super) device_authorization_endpoint: Option<String>,
    pub(super) userinfo_endpoint: Option<String>,
    #[serde(default)]
    pub(super) token_endpoint_auth_methods_supported: Vec<String>,
}

/// A provider, and what is known of it.
#[derive(Debug)]
pub(super) struct Provider {
    issuer: String,
    pub(super) http: Http,
    known: RwLock<Option<Known>>,
    /// Held while the provider is asked: others wait for that answer.
    state: Mutex<State>,
}

#[derive(Debug, Default)]
struct State {
    failed: Option<(Instant, Error)>,
    /// Last reading of keys because of a key that was not known.
    looked_up: Option<Instant>,
}

impl State {
    /// The last failure, while the provider is not asked again because of it.
    fn recent_failure(&self) -> Option<&Error> {
        self.failed.as_ref().filter(|(at, _)| at.elapsed() < PAUSE).map(|(_, error)| error)
    }
}

/// What was read.
#[derive(Clone, Debug)]
pub(super) struct Known {
    pub(super) metadata: Arc<Metadata>,
    pub(super) keys: Arc<Vec<Jwk>>,
    read: Instant,
}

#[derive(Deserialize)]
struct KeyList {
    keys: Vec<serde_json::Value>,
}

impl Provider {
    pub(super) fn new(issuer: &str, http: Http) -> Self {
        let (known, state) = (RwLock::default(), Mutex::default());
        Self { issuer: issuer.to_owned(), http, known, state }
    }

    /// Endpoints and keys, if they are known well enough to be used without asking.
    pub(super) fn cached(&self) -> Option<Known> {
        self.younger_than(FRESH)
    }

    fn younger_than(&self, age: Duration) -> Option<Known> {
        let known = self.known.read().unwrap_or_else(PoisonError::into_inner);
        known.clone().filter(|known| known.read.elapsed() < age)
    }

    fn keep(&self, known: &Known) {
        let mut kept = self.known.write().unwrap_or_else(PoisonError::into_inner);
        *kept = Some(known.clone());
    }

    /// Endpoints and keys.
    pub(super) async fn known(&self) -> Result<Known, Error> {
        if let Some(known) = self.cached() {
            return Ok(known);
        }
        let mut state = self.state.lock().await;
        if let Some(known) = self.cached() {
            return Ok(known);
        }
        if let Some(error) = state.recent_failure() {
            return self.younger_than(STALE).ok_or_else(|| error.clone());
        }
        match self.read().await {
            Ok(known) => {
                *state = State::default();
                self.keep(&known);
                Ok(known)
            }
            Err(error) => {
                tracing::warn!(issuer = self.issuer, %error, "the identity provider cannot be used");
                state.failed = Some((Instant::now(), error.clone()));
                self.younger_than(STALE).ok_or(error)
            }
        }
    }

    /// The keys, read again if that was not done lately: a key that signed something is not among
    /// those that are known.
    pub(super) async fn newer_keys(&self) -> Result<Arc<Vec<Jwk>>, Error> {
        let mut state = self.state.lock().await;
        let Some(known) = self.younger_than(STALE) else { return Ok(Arc::default()) };
        if state.looked_up.is_some_and(|at| at.elapsed() < UNKNOWN_KEY_INTERVAL) {
            return Ok(known.keys);
        }
        if let Some(error) = state.recent_failure() {
            return Err(error.clone());
        }
        // Only a reading that succeeds defers the next one.
        let keys = match self.read_keys(&known.metadata.jwks_uri).await {
            Ok(keys) => Arc::new(keys),
            Err(error) => {
                state.failed = Some((Instant::now(), error.clone()));
                return Err(error);
            }
        };
        state.looked_up = Some(Instant::now());
        self.keep(&Known { keys: keys.clone(), ..known });
        Ok(keys)
    }

    async fn read(&self) -> Result<Known, Error> {
        let url = format!("{}/.well-known/openid-configuration", self.issuer.trim_end_matches('/'));
        let metadata: Metadata = self.document(&url, DISCOVERY).await?;
        let unusable = |fault: String| Error::Unusable { what: DISCOVERY, fault };
        if metadata.issuer != self.issuer {
            return Err(unusable(format!(
                "its issuer is `{}`, not `{}`",
                plain(&metadata.issuer),
                self.issuer
            )));
        }
        let required =
            [&metadata.authorization_endpoint, &metadata.token_endpoint, &metadata.jwks_uri];
        let optional = [&metadata.device_authorization_endpoint, &metadata.userinfo_endpoint];
        let endpoints = required.into_iter().chain(optional.into_iter().flatten());
        for endpoint in endpoints {
            if !self.trusts(endpoint) {
                return Err(unusable(format!(
                    "`{}` is not an https:// address with a name, or is on this machine",
                    plain(endpoint)
                )));
            }
        }
        let keys = self.read_keys(&metadata.jwks_uri).await?;
        let (metadata, keys) = (Arc::new(metadata), Arc::new(keys));
        Ok(Known { metadata, keys, read: Instant::now() })
    }

    /// True for an address that is reached as safely as the issuer.
    pub(super) fn trusts(&self, address: &str) -> bool {
        is_trusted(address, &self.issuer)
    }

    async fn read_keys(&self, url: &str) -> Result<Vec<Jwk>, Error> {
        let list: KeyList = self.document(url, "keys").await?;
        // Kinds of keys that are not known here are left out.
        let known = list.keys.into_iter().filter_map(|key| serde_json::from_value(key).ok());
        Ok(known.take(MOST_KEYS).collect())
    }

    async fn document<T: DeserializeOwned>(
        &self,
        url: &str,
        what: &'static str,
    ) -> Result<T, Error> {
        let answer = self.http.get(url, None).await?;
        if answer.status != StatusCode::OK {
            let status = answer.status.as_u16();
            if answer.status == StatusCode::NOT_FOUND && what == DISCOVERY {
                let fault = format!("{url} does not exist: compare sign_in.issuer");
                return Err(Error::Unusable { what, fault });
            }
            return Err(Error::Away(format!("it answers {status} when asked for {what}")));
        }
        serde_json::from_slice(&answer.body)
            .map_err(|e| Error::Unusable { what, fault: plain(&e.to_string()) })
    }
}

/// True for an endpoint that is reached as safely as the issuer: at the issuer's own address, or at
/// another host that has to prove its name. Large providers have their endpoints at several hosts. An
/// address without a name, or of this machine, could be that of a service that trusts this server.
fn is_trusted(endpoint: &str, issuer: &str) -> bool {
    let (Ok(mut url), Ok(issuer)) = (Url::parse(endpoint), Url::parse(issuer)) else {
        return false;
    };
    // Some providers have a query in their endpoints.
    url.set_query(None);
    let is_named = match url.host() {
        Some(Host::Domain(name)) => name != "localhost" && !name.ends_with(".localhost"),
        _ => false,
    };
    is_protected(&url) && (url.origin() == issuer.origin() || (url.scheme() == "https" && is_named))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn endpoints_are_at_the_issuer_or_at_hosts_with_names() {
        let public = "https://id.example/realms/lab";
        for endpoint in [
            "https://id.example/token",
            "https://id.example/token?tenant=1",
            "https://tokens.example:8443/token",
        ] {
            assert!(is_trusted(endpoint, public), "{endpoint}");
        }
        for endpoint in [
            "http://id.example/token",
            "http://127.0.0.1:7070/token",
            "http://localhost/token",
            "https://localhost/token",
            "https://a.localhost/token",
            "https://127.0.0.1/token",
            "https://169.254.169.254/latest",
            "https://[::1]/token",
            "https://2130706433/token",
            "https://user:password@id.example/token",
            "https://id.example/token#part",
            "javascript:alert(1)",
            "file:///etc/passwd",
            "//id.example/token",
            "",
        ] {
            assert!(!is_trusted(endpoint, public), "{endpoint}");
        }
        // Addresses without a name are the operator's choice.
        let own = "https://10.0.0.7:8443/realms/lab";
        assert!(is_trusted("https://10.0.0.7:8443/token", own));
        assert!(!is_trusted("https://10.0.0.7/token", own));
        let local = "http://127.0.0.1:9000";
        assert!(is_trusted("http://127.0.0.1:9000/token", local));
        assert!(!is_trusted("http://127.0.0.1:9001/token", local));
        assert!(!is_trusted("http://localhost:9000/token", local));
    }
}
