use bendtwin_core::ids::KeyId;

use super::*;
use crate::{
    Creator, Kind, NewCapture, NewFit, NewKey,
    database::testing::{On, on_both},
    sql::query,
    store::tests::{Bench, LEASE, lease_of, new_capture, new_fit},
};

on_both! {
    usage_of_all_owners_is_listed_with_their_bounds,
    sizes_that_rows_lack_are_filled_in,
}

fn creator(owner: &str) -> Creator {
    Creator { owner: owner.to_owned(), ..Creator::default() }
}

async fn key(bench: &Bench, owner: &str, stored_bytes: Option<u64>) -> KeyId {
    let new = NewKey {
        id: KeyId::generate(),
        display_name: "a key".to_owned(),
        owner: owner.to_owned(),
        hash: blake3::hash(b"key"),
        scopes: Vec::new(),
        quotas: Quotas { stored_bytes, ..Quotas::default() },
        expires: None,
        signed_in_as: None,
    };
    bench.store.keys().create(new).await.unwrap().id
}

async fn usage_of_all_owners_is_listed_with_their_bounds(on: On) {
    let bench = Bench::new(on).await;
    let store = &bench.store;
    key(&bench, "ada", Some(100)).await;
    key(&bench, "ada", Some(300)).await;
    let revoked = key(&bench, "ada", None).await;
    store.keys().revoke(revoked).await.unwrap();
    key(&bench, "bob", None).await;
    let content = bench.stage("archive").await;
    let new = NewCapture { creator: creator("ada"), ..new_capture("a", content) };
    let capture = store.captures().create(new).await.unwrap();
    bench.tell(query("update jobs set state = 'succeeded'")).await;
    for _ in 0..3 {
        let new = NewFit { creator: creator("ada"), ..new_fit(&capture) };
        store.jobs().create_fit(new).await.unwrap();
    }
    bench.claim(Kind::Fit).await.unwrap();
    bench.capture("of nobody").await;

    let defaults = Quotas { stored_bytes: Some(5), rollouts: Some(2), ..Quotas::default() };
    let all = store.usage().all(&defaults).await.unwrap();
    let names: Vec<&str> = all.iter().map(|usage| usage.owner.as_str()).collect();
    assert_eq!(names, ["", "ada", "bob"]);
    let ada = OwnerUsage {
        owner: "ada".to_owned(),
        captures: 1,
        fits: 3,
        stored: StoredBytes { captures: 7, ..StoredBytes::default() },
        queued_jobs: 2,
        running_jobs: 1,
        quotas: Quotas { stored_bytes: Some(300), ..defaults },
        ..OwnerUsage::default()
    };
    assert_eq!(all[1], ada);
    assert_eq!((all[2].stored.total(), all[2].quotas), (0, defaults));
    assert_eq!(all[0].stored.captures, 9);
    let alone = store.usage().of("ada").await.unwrap();
    assert_eq!(alone, OwnerUsage { quotas: Quotas::default(), ..ada });

    let mut page = PageRequest { size: 2, token: String::new() };
    let first = store.usage().list(&defaults, &page).await.unwrap();
    assert_eq!(first.items, all[..2]);
    page.token = first.next_token;
    let second = store.usage().list(&defaults, &page).await.unwrap();
    assert_eq!((second.items.as_slice(), second.next_token.as_str()), (&all[2..], ""));
    page.token = "nonsense".to_owned();
    assert!(store.usage().list(&defaults, &page).await.is_err());
}

/// Rows as an older version leaves them, which may run beside this one.
async fn sizes_that_rows_lack_are_filled_in(on: On) {
    let bench = Bench::new(on).await;
    let store = &bench.store;
    let content = bench.stage("archive").await;
    let new = NewCapture { creator: creator("ada"), ..new_capture("a", content) };
    let capture = store.captures().create(new).await.unwrap();
    let lease = lease_of(&bench.claim(Kind::Ingest).await.unwrap());
    let (json, html) = (bench.stage("{}").await, bench.stage("<p>").await);
    let result = crate::IngestResult {
        outcome: crate::IngestOutcome::Observed(Box::new(bench.stage("seen").await)),
        playback: Some(bench.stage("played").await),
        masks: Some(bench.stage("followed").await),
        report: crate::NewReport { verdict: "good".to_owned(), json, html },
    };
    store.jobs().end_ingest(lease, result).await.unwrap();
    let new = NewFit { creator: creator("ada"), ..new_fit(&capture) };
    store.jobs().create_fit(new).await.unwrap();
    let lease = lease_of(&bench.claim(Kind::Fit).await.unwrap());
    store.jobs().save_checkpoint(lease, bench.stage("half way").await, LEASE).await.unwrap();
    let before = store.usage().of("ada").await.unwrap().stored;
    let known = StoredBytes { captures: 7, derived: 23, checkpoints: 8, ..StoredBytes::default() };
    assert_eq!(before, known);
    assert_eq!(store.settle_sizes().await.unwrap(), 0);
    for forget in [
        "update captures set derived_bytes = 0",
        "update reports set size_bytes = null",
        "update jobs set checkpoint_bytes = null",
    ] {
        bench.tell(query(forget)).await;
    }
    assert_eq!(store.usage().of("ada").await.unwrap().stored.total(), 7);
    assert_eq!(store.settle_sizes().await.unwrap(), 3);
    assert_eq!(store.usage().of("ada").await.unwrap().stored, known);
}
