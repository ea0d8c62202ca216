//! Sign-in of people with the identity provider of their organisation: OpenID Connect 1.0, by the code
//! of a browser (with PKCE) or of a device (RFC 8628). The server keeps nothing of a sign-in that has
//! begun: the browser has its state, nonce and verifier, a device its code. So any server of a fleet
//! ends what another began, and nobody fills the memory (docs/adr/0057).
//!
//! The outcome is a [`Person`]; `app/keys/sign_ins.rs` makes a key for them.

mod calls;
mod error;
mod http;
mod id_token;
mod person;
mod provider;
mod rate;
mod signatures;

use std::{
    sync::Arc,
    time::{Duration, Instant},
};

use axum::http::{HeaderValue, StatusCode};
use base64::{Engine as _, prelude::BASE64_STANDARD};
use serde::{Deserialize, de::DeserializeOwned};
use url::{Url, form_urlencoded};

use self::{
    calls::{Call, Calls},
    error::{MORE, plain, shown},
    http::Http,
    id_token::{Claims, Expected},
    provider::{Metadata, Provider},
    rate::Rate,
};
use crate::{
    context::Context,
    options::{SignIn as Options, is_local},
    service::StartError,
};

pub(crate) use error::Error;
pub(crate) use person::Person;

/// Delay between two questions whether a device is confirmed, if the provider states none.
const INTERVAL: Duration = Duration::from_secs(5);
/// Longest time for which a device may wait for its person [s].
const LONGEST_WAIT_S: f64 = 3600.0;
/// Longest code of a browser or a device [bytes].
const LONGEST_CODE: usize = 4096;
const DEVICE_GRANT: &str = "urn:ietf:params:oauth:grant-type:device_code";

/// The sign-in of a server. Clones share it.
#[derive(Clone, Debug)]
pub(crate) struct SignIn(Arc<Inner>);

struct Inner {
    options: Options,
    secret: Option<String>,
    provider: Provider,
    /// Rate of what calls the provider, and of starts that do not.
    rate: Rate,
    starts: Rate,
    calls: Calls,
}

/// Leaves the secret out.
impl std::fmt::Debug for Inner {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("SignIn").field("issuer", &self.options.issuer).finish_non_exhaustive()
    }
}

/// What a browser made for its sign-in.
#[derive(Clone, Debug)]
pub(crate) struct Challenge {
    pub(crate) state: String,
    pub(crate) nonce: String,
    pub(crate) code_challenge: String,
}

/// What a browser or a device shows to be signed in.
#[derive(Clone, Debug)]
pub(crate) enum Proof {
    Browser { code: String, code_verifier: String, nonce: String },
    Device { code: String },
}

/// A sign-in of a device that has begun (RFC 8628, 3.2).
#[derive(Clone, Debug, Deserialize)]
pub(crate) struct Device {
    pub(crate) device_code: String,
    pub(crate) user_code: String,
    #[serde(alias = "verification_url")]
    pub(crate) verification_uri: String,
    /// Some providers state it as null.
    #[serde(default)]
    pub(crate) verification_uri_complete: Option<String>,
    #[serde(default)]
    pub(crate) interval: Option<f64>,
    pub(crate) expires_in: f64,
}

#[derive(Deserialize)]
struct Tokens {
    id_token: Option<String>,
    access_token: Option<String>,
}

#[derive(Default, Deserialize)]
struct ProviderError {
    #[serde(default)]
    error: String,
    #[serde(default)]
    error_description: String,
}

impl SignIn {
    /// Reads the files that the options name. The provider is not asked yet.
    pub(crate) fn load(options: &Options) -> Result<Self, StartError> {
        signatures::install();
        let secret = options.client_secret_file.as_deref().map(|path| {
            let fault = |source| StartError::ClientSecret { path: path.to_owned(), source };
            read_secret(path).map_err(fault)
        });
        let has_tls = !Url::parse(&options.issuer).is_ok_and(|issuer| is_local(&issuer));
        let http = Http::new(options.ca.as_deref(), has_tls)?;
        Ok(Self(Arc::new(Inner {
            secret: secret.transpose()?,
            provider: Provider::new(&options.issuer, http),
            options: options.clone(),
            rate: Rate::new(rate::OF_CALLS),
            starts: Rate::new(rate::OF_STARTS),
            calls: Calls::default(),
        })))
    }

    pub(crate) fn options(&self) -> &Options {
        &self.0.options
    }

    /// The address of the provider for a browser.
    pub(crate) async fn address(&self, challenge: &Challenge) -> Result<String, Error> {
        let metadata = self.metadata_for_start().await?;
        let mut url = Url::parse(&metadata.authorization_endpoint)
            .map_err(|e| Error::Unusable { what: "an address", fault: e.to_string() })?;
        url.query_pairs_mut()
            .append_pair("response_type", "code")
            .append_pair("client_id", &self.0.options.client_id)
            .append_pair("redirect_uri", &self.0.options.redirect_uri())
            .append_pair("scope", &self.0.options.oidc_scopes.join(" "))
            .append_pair("state", &challenge.state)
            .append_pair("nonce", &challenge.nonce)
            .append_pair("code_challenge", &challenge.code_challenge)
            .append_pair("code_challenge_method", "S256");
        Ok(url.into())
    }

