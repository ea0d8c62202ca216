use std::time::Duration;

use super::*;
use crate::{
    Creator, Error, NewCapture, NewFit, NewResumableUpload, NewTwin, Staged, TwinFacts,
    UploadBounds,
    database::testing::{On, on_databases},
    store::tests::{Bench, new_capture, new_fit},
    uploads::tests::new as new_upload,
};

on_databases! {
    owners_have_separate_ids_of_everything,
    an_id_is_stored_as_it_was_given_unless_another_owner_has_it,
    rows_of_earlier_versions_are_those_of_their_owner,
    deleted_ids_are_those_of_their_owner,
    an_upload_keeps_the_deleted_id_of_its_owner,
}

const BOUNDS: UploadBounds = UploadBounds { count: 9, bytes: 1 << 30 };

fn key() -> Option<String> {
    Some("key".to_owned())
}

fn creator(owner: &str) -> Creator {
    Creator { owner: owner.to_owned(), ..Creator::default() }
}

fn capture_of(owner: &str, content: Staged) -> NewCapture {
    let creator = creator(owner);
    NewCapture { request_id: key(), creator, ..new_capture("rope", content) }
}

fn twin_of(owner: &str, content: Staged) -> NewTwin {
    NewTwin {
        display_name: "rope".to_owned(),
        request_id: key(),
        facts: TwinFacts { quality: "{}".to_owned(), ..TwinFacts::default() },
        content,
        creator: creator(owner),
    }
}

/// The texts of a column, sorted.
async fn stored(bench: &Bench, select: &'static str) -> Vec<String> {
    query_scalar(select).fetch_all(bench.store.inner.database.read()).await.unwrap()
}

async fn owners_have_separate_ids_of_everything(on: On) {
    let bench = Bench::new(on).await;
    let store = &bench.store;
    let mut seen = Vec::new();
    for owner in ["ada", "eve"] {
        let capture = capture_of(owner, bench.stage(owner).await);
        let capture = store.captures().create(capture).await.unwrap();
        let again = capture_of(owner, bench.stage(owner).await);
        assert_eq!(store.captures().create(again).await.unwrap(), capture);
        let other = capture_of(owner, bench.stage("other").await);
        let taken = store.captures().create(other).await;
        let Err(Error::RequestIdTaken { request_id, name }) = taken else { panic!("{taken:?}") };
        assert_eq!((request_id.as_str(), name), ("key", capture.id.to_string()));

        let new = NewFit { request_id: key(), creator: creator(owner), ..new_fit(&capture) };
        let fit = store.jobs().create_fit(new.clone()).await.unwrap();
        assert_eq!(store.jobs().create_fit(new.clone()).await.unwrap(), fit);
        assert_eq!((fit.owner.as_str(), fit.request_id), (owner, key()));
        let taken = store.jobs().create_fit(NewFit { priority: 1, ..new }).await;
        assert!(matches!(taken, Err(Error::RequestIdTaken { .. })));

        let twin = twin_of(owner, bench.stage("a twin").await);
        let twin = store.twins().create(twin).await.unwrap();
        let again = twin_of(owner, bench.stage("a twin").await);
        assert_eq!(store.twins().create(again).await.unwrap(), twin);

        let upload = NewResumableUpload { creator: creator(owner), ..new_upload(owner) };
        let begun = store.uploads().create(upload.clone(), BOUNDS).await.unwrap();
        assert_eq!(store.uploads().create(upload, BOUNDS).await.unwrap().id, begun.id);
        assert_eq!(begun.request_id, key());
        seen.push((capture.id, fit.id, twin.id, begun.id));
    }
    let (ada, eve) = (seen[0], seen[1]);
    assert!(ada.0 != eve.0 && ada.1 != eve.1 && ada.2 != eve.2 && ada.3 != eve.3);
}

