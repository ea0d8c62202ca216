use bendtwin_core::{Fault, ids::KeyId};

use super::*;

fn reason(result: Result<(), Refusal>) -> Option<Fault> {
    let context = crate::context::Context::default();
    result.err().map(|refusal| bendtwin_proto::fault::fault(&refusal.into_status(&context)))
}

#[test]
fn scopes_allow_what_they_name_and_nothing_else() {
    for scope in Scope::ALL {
        assert_eq!(Scope::parse(scope.as_str()), Some(scope));
        let caller = Caller { scopes: [scope].into_iter().collect(), ..Caller::default() };
        for other in Scope::ALL {
            let refused = reason(caller.require(Some(Access::Scope(other))));
            match refused {
                None => assert_eq!(scope, other),
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
fn what_is_not_listed_is_denied_to_everyone() {
    for caller in [Caller::anyone(), Caller::with_token(), Caller::default()] {
        assert_eq!(reason(caller.require(None)).unwrap().reason, "SCOPE_MISSING");
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
    let key = Key {
        id: KeyId::generate(),
        display_name: "a".to_owned(),
        owner: "b".to_owned(),
        hash: blake3::hash(b"c"),
        scopes: vec!["everything".to_owned(), "twins:read".to_owned()],
        quotas: Quotas::default(),
        created: jiff::Timestamp::UNIX_EPOCH,
        expires: None,
        revoked: None,
        used: None,
        signed_in_as: None,
    };
    let caller = Caller::with_key(&key, InFlight::default());
    assert_eq!((caller.key, &*caller.owner), (Some(key.id), "b"));
    assert_eq!(caller.scopes, [Scope::TwinsRead].into_iter().collect());
}