    /// Begins the sign-in of a device.
    pub(crate) async fn begin_device(&self) -> Result<Device, Error> {
        let _call = self.admit()?;
        let metadata = self.0.provider.known().await?.metadata;
        let Some(endpoint) = &metadata.device_authorization_endpoint else {
            return Err(Error::NoDevices);
        };
        let scopes = self.0.options.oidc_scopes.join(" ");
        let device: Device = self.ask(&metadata, endpoint, &[("scope", &scopes)]).await?;
        let trusts = |uri: &str| self.0.provider.trusts(uri);
        if !trusts(&device.verification_uri) {
            let fault = "its address for people is not https://".to_owned();
            return Err(Error::Unusable { what: "a code for a device", fault });
        }
        let complete = device.verification_uri_complete.filter(|uri| trusts(uri));
        let interval = Some(interval(device.interval).as_secs_f64());
        let expires_in = device.expires_in.clamp(1.0, LONGEST_WAIT_S);
        Ok(Device {
            user_code: shown(&device.user_code),
            verification_uri_complete: complete,
            interval,
            expires_in,
            ..device
        })
    }

    /// The person who shows this.
    pub(crate) async fn person(&self, proof: &Proof) -> Result<Person, Error> {
        let _call = self.admit()?;
        let options = &self.0.options;
        let metadata = self.0.provider.known().await?.metadata;
        let redirect_uri = options.redirect_uri();
        let (form, nonce) = match proof {
            Proof::Browser { code, code_verifier, nonce } => {
                let form = vec![
                    ("grant_type", "authorization_code"),
                    ("code", code.as_str()),
                    ("redirect_uri", redirect_uri.as_str()),
                    ("code_verifier", code_verifier.as_str()),
                ];
                (form, Some(nonce.as_str()))
            }
            Proof::Device { code } => {
                (vec![("grant_type", DEVICE_GRANT), ("device_code", code.as_str())], None)
            }
        };
        let tokens: Tokens = self.ask(&metadata, &metadata.token_endpoint, &form).await?;
        let token = tokens.id_token.ok_or_else(|| Error::Token("it is missing".to_owned()))?;
        let expected = Expected { issuer: &options.issuer, client_id: &options.client_id, nonce };
        let mut claims = id_token::check(&token, expected, &self.0.provider).await?;
        if !person::has_all(&claims, options)
            && let (Some(endpoint), Some(token)) =
                (&metadata.userinfo_endpoint, tokens.access_token)
        {
            let more = self.more_claims(endpoint, &token).await?;
            // Without this another person's claims could be put in (OpenID Connect Core 1.0, 5.3.2).
            if more.get("sub") != claims.get("sub") {
                return Err(Error::Token("its person is not the one of the claims".to_owned()));
            }
            person::complete(&mut claims, more);
        }
        Person::of(&claims, options)
    }

    /// Claims that the ID token does not have: some providers state them only when asked.
    async fn more_claims(&self, endpoint: &str, token: &str) -> Result<Claims, Error> {
        const WHAT: &str = "claims";
        let unusable = |fault: String| Error::Unusable { what: WHAT, fault };
        let credentials = secret_header(&format!("Bearer {token}"))?;
        let answer = self.0.provider.http.get(endpoint, Some(credentials)).await?;
        if answer.status != StatusCode::OK {
            return Err(Error::Away(format!(
                "it answers {} when asked for {WHAT}",
                answer.status.as_u16()
            )));
        }
        serde_json::from_slice(&answer.body).map_err(|e| unusable(plain(&e.to_string())))
    }

    /// Posts a form to an endpoint, as this client.
    async fn ask<T: DeserializeOwned>(
        &self,
        metadata: &Metadata,
        endpoint: &str,
        fields: &[(&str, &str)],
    ) -> Result<T, Error> {
        let (form, credentials) = self.form(metadata, fields)?;
        let answer = self.0.provider.http.post(endpoint, form, credentials).await?;
        if answer.status == StatusCode::OK {
            return serde_json::from_slice(&answer.body)
                .map_err(|e| Error::Unusable { what: "an answer", fault: plain(&e.to_string()) });
        }
        if answer.status.is_server_error() || answer.status == StatusCode::TOO_MANY_REQUESTS {
            return Err(Error::Away(format!("it answers {}", answer.status.as_u16())));
        }
        let ProviderError { error, error_description } =
            serde_json::from_slice(&answer.body).unwrap_or_default();
        Err(match error.as_str() {
            "authorization_pending" => Error::Pending { delay: INTERVAL },
            // The device adds this to its interval, which it alone knows.
            "slow_down" => Error::SlowDown { delay: INTERVAL + MORE },
            "" => Error::Refused(format!("it answers {}", answer.status.as_u16())),
            word => {
                let said = match plain(&error_description) {
                    text if text.is_empty() => plain(word),
                    text => format!("{} ({text})", plain(word)),
                };
                match word {
                    "invalid_client" | "unauthorized_client" => Error::Client(said),
                    _ => Error::Refused(said),
                }
            }
        })
    }

