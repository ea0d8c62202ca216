//! The person of an ID token: the owner of what they make, and their scopes.

use std::collections::BTreeSet;

use serde_json::Value;

use super::{
    error::{Error, plain},
    id_token::Claims,
};
use crate::{access::TOKEN_OWNER, options::SignIn};

/// Most groups of a person that are looked at.
const MOST_GROUPS: usize = 10_000;

/// Somebody who has signed in.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Person {
    /// Issuer and subject, which stay when name and address change.
    pub(crate) id: String,
    /// Owner of what the person makes.
    pub(crate) owner: String,
    /// Words of their scopes.
    pub(crate) scopes: Vec<String>,
}

/// An address, and whether it is the person's.
const ADDRESS: [&str; 2] = ["email", "email_verified"];

/// True if these claims have all that decides about a person.
pub(super) fn has_all(claims: &Claims, options: &SignIn) -> bool {
    let is_by_address = options.owner_claim == ADDRESS[0];
    let verified = is_by_address.then_some(ADDRESS[1]);
    let named = [Some(options.owner_claim.as_str()), options.groups_claim.as_deref(), verified];
    named.into_iter().flatten().all(|claim| claims.contains_key(claim))
}

/// Adds claims that an ID token does not have. An address and its verification come from one of both,
/// because the address of the other may be another one.
pub(super) fn complete(claims: &mut Claims, more: Claims) {
    if !ADDRESS.iter().all(|name| claims.contains_key(*name)) {
        for name in ADDRESS {
            claims.remove(name);
        }
    }
    for (name, value) in more {
        claims.entry(name).or_insert(value);
    }
}

impl Person {
    /// The person of these claims, if the options let them in.
    pub(super) fn of(claims: &Claims, options: &SignIn) -> Result<Self, Error> {
        let subject = claims.get("sub").and_then(Value::as_str).unwrap_or_default();
        let owner = owner(claims, options)?;
        let scopes = scopes(claims, options);
        if scopes.is_empty() {
            return Err(Error::NotAllowed(format!(
                "{owner} is in no group that may use this server"
            )));
        }
        Ok(Self { id: format!("{} {subject}", options.issuer), owner, scopes })
    }
}

fn owner(claims: &Claims, options: &SignIn) -> Result<String, Error> {
    let claim = &options.owner_claim;
    let given = claims.get(claim).and_then(Value::as_str).map(str::trim).unwrap_or_default();
    if given.is_empty() {
        return Err(Error::NotAllowed(format!(
            "the identity provider does not state the claim `{claim}`, which names the owner"
        )));
    }
    if given.chars().count() > 200 || given.chars().any(char::is_control) {
        return Err(Error::NotAllowed(format!(
            "the claim `{claim}` has more than 200 characters, or control characters"
        )));
    }
    if claim == "email" && !claims.contains_key("email_verified") {
        return Err(Error::NotAllowed(format!(
            "the identity provider does not state whether the address {} is verified (claim \
             `email_verified`)",
            plain(given)
        )));
    }
    if claim == "email" && !is_verified(claims.get("email_verified")) {
        return Err(Error::NotAllowed(format!(
            "the identity provider has not verified the address {}",
            plain(given)
        )));
    }
    if (claim == "email" || given.contains('@')) && !is_address(given) {
        return Err(Error::NotAllowed(format!(
            "the claim `{claim}` is no e-mail address of ASCII characters: {}",
            plain(given)
        )));
    }
    // Addresses are equal regardless of case, in practice if not by the standard.
    let owner = if given.contains('@') { given.to_ascii_lowercase() } else { given.to_owned() };
    if owner == TOKEN_OWNER {
        let fault = format!("`{TOKEN_OWNER}` is the owner of what is made with the server's token");
        return Err(Error::NotAllowed(fault));
    }
    if options.allowed_domains.is_empty() {
        return Ok(owner);
    }
    let domain = owner.rsplit_once('@').map(|(_, domain)| domain);
    match domain {
        Some(domain) if options.allowed_domains.iter().any(|d| d.eq_ignore_ascii_case(domain)) => {
            Ok(owner)
        }
        _ => Err(Error::NotAllowed(format!("{owner} is of no domain that may use this server"))),
    }
}

/// True for a plain address. Other letters could become those of another person's address: the Kelvin
/// sign in lower case is a k.
fn is_address(text: &str) -> bool {
    let mut parts = text.split('@');
    let has_parts = matches!(
        (parts.next(), parts.next(), parts.next()),
        (Some(local), Some(domain), None) if !local.is_empty() && !domain.is_empty()
    );
    has_parts && text.bytes().all(|b| b.is_ascii_graphic())
}

/// Some providers write truth values as text.
fn is_verified(claim: Option<&Value>) -> bool {
    match claim {
        Some(Value::Bool(verified)) => *verified,
        Some(Value::String(text)) => text == "true",
        _ => false,
    }
}

