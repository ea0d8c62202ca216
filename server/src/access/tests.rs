use bendtwin_core::{Fault, ids::KeyId};
use bendtwin_store::Key;

use super::*;

/// The holder of a key of owner `b` with these scopes.
fn with(scopes: &[&str]) -> Caller {
    let key = Key {
        id: KeyId::generate(),
        display_name: "a".to_owned(),
        owner: "b".to_owned(),
        hash: blake3::hash(b"c"),
        scopes: scopes.iter().map(|scope| (*scope).to_owned()).collect(),
        quotas: Quotas::default(),
        created: jiff::Timestamp::UNIX_EPOCH,
        expires: None,
        revoked: None,
        used: None,
        signed_in_as: None,
        share: None,
    };
    let holder = Holder { key: Arc::new(key), memberships: Arc::default() };
    Caller::with_key(&holder, InFlight::default())
}

fn reason(result: Result<(), Refusal>) -> Option<Fault> {
    let context = crate::context::Context::default();
    result.err().map(|refusal| bendtwin_proto::fault::fault(&refusal.into_status(&context)))
}

#[test]
fn scopes_allow_what_they_name_and_nothing_else() {
    for scope in Scope::ALL {
        assert_eq!(Scope::parse(scope.as_str()), Some(scope));
        let caller = with(&[scope.as_str()]);
        for other in Scope::ALL {
            let refused = reason(caller.require(Some(Access::Scope(other)), ""));
            match refused {
                None => assert!(scope == other || other == Scope::MetricsRead),
                Some(fault) => {
                    assert_ne!(scope, other);
                    assert_eq!(fault.reason, "SCOPE_MISSING");
                    assert!(fault.message.contains(other.as_str()), "{}", fault.message);
                }
            }
        }
    }
    assert_eq!(Scope::parse("all"), None);
}

#[test]
fn a_bound_scope_is_for_the_owner_alone() {
    for scope in Scope::ALL.into_iter().filter(|scope| scope.has_bound()) {
        let bound = format!("{}:own", scope.as_str());
        let caller = with(&[&bound]);
        assert!(reason(caller.require(Some(Access::Scope(scope)), "")).is_none(), "{bound}");
        assert!(caller.reaches(scope, "b") && caller.bound(scope).as_deref() == Some("b"));
        for other in ["c", "", "B"] {
            assert!(!caller.reaches(scope, other), "{bound}, {other}");
        }
        // The wider of two counts.
        let caller = with(&[scope.as_str(), &bound]);
        assert!(caller.reaches(scope, "c") && caller.reaches(scope, ""));
        assert_eq!(caller.bound(scope), None);
        // Without the scope nothing is reached, one's own included.
        assert!(!with(&[]).reaches(scope, "b"));
    }
    for word in ["admin:own", "metrics:read:own", ":own", "captures:read:own:own", "captures:own"] {
        assert_eq!(Grant::parse(word), None, "{word}");
    }
}

#[test]
fn a_key_for_the_metrics_reads_nothing_else() {
    let scraper = with(&["metrics:read"]);
    assert!(scraper.require(Some(Access::Scope(Scope::MetricsRead)), "").is_ok());
    let refused = reason(scraper.require(Some(Access::Anyone), "")).unwrap();
    assert_eq!(refused.reason, "SCOPE_MISSING");
    assert!(refused.message.contains("metrics:read"), "{}", refused.message);
    let more = with(&["metrics:read", "twins:read"]);
    assert!(more.require(Some(Access::Anyone), "").is_ok());
}

#[test]
fn what_is_not_listed_is_denied_to_everyone() {
    for caller in [Caller::anyone(), Caller::with_token(), Caller::default()] {
        assert_eq!(reason(caller.require(None, "")).unwrap().reason, "SCOPE_MISSING");
    }
}

#[test]
fn what_is_refused_without_end_is_noted_once() {
    let caller = Caller::default();
    let fits = Some(Access::Scope(Scope::FitsWrite));
    for _ in 0..3 {
        assert!(caller.enter(fits, "POST /v1/fits").is_err());
    }
    assert_eq!(caller.refusals.note(Refused::Holder(None), "POST /v1/fits", Instant::now()), None);
    assert_eq!(
        caller.refusals.note(Refused::Holder(None), "POST /v1/twins", Instant::now()),
        Some(1)
    );
}

#[test]
fn words_that_are_no_scopes_allow_nothing() {
    let caller = with(&["everything", "twins:read"]);
    assert!(caller.key.is_some());
    assert_eq!(caller.scopes, ["twins:read"].into_iter().filter_map(Grant::parse).collect());
}
