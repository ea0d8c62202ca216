use super::*;
use crate::{
    ListQuery, NewCapture, NewFit, NewTwin, TwinFacts,
    database::testing::{On, on_both},
    store::tests::{Bench, lease_of, new_capture, new_fit},
};

on_both! {
    what_is_made_has_its_owner_and_lists_are_filtered_by_it,
    an_owner_has_no_more_jobs_waiting_than_its_key_allows,
    an_owner_has_no_more_stored_than_its_key_allows,
}

fn creator(owner: &str, quotas: Quotas) -> Creator {
    Creator { owner: owner.to_owned(), quotas }
}

async fn what_is_made_has_its_owner_and_lists_are_filtered_by_it(on: On) {
    let bench = Bench::new(on).await;
    let store = &bench.store;
    let ada = creator("ada", Quotas::default());
    let content = bench.stage("a").await;
    let new = NewCapture { creator: ada.clone(), ..new_capture("a", content) };
    let capture = store.captures().create(new).await.unwrap();
    assert_eq!(capture.owner, "ada");
    assert_eq!(store.jobs().ingest_of(capture.id).await.unwrap().owner, "ada");
    let other = bench.capture("b").await;
    assert_eq!(other.owner, "");
    let of = |owner: &str| ListQuery { owner: owner.to_owned(), ..ListQuery::default() };
    assert_eq!(store.captures().list(&of("ada")).await.unwrap().items, [capture]);
    assert_eq!(store.captures().list(&of("")).await.unwrap().items.len(), 2);
    assert!(store.captures().list(&of("eve")).await.unwrap().items.is_empty());

    // A twin is of the owner of its fit.
    let new = NewFit { creator: creator("bob", Quotas::default()), ..new_fit(&other) };
    let fit = store.jobs().create_fit(new).await.unwrap();
    assert_eq!(store.jobs().fits(&of("bob")).await.unwrap().items, [fit]);
    assert!(store.jobs().fits(&of("ada")).await.unwrap().items.is_empty());
    let lease = lease_of(&bench.claim(crate::Kind::Fit).await.unwrap());
    let content = bench.stage("twin").await;
    let twin = store.jobs().complete_fit(lease, &TwinFacts::default(), content).await.unwrap();
    assert_eq!(store.twins().get(twin).await.unwrap().owner, "bob");
    assert_eq!(store.twins().list(&of("bob")).await.unwrap().items.len(), 1);
}

async fn an_owner_has_no_more_jobs_waiting_than_its_key_allows(on: On) {
    let bench = Bench::new(on).await;
    let capture = bench.capture("a").await;
    let quotas = Quotas { queued_jobs: Some(2), ..Quotas::default() };
    let new = NewFit { creator: creator("ada", quotas), ..new_fit(&capture) };
    let jobs = bench.store.jobs();
    let first = jobs.create_fit(new.clone()).await.unwrap();
    jobs.create_fit(new.clone()).await.unwrap();
    let refused = jobs.create_fit(new.clone()).await.unwrap_err();
    assert!(matches!(refused, Error::QuotaJobs { queued: 2, limit: 2, .. }), "{refused}");
    // Others have their own, and what waits no more is not counted.
    let other = NewFit { creator: creator("bob", quotas), ..new_fit(&capture) };
    jobs.create_fit(other).await.unwrap();
    jobs.cancel(first.id).await.unwrap();
    jobs.create_fit(new).await.unwrap();
}

async fn an_owner_has_no_more_stored_than_its_key_allows(on: On) {
    let bench = Bench::new(on).await;
    let store = &bench.store;
    let quotas = Quotas { stored_bytes: Some(8), ..Quotas::default() };
    let upload = async |content: &'static str| {
        let content = bench.stage(content).await;
        let creator = creator("ada", quotas);
        store.captures().create(NewCapture { creator, ..new_capture("a", content) }).await
    };
    let first = upload("123456").await.unwrap();
    let refused = upload("789").await.unwrap_err();
    assert!(matches!(refused, Error::QuotaBytes { stored: 6, more: 3, limit: 8, .. }), "{refused}");
    let twin = async || NewTwin {
        display_name: "a twin".into(),
        request_id: None,
        facts: TwinFacts::default(),
        content: bench.stage("789").await,
        creator: creator("ada", quotas),
    };
    assert!(matches!(store.twins().create(twin().await).await, Err(Error::QuotaBytes { .. })));
    // Refused content leaves nothing behind.
    assert_eq!(bench.blob_count().await, 1);
    store.captures().delete(first.id).await.unwrap();
    store.twins().create(twin().await).await.unwrap();
}