fn scopes(claims: &Claims, options: &SignIn) -> Vec<String> {
    let mut scopes: BTreeSet<&String> = options.default_scopes.iter().collect();
    let stated = options.groups_claim.as_ref().and_then(|claim| claims.get(claim));
    let groups = match stated {
        Some(Value::Array(groups)) => groups.as_slice(),
        Some(group) => std::slice::from_ref(group),
        None => &[],
    };
    for group in groups.iter().take(MOST_GROUPS).filter_map(Value::as_str) {
        scopes.extend(options.groups.get(group).into_iter().flatten());
    }
    scopes.into_iter().cloned().collect()
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    fn options() -> SignIn {
        let mut options = SignIn::new("https://id.example", "bendtwin", "https://twin.example");
        options.default_scopes = vec!["twins:read".into()];
        options
    }

    fn claims_of(claims: Value) -> Claims {
        claims.as_object().unwrap().clone()
    }

    fn person(claims: Value, options: &SignIn) -> Result<Person, Error> {
        Person::of(claims.as_object().unwrap(), options)
    }

    #[test]
    fn an_address_counts_if_it_is_verified() {
        let claims = |verified: Value| json!({"sub": "1", "email": "Ann@Example.org", "email_verified": verified});
        for verified in [json!(true), json!("true")] {
            let ann = person(claims(verified), &options()).unwrap();
            assert_eq!(ann.owner, "ann@example.org");
            assert_eq!(ann.id, "https://id.example 1");
        }
        for not in [json!(false), json!("false"), json!(1), json!(null)] {
            let refused = person(claims(not), &options()).unwrap_err().to_string();
            assert!(refused.contains("not verified"), "{refused}");
        }
        let refused = person(json!({"sub": "1"}), &options()).unwrap_err().to_string();
        assert!(refused.contains("`email`"), "{refused}");
        let unstated = json!({"sub": "1", "email": "ann@example.org"});
        let refused = person(unstated, &options()).unwrap_err().to_string();
        assert!(refused.contains("`email_verified`"), "{refused}");
    }

    #[test]
    fn an_address_is_ascii_and_has_two_parts() {
        for wrong in [
            "mi\u{212a}e@example.org",
            "ann@exam\u{131}ple.org",
            "ann",
            "@example.org",
            "ann@",
            "@",
            "a@b@example.org",
            "a nn@example.org",
            "ann\u{200b}@example.org",
        ] {
            let claims = json!({"sub": "1", "email": wrong, "email_verified": true});
            let refused = person(claims, &options()).unwrap_err().to_string();
            assert!(refused.contains("no e-mail address"), "{wrong}: {refused}");
        }
        let by_upn = SignIn { owner_claim: "upn".into(), ..options() };
        assert!(person(json!({"sub": "1", "upn": "mi\u{212a}e@example.org"}), &by_upn).is_err());
        let renée = json!({"sub": "1", "upn": "Renée"});
        assert_eq!(person(renée, &by_upn).unwrap().owner, "Renée");
    }

    #[test]
    fn an_address_is_verified_where_it_is_stated() {
        let completed = |claims: Value, more: Value| {
            let mut claims = claims_of(claims);
            assert!(!has_all(&claims, &options()));
            complete(&mut claims, claims_of(more));
            Person::of(&claims, &options()).map(|person| person.owner)
        };
        let other = json!({"email": "eve@example.org", "email_verified": true});
        let token = json!({"sub": "1", "email": "ann@example.org"});
        assert_eq!(completed(token.clone(), other).unwrap(), "eve@example.org");
        assert!(completed(token, json!({"email_verified": true})).is_err());
        assert!(completed(json!({"sub": "1"}), json!({"email": "ann@example.org"})).is_err());
        let mut claims =
            claims_of(json!({"sub": "1", "email": "ann@example.org", "email_verified": false}));
        assert!(has_all(&claims, &options()));
        complete(&mut claims, claims_of(json!({"email_verified": true})));
        assert!(Person::of(&claims, &options()).is_err());
    }

    #[test]
    fn domains_are_compared_whole() {
        let mut options = options();
        options.allowed_domains = vec!["example.org".into()];
        options.owner_claim = "upn".into();
        let may = |owner: &str| person(json!({"sub": "1", "upn": owner}), &options).is_ok();
        assert!(may("ann@example.org") && may("ann@EXAMPLE.org"));
        for other in ["ann", "ann@example.org.evil.net", "ann@sub.example.org", "x@evilexample.org"]
        {
            assert!(!may(other), "{other}");
        }
    }

    #[test]
    fn nobody_becomes_the_owner_of_what_the_token_made() {
        let options = SignIn { owner_claim: "preferred_username".into(), ..options() };
        let claims = |name: &str| json!({"sub": "1", "preferred_username": name});
        assert!(person(claims("local"), &options).is_err());
        assert!(person(claims(" local "), &options).is_err());
        assert!(person(claims("a\nb"), &options).is_err());
        assert!(person(claims(&"a".repeat(201)), &options).is_err());
        assert_eq!(person(claims("Ann"), &options).unwrap().owner, "Ann");
    }

    #[test]
    fn groups_add_scopes_and_who_has_none_is_refused() {
        let mut options = SignIn { owner_claim: "name".into(), ..options() };
        options.groups_claim = Some("groups".into());
        options.groups.insert("lab".into(), vec!["rollouts:run".into(), "twins:read".into()]);
        let scopes = |groups: Value, options: &SignIn| {
            person(json!({"sub": "1", "name": "Ann", "groups": groups}), options).map(|p| p.scopes)
        };
        assert_eq!(
            scopes(json!(["lab", "other"]), &options).unwrap(),
            ["rollouts:run", "twins:read"]
        );
        assert_eq!(scopes(json!("lab"), &options).unwrap(), ["rollouts:run", "twins:read"]);
        assert_eq!(scopes(json!([1, {"lab": 2}]), &options).unwrap(), ["twins:read"]);
        options.default_scopes.clear();
        let refused = scopes(json!(["Lab"]), &options).unwrap_err().to_string();
        assert!(refused.contains("no group"), "{refused}");
    }
}
