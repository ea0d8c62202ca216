//! Options of the sign-in of people with the identity provider of their organisation (OpenID Connect).

use std::{collections::BTreeMap, path::PathBuf, time::Duration};

use serde::{Deserialize, Serialize};
use url::{Host, Url};

use super::{ClientTokenPolicy, DefaultQuotas, Options, public::host_not_allowed};
use crate::{
    access::{Grant, Scope},
    http::origin::Hosts,
};

/// Longest list of each kind.
const MOST: usize = 1000;
/// Path of the page to which the provider sends a browser back.
const REDIRECT_PATH: &str = "sign-in";
/// A provider at which everybody can have an account.
const PUBLIC_PROVIDER: &str = "accounts.google.com";

/// Sign-in of people with an identity provider.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SignIn {
    /// Issuer, exactly as the provider states it in its discovery document.
    pub issuer: String,
    /// Id under which the provider knows this server.
    pub client_id: String,
    /// File with the secret of this client, which other users of the machine must not be able to
    /// read; a public client has none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub client_secret_file: Option<PathBuf>,
    /// PEM file of the authority of the provider's certificate; without it those of the system.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ca: Option<PathBuf>,
    /// Address at which browsers reach this server, without a path. Browsers come back to `/sign-in`
    /// below it, which the provider has to know as redirect URI.
    pub public_url: String,
    /// Name of the provider on the button of the console.
    #[serde(default = "display_name")]
    pub display_name: String,
    /// Scopes that the provider is asked for.
    #[serde(default = "oidc_scopes")]
    pub oidc_scopes: Vec<String>,
    /// Claim whose value becomes the owner of what a person makes. `email` has to be verified.
    #[serde(default = "owner_claim")]
    pub owner_claim: String,
    /// Domains that the owner, which then has to be an address, may have; empty allows all.
    #[serde(default)]
    pub allowed_domains: Vec<String>,
    /// Claim with the groups of a person, if they decide about scopes.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub groups_claim: Option<String>,
    /// Scopes of the members of each group.
    #[serde(default)]
    pub groups: BTreeMap<String, Vec<String>>,
    /// Scopes of everybody who signs in. Who has none, by these or by a group, is refused.
    #[serde(default)]
    pub default_scopes: Vec<String>,
    /// Time after which a person signs in again [s].
    #[serde(default = "session_s")]
    pub session_s: f64,
    /// Bounds on what a person may have; those that are missing are of the server's `quotas`.
    #[serde(default)]
    pub quotas: DefaultQuotas,
}

fn display_name() -> String {
    "your organisation".to_owned()
}

fn oidc_scopes() -> Vec<String> {
    ["openid", "email", "profile"].map(str::to_owned).into()
}

fn owner_claim() -> String {
    "email".to_owned()
}

fn session_s() -> f64 {
    12.0 * 3600.0
}

impl SignIn {
    /// Options for a provider, with the default of everything else.
    pub fn new(issuer: &str, client_id: &str, public_url: &str) -> Self {
        Self {
            issuer: issuer.to_owned(),
            client_id: client_id.to_owned(),
            client_secret_file: None,
            ca: None,
            public_url: public_url.to_owned(),
            display_name: display_name(),
            oidc_scopes: oidc_scopes(),
            owner_claim: owner_claim(),
            allowed_domains: Vec::new(),
            groups_claim: None,
            groups: BTreeMap::new(),
            default_scopes: Vec::new(),
            session_s: session_s(),
            quotas: DefaultQuotas::default(),
        }
    }

    /// The one address to which the provider sends browsers back.
    pub(crate) fn redirect_uri(&self) -> String {
        format!("{}/{REDIRECT_PATH}", self.public_url.trim_end_matches('/'))
    }

    /// The origin of the public address, as browsers write it.
    pub(crate) fn origin(&self) -> String {
        let url = Url::parse(&self.public_url);
        url.map(|url| url.origin().ascii_serialization()).unwrap_or_default()
    }

