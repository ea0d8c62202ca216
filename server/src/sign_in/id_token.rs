//! Checks of an ID token: its signature, who issued it for whom, its times, and the nonce of the
//! browser for which it was requested.

use std::time::{SystemTime, UNIX_EPOCH};

use jsonwebtoken::{
    Algorithm, DecodingKey, Header, Validation, decode, decode_header,
    errors::ErrorKind,
    jwk::{Jwk, KeyAlgorithm, PublicKeyUse},
};
use serde_json::{Map, Value};

use super::{error::Error, provider::Provider, signatures};

/// Most that the clock of the provider may differ from that of the server [s].
const SKEW_S: u64 = 60;
/// Age of the oldest token that is accepted [s]: it was made for this sign-in.
const OLDEST_S: u64 = 600;

/// Claims of a person.
pub(super) type Claims = Map<String, Value>;

/// What a token has to be.
#[derive(Clone, Copy, Debug)]
pub(super) struct Expected<'a> {
    pub(super) issuer: &'a str,
    pub(super) client_id: &'a str,
    /// Nonce of the browser; `None` for a device, which has no browser.
    pub(super) nonce: Option<&'a str>,
}

/// The claims of a token, if it is what is expected.
pub(super) async fn check(
    token: &str,
    expected: Expected<'_>,
    provider: &Provider,
) -> Result<Claims, Error> {
    let header = decode_header(token).map_err(|_| invalid("it is malformed, or not signed"))?;
    if !signatures::is_accepted(header.alg) {
        return Err(invalid("it is signed with an algorithm that is not accepted"));
    }
    if header.crit.is_some() {
        return Err(invalid("it has critical extensions"));
    }
    let known = provider.known().await?.keys;
    let key = match signer(&known, &header) {
        Some(key) => key,
        None => signer(&provider.newer_keys().await?, &header)
            .ok_or_else(|| invalid("it is signed with a key that the provider does not publish"))?,
    };
    let claims = decode::<Claims>(token, &key, &validation(header.alg, expected));
    let claims = claims.map_err(|error| invalid(fault(error.kind())))?.claims;
    let now = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |since| since.as_secs());
    check_claims(&claims, expected, now)?;
    Ok(claims)
}

fn validation(algorithm: Algorithm, expected: Expected<'_>) -> Validation {
    let mut validation = Validation::new(algorithm);
    validation.leeway = SKEW_S;
    validation.validate_nbf = true;
    validation.set_issuer(&[expected.issuer]);
    validation.set_audience(&[expected.client_id]);
    validation.set_required_spec_claims(&["exp", "iss", "aud", "sub"]);
    validation
}

/// The key that signed a token: the one of its id, or the only one of its kind if it has no id.
fn signer(keys: &[Jwk], header: &Header) -> Option<DecodingKey> {
    let mut fitting = keys.iter().filter_map(|key| {
        let is_named = header.kid.is_none() || key.common.key_id == header.kid;
        let is_for = match key.common.key_algorithm {
            Some(algorithm) => is_same(algorithm, header.alg),
            None => true,
        };
        let is_for_signatures =
            !matches!(key.common.public_key_use, Some(PublicKeyUse::Encryption));
        let made = DecodingKey::from_jwk(key).ok()?;
        let is_kind = made.family() == header.alg.family();
        (is_named && is_for && is_for_signatures && is_kind).then_some(made)
    });
    let key = fitting.next()?;
    (header.kid.is_some() || fitting.next().is_none()).then_some(key)
}

fn is_same(key: KeyAlgorithm, token: Algorithm) -> bool {
    format!("{key:?}") == format!("{token:?}")
}

/// What the library leaves to its users (OpenID Connect Core 1.0, 3.1.3.7).
fn check_claims(claims: &Claims, expected: Expected<'_>, now: u64) -> Result<(), Error> {
    let text = |name: &str| claims.get(name).and_then(Value::as_str);
    if text("iss") != Some(expected.issuer) {
        return Err(invalid("its issuer is another one"));
    }
    if claims.get("azp").is_some() && text("azp") != Some(expected.client_id) {
        return Err(invalid("it was issued to another client"));
    }
    let is_for_several = claims.get("aud").and_then(Value::as_array).is_some_and(|a| a.len() > 1);
    if is_for_several && text("azp").is_none() {
        return Err(invalid("it is for several clients, and does not say for which it was issued"));
    }
    if text("sub").is_none_or(|subject| subject.is_empty() || subject.len() > 255) {
        return Err(invalid("it does not name a person"));
    }
    let issued = claims.get("iat").and_then(Value::as_f64).unwrap_or(f64::NAN);
    let oldest = now.saturating_sub(OLDEST_S + SKEW_S) as f64;
    if !(oldest..=(now + SKEW_S) as f64).contains(&issued) {
        return Err(invalid("it is too old, or of the future: compare the clocks"));
    }
    if expected.nonce.is_some() && text("nonce") != expected.nonce {
        return Err(invalid("it was made for another browser"));
    }
    Ok(())
}

fn fault(kind: &ErrorKind) -> &'static str {
    match kind {
        ErrorKind::InvalidSignature => "its signature is wrong",
        ErrorKind::InvalidIssuer => "its issuer is another one",
        ErrorKind::InvalidAudience => "it is for another client",
        ErrorKind::ExpiredSignature => "it has expired: compare the clocks",
        ErrorKind::ImmatureSignature => "it is not valid yet: compare the clocks",
        ErrorKind::MissingRequiredClaim(_) => "claims are missing",
        _ => "it is malformed",
    }
}

fn invalid(fault: &str) -> Error {
    Error::Token(fault.to_owned())
}
