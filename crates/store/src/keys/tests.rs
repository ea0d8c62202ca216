use std::time::Duration;

use super::*;
use crate::{
    database::testing::{On, on_both},
    store::tests::Bench,
};

on_both! {
    keys_are_stored_listed_and_revoked,
    the_last_use_does_not_go_back,
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