    /// The text of a form with what shows who this client is, or the header that does.
    fn form(
        &self,
        metadata: &Metadata,
        fields: &[(&str, &str)],
    ) -> Result<(String, Option<HeaderValue>), Error> {
        let id = &self.0.options.client_id;
        let methods = &metadata.token_endpoint_auth_methods_supported;
        let takes_basic = methods.is_empty() || methods.iter().any(|m| m == "client_secret_basic");
        let mut form = form_urlencoded::Serializer::new(String::new());
        form.extend_pairs(fields);
        let credentials = match &self.0.secret {
            Some(secret) if takes_basic => Some(basic(id, secret)?),
            secret => {
                form.append_pair("client_id", id);
                if let Some(secret) = secret {
                    form.append_pair("client_secret", secret);
                }
                None
            }
        };
        Ok((form.finish(), credentials))
    }

    /// What the provider states, for a start. Usually it is known, and the provider is not called: such
    /// starts have a separate rate, so that slow or many calls do not stop them.
    async fn metadata_for_start(&self) -> Result<Arc<Metadata>, Error> {
        if let Some(known) = self.0.provider.cached() {
            let may = self.0.starts.admit(Context::current().network, Instant::now());
            return if may { Ok(known.metadata) } else { Err(Error::Busy) };
        }
        let _call = self.admit()?;
        Ok(self.0.provider.known().await?.metadata)
    }

    /// Counts a call of the provider, which is one of a limited number as long as the result is held.
    fn admit(&self) -> Result<Call<'_>, Error> {
        let network = Context::current().network;
        if !self.0.rate.admit(network, Instant::now()) {
            return Err(Error::Busy);
        }
        self.0.calls.begin(network).ok_or(Error::Busy)
    }
}

impl Proof {
    /// True if it has the form that it must have.
    pub(crate) fn is_well_formed(&self) -> bool {
        let is_code = |code: &str| {
            (1..=LONGEST_CODE).contains(&code.len()) && code.bytes().all(|b| b.is_ascii_graphic())
        };
        match self {
            Self::Browser { code, code_verifier, nonce } => {
                is_code(code) && is_random(code_verifier) && is_random(nonce)
            }
            Self::Device { code } => is_code(code),
        }
    }
}

impl Challenge {
    /// True if it has the form that it must have.
    pub(crate) fn is_well_formed(&self) -> bool {
        [&self.state, &self.nonce, &self.code_challenge].into_iter().all(|text| is_random(text))
    }
}

/// True for 256 bits in base64url.
fn is_random(text: &str) -> bool {
    text.len() == 43 && text.bytes().all(|b| b.is_ascii_alphanumeric() || b"-_".contains(&b))
}

/// The delay that a provider asks for, within reason.
fn interval(stated: Option<f64>) -> Duration {
    let stated = stated.filter(|s| s.is_finite()).unwrap_or(INTERVAL.as_secs_f64());
    Duration::from_secs_f64(stated.clamp(1.0, 60.0))
}

/// Credentials of a client (RFC 6749, 2.3.1).
fn basic(id: &str, secret: &str) -> Result<HeaderValue, Error> {
    let encoded = |text: &str| form_urlencoded::byte_serialize(text.as_bytes()).collect::<String>();
    let pair = BASE64_STANDARD.encode(format!("{}:{}", encoded(id), encoded(secret)));
    secret_header(&format!("Basic {pair}"))
}

fn secret_header(text: &str) -> Result<HeaderValue, Error> {
    let mut value = HeaderValue::try_from(text)
        .map_err(|e| Error::Unusable { what: "credentials", fault: e.to_string() })?;
    value.set_sensitive(true);
    Ok(value)
}

/// The secret in a file that only this user can read.
fn read_secret(path: &std::path::Path) -> std::io::Result<String> {
    let file = std::fs::File::open(path)?;
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt as _;
        if file.metadata()?.permissions().mode() & 0o007 != 0 {
            let path = path.display();
            let fault = format!("other users can read it: `chmod o= {path}`");
            return Err(std::io::Error::other(fault));
        }
    }
    let text = std::io::read_to_string(file)?;
    match text.trim() {
        "" => Err(std::io::Error::other("it is empty")),
        secret => Ok(secret.to_owned()),
    }
}

#[cfg(all(test, unix))]
mod tests {
    use std::os::unix::fs::PermissionsExt as _;

    use super::*;

    #[test]
    fn a_secret_that_others_can_read_is_refused_with_a_command_that_names_it() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("client-secret");
        std::fs::write(&path, "secret\n").unwrap();
        std::fs::set_permissions(&path, std::fs::Permissions::from_mode(0o644)).unwrap();
        let refused = read_secret(&path).unwrap_err().to_string();
        assert!(refused.contains(&format!("`chmod o= {}`", path.display())), "{refused}");
        std::fs::set_permissions(&path, std::fs::Permissions::from_mode(0o640)).unwrap();
        assert_eq!(read_secret(&path).unwrap(), "secret");
    }
}