    pub(crate) fn session(&self) -> Duration {
        Duration::from_secs_f64(self.session_s)
    }

    fn faults(&self) -> Vec<String> {
        let mut faults = Vec::new();
        let mut check = |is_right: bool, fault: &str| {
            if !is_right {
                faults.push(format!("sign_in.{fault}"));
            }
        };
        let issuer = Url::parse(&self.issuer).ok().filter(is_protected);
        check(
            issuer.is_some(),
            "issuer must be an https:// address without query (http:// only on this machine)",
        );
        let public = Url::parse(&self.public_url).ok().filter(is_protected);
        check(
            public.is_some_and(|url| url.path() == "/"),
            "public_url must be the https:// address of this server without a path (http:// only on \
             this machine)",
        );
        check(is_line(&self.client_id), "client_id is empty or has control characters");
        check(is_line(&self.display_name), "display_name is empty or has control characters");
        check(is_line(&self.owner_claim), "owner_claim is empty or has control characters");
        check(
            self.oidc_scopes.iter().any(|scope| scope == "openid")
                && self.oidc_scopes.iter().all(|scope| is_line(scope) && !scope.contains(' ')),
            "oidc_scopes must have `openid`, and no spaces within a scope",
        );
        check(
            (60.0..=31.0 * 86_400.0).contains(&self.session_s),
            "session_s must lie in 60..=2678400",
        );
        let mut scopes = self.groups.values().flatten().chain(&self.default_scopes);
        let words = Scope::ALL.map(Scope::as_str).join(", ");
        check(
            scopes.all(|word| Grant::parse(word).is_some()),
            &format!(
                "groups and default_scopes may have the scopes {words} alone; {}",
                Grant::CONFINED
            ),
        );
        check(
            self.quotas.running_jobs != Some(0),
            "quotas.running_jobs is 0, with which no job would ever run",
        );
        check(
            !self.groups.is_empty() || !self.default_scopes.is_empty(),
            "default_scopes and groups are empty, so nobody could do anything: give scopes",
        );
        check(
            self.groups.is_empty() || self.groups_claim.as_deref().is_some_and(is_line),
            "groups need groups_claim, the claim in which the provider states them",
        );
        check(
            self.groups.len() <= MOST && self.allowed_domains.len() <= MOST,
            "groups and allowed_domains may have 1000 entries",
        );
        check(
            self.allowed_domains.iter().all(|domain| is_line(domain) && !domain.contains('@')),
            "allowed_domains has something else than domains such as example.org",
        );
        let is_public = issuer.as_ref().and_then(Url::host_str) == Some(PUBLIC_PROVIDER);
        check(
            !is_public || !self.allowed_domains.is_empty(),
            "allowed_domains is empty, but everybody can have an account at this provider: name \
             the domains of your organisation",
        );
        faults
    }
}

impl Options {
    /// Faults of the sign-in.
    pub(super) fn sign_in_faults(&self) -> Vec<String> {
        let Some(sign_in) = &self.sign_in else { return Vec::new() };
        let mut faults = sign_in.faults();
        let public = Url::parse(&sign_in.public_url).ok();
        if let Some(host) = public.as_ref().and_then(Url::host_str)
            && !Hosts::new(&self.allowed_hosts).allows(host)
        {
            faults.push(host_not_allowed("sign_in.public_url", host));
        }
        if self.client_token == ClientTokenPolicy::None {
            faults
                .push("sign_in has no effect with client_token = \"none\": remove one".to_owned());
        }
        faults
    }
}

/// True for an address that nobody on the way can change: over TLS, or on this machine.
pub(crate) fn is_protected(url: &Url) -> bool {
    let is_plain = url.username().is_empty()
        && url.password().is_none()
        && url.query().is_none()
        && url.fragment().is_none();
    is_plain && (url.scheme() == "https" && url.has_host() || is_local(url))
}

