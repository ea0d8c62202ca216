use std::time::Duration;

use bendtwin_core::ids::{ShareId, TwinId};

use super::*;
use crate::{
    database::testing::{On, on_both},
    store::tests::Bench,
};

on_both! {
    keys_are_stored_listed_and_revoked,
    the_last_use_does_not_go_back,
    sign_ins_of_a_person_are_bounded_and_forgotten,
    a_sign_in_ends_those_with_other_rights,
    shares_are_listed_by_twin_and_end_with_the_key_that_made_them,
    shares_of_people_end_when_their_rights_do,
    shares_of_a_twin_are_bounded_and_forgotten,
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

fn sign_in_of(person: &str, bench: &Bench) -> NewKey {
    NewKey {
        owner: "ada".to_owned(),
        expires: Some(bench.store.now() + Duration::from_secs(60)),
        signed_in_as: Some(person.to_owned()),
        ..new("sign-in")
    }
}

async fn sign_ins_of_a_person_are_bounded_and_forgotten(on: On) {
    let bench = Bench::new(on).await;
    let keys = bench.store.keys();
    let end = bench.store.now() + Duration::from_secs(120);
    let robot = keys.create(NewKey { owner: "ada".to_owned(), ..new("robot") }).await.unwrap();
    let other = keys.sign_in(sign_in_of("issuer 2", &bench)).await.unwrap().key;
    let SignedIn { key: first, ended } =
        keys.sign_in(sign_in_of("issuer 1", &bench)).await.unwrap();
    assert_eq!((first.signed_in_as.as_deref(), ended), (Some("issuer 1"), vec![]));
    let mut ended = Vec::new();
    for _ in 0..sign_ins::MOST_SIGN_INS {
        assert_eq!(ended, []);
        bench.clock.advance(Duration::from_millis(1));
        ended = keys.sign_in(sign_in_of("issuer 1", &bench)).await.unwrap().ended;
    }
    let revoked = Some(bench.store.now());
    assert_eq!(ended, [Key { revoked, ..first.clone() }], "the oldest");
    assert_eq!(keys.get(first.id).await.unwrap().revoked, revoked, "its holder signs in again");
    for _ in 0..sign_ins::MOST_STORED {
        bench.clock.advance(Duration::from_millis(1));
        keys.sign_in(sign_in_of("issuer 1", &bench)).await.unwrap();
    }
    let all = keys.all().await.unwrap();
    assert_eq!(all.len(), 2 + sign_ins::MOST_STORED as usize);
    let of_person = |key: &&Key| key.signed_in_as.as_deref() == Some("issuer 1");
    let valid = all.iter().filter(of_person).filter(|key| key.revoked.is_none()).count();
    assert_eq!(valid, sign_ins::MOST_SIGN_INS as usize);
    assert_eq!(keys.get(other.id).await.unwrap().revoked, None, "of another person");

    assert_eq!(keys.forget_ended(other.expires.unwrap()).await.unwrap(), 0);
    let all = 1 + sign_ins::MOST_STORED as u64;
    assert_eq!(keys.forget_ended(end).await.unwrap(), all);
    assert_eq!(keys.all().await.unwrap(), [robot]);
}

async fn a_sign_in_ends_those_with_other_rights(on: On) {
    let bench = Bench::new(on).await;
    let keys = bench.store.keys();
    let order = || sign_in_of("issuer 1", &bench);
    let first = keys.sign_in(order()).await.unwrap().key;
    // The same scopes in another order.
    let same = NewKey { scopes: vec!["captures:read".into(), "twins:read".into()], ..order() };
    let second = keys.sign_in(same).await.unwrap();
    assert_eq!(second.ended, []);
    let narrower = || NewKey { scopes: vec!["twins:read".into()], ..order() };
    let mut ended = keys.sign_in(narrower()).await.unwrap().ended;
    ended.sort_by_key(|key| key.id);
    let now = Some(bench.store.now());
    let mut expected = [first, second.key].map(|key| Key { revoked: now, ..key });
    expected.sort_by_key(|key| key.id);
    assert_eq!(ended, expected);
    assert_eq!(keys.get(ended[0].id).await.unwrap().revoked, now);
    let renamed = NewKey { owner: "ada@example.org".to_owned(), ..narrower() };
    assert_eq!(keys.sign_in(renamed).await.unwrap().ended.len(), 1);
}

fn share_by(by: Option<KeyId>, twin: TwinId, bench: &Bench) -> NewShare {
    let expires = Some(bench.store.now() + Duration::from_secs(60));
    NewShare { key: NewKey { owner: "ada".to_owned(), expires, ..new("share") }, twin, by }
}

async fn shares_are_listed_by_twin_and_end_with_the_key_that_made_them(on: On) {
    let bench = Bench::new(on).await;
    let keys = bench.store.keys();
    let (twin, other) = (TwinId::generate(), TwinId::generate());
    let ada = keys.create(new("ada")).await.unwrap();
    let first = keys.share(share_by(Some(ada.id), twin, &bench)).await.unwrap();
    let by = Some(ada.id.uuid().to_string());
    assert_eq!(first.share, Some(Share { twin, by }));
    let second = keys.share(share_by(None, twin, &bench)).await.unwrap();
    assert_eq!(second.share, Some(Share { twin, by: None }));
    let elsewhere = keys.share(share_by(Some(ada.id), other, &bench)).await.unwrap();

    let mut page = PageRequest { size: 1, token: String::new() };
    let listed = keys.shares_of(twin, &page).await.unwrap();
    assert_eq!(listed.items, std::slice::from_ref(&second));
    page.token = listed.next_token;
    assert_eq!(keys.shares_of(twin, &page).await.unwrap().items, std::slice::from_ref(&first));
    assert!(keys.shares_of(other, &page).await.is_err(), "a token of another list");
    let id = |key: &Key| ShareId::from(key.id.uuid());
    assert_eq!(keys.get_share(id(&first)).await.unwrap().0, first);
    for missing in [id(&ada), ShareId::generate()] {
        let found = keys.get_share(missing).await;
        assert!(matches!(found, Err(Error::NotFound { name }) if name == missing.to_string()));
    }

    // The revocation of a share ends nothing else.
    assert_eq!(keys.revoke_with_shares(second.id).await.unwrap().len(), 1);
    let mut revoked = keys.revoke_with_shares(ada.id).await.unwrap();
    revoked[1..].sort_by_key(|key| key.id);
    let now = Some(bench.store.now());
    let expected = [&ada, &first, &elsewhere].map(|key| Key { revoked: now, ..key.clone() });
    assert_eq!(revoked, expected);
    let refused = keys.share(share_by(Some(ada.id), twin, &bench)).await;
    assert!(matches!(refused, Err(Error::NotFound { .. })), "made with a key that is revoked");
}

async fn shares_of_people_end_when_their_rights_do(on: On) {
    let bench = Bench::new(on).await;
    let (keys, twin) = (bench.store.keys(), TwinId::generate());
    let sign_in = || sign_in_of("issuer 1", &bench);
    let first = keys.sign_in(sign_in()).await.unwrap().key;
    let share = keys.share(share_by(Some(first.id), twin, &bench)).await.unwrap();
    assert_eq!(share.share.unwrap().by.as_deref(), Some("issuer 1"));
    // Signing out leaves it, also when they sign in again.
    keys.revoke(first.id).await.unwrap();
    let second = keys.sign_in(sign_in()).await.unwrap();
    assert_eq!(second.ended, []);
    assert_eq!(keys.get(share.id).await.unwrap().revoked, None);
    // Other rights end it, and so does the revocation of any of their sign-ins.
    let other = NewKey { scopes: vec!["twins:read".into()], ..sign_in() };
    let third = keys.sign_in(other).await.unwrap();
    let ended: Vec<_> = third.ended.iter().map(|key| key.id).collect();
    assert_eq!(ended, [second.key.id, share.id]);
    let share = keys.share(share_by(Some(third.key.id), twin, &bench)).await.unwrap();
    let revoked = keys.revoke_with_shares(second.key.id).await.unwrap();
    assert_eq!(revoked.iter().map(|key| key.id).collect::<Vec<_>>(), [second.key.id, share.id]);
}

async fn shares_of_a_twin_are_bounded_and_forgotten(on: On) {
    let bench = Bench::new(on).await;
    let (keys, twin) = (bench.store.keys(), TwinId::generate());
    let mut made = Vec::new();
    for _ in 0..shares::MOST_SHARES {
        bench.clock.advance(Duration::from_millis(1));
        made.push(keys.share(share_by(None, twin, &bench)).await.unwrap());
    }
    let full = keys.share(share_by(None, twin, &bench)).await;
    assert!(matches!(full, Err(Error::TooManyShares { limit: shares::MOST_SHARES, .. })));
    keys.share(share_by(None, TwinId::generate(), &bench)).await.unwrap();
    for _ in made.len()..=shares::MOST_STORED as usize {
        keys.revoke(made.last().unwrap().id).await.unwrap();
        bench.clock.advance(Duration::from_millis(1));
        made.push(keys.share(share_by(None, twin, &bench)).await.unwrap());
    }
    // Those that are valid stay, however old.
    let page = PageRequest { size: 1000, token: String::new() };
    let kept = keys.shares_of(twin, &page).await.unwrap().items;
    let valid = kept.iter().filter(|key| key.revoked.is_none()).count();
    assert_eq!(valid, shares::MOST_SHARES as usize);
    assert!(kept.len() <= (shares::MOST_STORED + shares::MOST_SHARES) as usize, "{}", kept.len());
    let end = bench.store.now() + Duration::from_secs(61);
    keys.forget_ended(end).await.unwrap();
    assert_eq!(keys.all().await.unwrap(), []);
}
