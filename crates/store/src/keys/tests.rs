use std::time::Duration;

use super::*;
use crate::{
    database::testing::{On, on_both},
    store::tests::Bench,
};

on_both! {
    keys_are_stored_listed_and_revoked,
    the_last_use_does_not_go_back,
    sign_ins_of_a_person_are_bounded_revoked_and_forgotten,
}

fn new(name: &str) -> NewKey {
    NewKey {
        id: KeyId::generate(),
        display_name: name.to_owned(),
        owner: format!("owner of {name}"),
        hash: blake3::hash(name.as_bytes()),
        scopes: vec!["twins:read".into(), "captures:read".into(), "twins:read".into()],
        quotas: Quotas { queued_jobs: Some(3), ..Quotas::default() },
        expires: None,
        signed_in_as: None,
    }
}

async fn keys_are_stored_listed_and_revoked(on: On) {
    let bench = Bench::new(on).await;
    let keys = bench.store.keys();
    let expires = bench.store.now() + Duration::from_secs(60);
    let first = keys.create(NewKey { expires: Some(expires), ..new("a") }).await.unwrap();
    assert_eq!(first.scopes, ["captures:read", "twins:read"]);
    assert_eq!((first.expires, first.revoked, first.used), (Some(expires), None, None));
    assert_eq!(first.quotas, Quotas { queued_jobs: Some(3), ..Quotas::default() });
    let second = keys.create(new("b")).await.unwrap();
    assert_eq!(keys.get(first.id).await.unwrap(), first);
    assert_eq!(keys.all().await.unwrap(), [first.clone(), second.clone()]);
    let mut page = PageRequest { size: 1, token: String::new() };
    let listed = keys.list(&page).await.unwrap();
    assert_eq!(listed.items, [second]);
    page.token = listed.next_token;
    assert_eq!(keys.list(&page).await.unwrap().items, std::slice::from_ref(&first));

    let revoked = keys.revoke(first.id).await.unwrap();
    assert_eq!(revoked.revoked, Some(bench.store.now()));
    bench.clock.advance(Duration::from_secs(5));
    assert_eq!(keys.revoke(first.id).await.unwrap(), revoked);
    let unknown = KeyId::generate();
    assert!(matches!(keys.revoke(unknown).await, Err(Error::NotFound { .. })));
    assert!(matches!(keys.get(unknown).await, Err(Error::NotFound { .. })));
}

async fn the_last_use_does_not_go_back(on: On) {
    let bench = Bench::new(on).await;
    let keys = bench.store.keys();
    let key = keys.create(new("a")).await.unwrap();
    let now = bench.store.now();
    let uses = [(key.id, now), (key.id, now - Duration::from_secs(9)), (KeyId::generate(), now)];
    keys.used(&uses).await.unwrap();
    assert_eq!(keys.get(key.id).await.unwrap().used, Some(now));
}

async fn sign_ins_of_a_person_are_bounded_revoked_and_forgotten(on: On) {
    let bench = Bench::new(on).await;
    let keys = bench.store.keys();
    let end = bench.store.now() + Duration::from_secs(60);
    let of = |person: &str| NewKey {
        owner: "ada".to_owned(),
        expires: Some(end),
        signed_in_as: Some(person.to_owned()),
        ..new("sign-in")
    };
    let robot = keys.create(NewKey { owner: "ada".to_owned(), ..new("robot") }).await.unwrap();
    let other = keys.sign_in(of("issuer 2")).await.unwrap();
    let first = keys.sign_in(of("issuer 1")).await.unwrap();
    assert_eq!(first.signed_in_as.as_deref(), Some("issuer 1"));
    for _ in 0..sign_ins::MOST_SIGN_INS {
        bench.clock.advance(Duration::from_millis(1));
        keys.sign_in(of("issuer 1")).await.unwrap();
    }
    assert!(matches!(keys.get(first.id).await, Err(Error::NotFound { .. })), "the oldest");
    assert_eq!(keys.all().await.unwrap().len(), 2 + sign_ins::MOST_SIGN_INS as usize);

    assert_eq!(keys.revoke_sign_ins("grace").await.unwrap(), 0);
    assert_eq!(keys.revoke_sign_ins("ada").await.unwrap(), 1 + sign_ins::MOST_SIGN_INS as u64);
    assert_eq!(keys.revoke_sign_ins("ada").await.unwrap(), 0);
    assert!(keys.get(other.id).await.unwrap().revoked.is_some());
    assert_eq!(keys.get(robot.id).await.unwrap().revoked, None);

    assert_eq!(keys.forget_sign_ins(end).await.unwrap(), 0);
    let later = end + Duration::from_secs(1);
    keys.forget_sign_ins(later).await.unwrap();
    assert_eq!(keys.all().await.unwrap(), [robot]);
}