/// True for an address without TLS on this machine.
pub(crate) fn is_local(url: &Url) -> bool {
    url.scheme() == "http"
        && match url.host() {
            Some(Host::Domain(name)) => name == "localhost",
            Some(Host::Ipv4(address)) => address.is_loopback(),
            Some(Host::Ipv6(address)) => address.is_loopback(),
            None => false,
        }
}

fn is_line(text: &str) -> bool {
    (1..=200).contains(&text.chars().count()) && !text.chars().any(char::is_control)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn faults(change: impl FnOnce(&mut SignIn)) -> String {
        let mut options = SignIn::new("https://id.example", "bendtwin", "https://twin.example");
        options.default_scopes = vec!["twins:read".to_owned()];
        change(&mut options);
        let allowed_hosts = vec!["twin.example".to_owned()];
        let options = Options { sign_in: Some(options), allowed_hosts, ..Options::default() };
        options.validate().err().unwrap_or_default().join("; ")
    }

    #[test]
    fn each_fault_is_named() {
        assert_eq!(faults(|_| ()), "");
        assert_eq!(faults(|o| o.issuer = "http://127.0.0.1:9/realm".into()), "");
        assert_eq!(faults(|o| o.default_scopes = vec!["twins:read:own".into()]), "");
        type Change = fn(&mut SignIn);
        let cases: [(&str, Change); 15] = [
            ("issuer", |o| o.issuer = "http://id.example".into()),
            ("issuer", |o| o.issuer = "https://a:b@id.example".into()),
            ("issuer", |o| o.issuer = "https://id.example?a=b".into()),
            ("public_url", |o| o.public_url = "https://twin.example/console".into()),
            ("public_url", |o| o.public_url = "http://twin.example".into()),
            ("client_id", |o| o.client_id = String::new()),
            ("oidc_scopes", |o| o.oidc_scopes = vec!["email".into()]),
            ("session_s", |o| o.session_s = f64::NAN),
            ("groups and default_scopes", |o| o.default_scopes = vec!["everything".into()]),
            ("groups and default_scopes", |o| o.default_scopes = vec!["admin:own".into()]),
            ("default_scopes", |o| o.default_scopes.clear()),
            ("quotas.running_jobs", |o| o.quotas.running_jobs = Some(0)),
            ("groups_claim", |o| drop(o.groups.insert("lab".into(), vec!["admin".into()]))),
            ("allowed_domains", |o| o.allowed_domains = vec!["a@example.org".into()]),
            ("allowed_domains", |o| o.issuer = "https://accounts.google.com".into()),
        ];
        for (name, change) in cases {
            let found = faults(change);
            assert!(found.contains("sign_in.") && found.contains(name), "{name}: {found}");
        }
    }

    #[test]
    fn without_a_token_there_is_nothing_to_sign_in_to() {
        let mut sign_in = SignIn::new("https://id.example", "bendtwin", "https://twin.example");
        sign_in.default_scopes = vec!["twins:read".to_owned()];
        let client_token = ClientTokenPolicy::None;
        let allowed_hosts = vec!["*".to_owned()];
        let sign_in = Some(sign_in);
        let options = Options { sign_in, client_token, allowed_hosts, ..Options::default() };
        assert!(options.validate().unwrap_err()[0].contains("client_token"));
    }

    #[test]
    fn browsers_can_come_back_to_the_public_address() {
        for accepted in ["https://Twin.example:8443", "http://localhost:7070", "https://10.0.0.7"] {
            assert_eq!(faults(|o| o.public_url = accepted.into()), "", "{accepted}");
        }
        let found = faults(|o| o.public_url = "https://other.example".into());
        assert!(found.contains("sign_in.public_url") && found.contains("allowed_hosts"), "{found}");
    }

    #[test]
    fn an_origin_is_written_as_browsers_do() {
        let origin = |url: &str| SignIn::new("https://id.example", "bendtwin", url).origin();
        assert_eq!(origin("https://Twin.example:443/"), "https://twin.example");
        assert_eq!(origin("http://127.0.0.1:7070"), "http://127.0.0.1:7070");
    }
}