async fn an_id_is_stored_as_it_was_given_unless_another_owner_has_it(on: On) {
    let bench = Bench::new(on).await;
    let captures = bench.store.captures();
    let first = captures.create(capture_of("ada", bench.stage("a").await)).await.unwrap();
    captures.create(capture_of("eve", bench.stage("b").await)).await.unwrap();
    let select = "select request_id from captures order by request_id";
    assert_eq!(stored(&bench, select).await, ["key", "key\u{1f}eve"]);
    captures.delete(first.id).await.unwrap();
    // Free again, and the second owner still finds the row.
    captures.create(capture_of("bob", bench.stage("c").await)).await.unwrap();
    assert_eq!(stored(&bench, select).await, ["key", "key\u{1f}eve"]);
    let taken = captures.create(capture_of("eve", bench.stage("d").await)).await;
    assert!(matches!(taken, Err(Error::RequestIdTaken { .. })));
}

async fn rows_of_earlier_versions_are_those_of_their_owner(on: On) {
    let bench = Bench::new(on).await;
    let captures = bench.store.captures();
    let old = captures.create(capture_of("ada", bench.stage("a").await)).await.unwrap();
    assert_eq!(stored(&bench, "select request_id from captures").await, ["key"]);
    let again = captures.create(capture_of("ada", bench.stage("a").await)).await.unwrap();
    assert_eq!(again.id, old.id);
    let other = captures.create(capture_of("eve", bench.stage("a").await)).await.unwrap();
    assert_ne!(other.id, old.id);
    // What an earlier version notes of a deletion has no owner, and counts for all.
    let mut tx = bench.store.inner.database.write().await.unwrap();
    query(
        "insert into deleted_requests (kind, request_id, name, until_at)
         values ('twins', 'key', 'twins/1', 0)",
    )
    .execute(&mut tx)
    .await
    .unwrap();
    tx.commit().await.unwrap();
    for owner in ["ada", "eve"] {
        let late = bench.store.twins().create(twin_of(owner, bench.stage("t").await)).await;
        assert!(matches!(late, Err(Error::DeletedSince { .. })));
    }
}

async fn deleted_ids_are_those_of_their_owner(on: On) {
    let bench = Bench::new(on).await;
    let (captures, jobs) = (bench.store.captures(), bench.store.jobs());
    let ada = captures.create(capture_of("ada", bench.stage("a").await)).await.unwrap();
    let new = NewFit { request_id: key(), creator: creator("ada"), ..new_fit(&ada) };
    let fit = jobs.create_fit(new.clone()).await.unwrap();
    jobs.delete(fit.id.fit().unwrap()).await.unwrap();
    captures.delete(ada.id).await.unwrap();
    let late = captures.create(capture_of("ada", bench.stage("a").await)).await;
    let Err(Error::DeletedSince { request_id, name }) = late else { panic!("{late:?}") };
    assert_eq!((request_id.as_str(), name), ("key", ada.id.to_string()));
    assert!(matches!(jobs.create_fit(new).await, Err(Error::DeletedSince { .. })));
    // Others never used the id.
    let eve = captures.create(capture_of("eve", bench.stage("a").await)).await.unwrap();
    let new = NewFit { request_id: key(), creator: creator("eve"), ..new_fit(&eve) };
    jobs.create_fit(new).await.unwrap();
}

/// An upload lives longer than a deleted id is kept, whichever way both are stored.
async fn an_upload_keeps_the_deleted_id_of_its_owner(on: On) {
    let bench = Bench::new(on).await;
    let (captures, uploads) = (bench.store.captures(), bench.store.uploads());
    for owner in ["ada", "eve"] {
        let upload = NewResumableUpload { creator: creator(owner), ..new_upload("whole") };
        uploads.create(upload, BOUNDS).await.unwrap();
        let made = captures.create(capture_of(owner, bench.stage("whole").await)).await.unwrap();
        captures.delete(made.id).await.unwrap();
    }
    let select = "select request_id from deleted_requests order by request_id";
    let both = ["key\u{1f}ada", "key\u{1f}eve"];
    assert_eq!(stored(&bench, select).await, both);
    bench.clock.advance(Duration::from_secs(2 * 86_400));
    bench.store.collect_garbage().await.unwrap();
    assert_eq!(stored(&bench, select).await, both);
}
