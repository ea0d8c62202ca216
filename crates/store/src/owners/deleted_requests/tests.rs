use bendtwin_core::{Category, Problem as _};

use super::*;
use crate::{
    Creator, NewCapture, NewFit, NewIngest, NewTwin, Requirements, Staged, TwinFacts,
    database::testing::{On, on_both},
    store::tests::{Bench, new_capture, new_fit},
};

on_both! {
    a_late_attempt_makes_no_capture_again,
    a_late_attempt_makes_no_twin_again,
    a_late_attempt_queues_no_fit_again,
    a_late_attempt_runs_no_ingest_again,
    an_id_is_kept_for_a_day,
}

fn key() -> Option<String> {
    Some("key".to_owned())
}

fn capture_of(content: Staged) -> NewCapture {
    NewCapture { request_id: key(), ..new_capture("rope", content) }
}

fn twin_of(content: Staged) -> NewTwin {
    NewTwin {
        display_name: "rope".to_owned(),
        request_id: key(),
        facts: TwinFacts { quality: "{}".to_owned(), ..TwinFacts::default() },
        content,
        creator: Creator::default(),
    }
}

#[track_caller]
fn assert_deleted<T: std::fmt::Debug>(late: Result<T>, of: &str) {
    let error = late.unwrap_err();
    assert_eq!((error.category(), error.reason()), (Category::AlreadyExists, "DELETED_SINCE"));
    let reported = error.to_string();
    assert!(reported.contains(of) && reported.contains("choose a new request id"), "{reported}");
}

/// The first attempt has its content, and stands still; the second is answered.
async fn a_late_attempt_makes_no_capture_again(on: On) {
    let bench = Bench::new(on).await;
    let captures = bench.store.captures();
    let late = capture_of(bench.stage("a").await);
    let made = captures.create(capture_of(bench.stage("a").await)).await.unwrap();
    captures.delete(made.id).await.unwrap();
    assert_deleted(captures.create(late).await, &made.id.to_string());
    let repeated = capture_of(bench.stage("a").await);
    assert_deleted(captures.create(repeated).await, &made.id.to_string());
    assert!(captures.list(&Default::default()).await.unwrap().items.is_empty());
    // Ids of twins are others.
    bench.store.twins().create(twin_of(bench.stage("a twin").await)).await.unwrap();
    assert_eq!(bench.blob_count().await, 1, "what came late is not kept");
}

async fn a_late_attempt_makes_no_twin_again(on: On) {
    let bench = Bench::new(on).await;
    let twins = bench.store.twins();
    let late = twin_of(bench.stage("a").await);
    let made = twins.create(twin_of(bench.stage("a").await)).await.unwrap();
    twins.delete(made.id).await.unwrap();
    assert_deleted(twins.create(late).await, &made.id.to_string());
    assert!(twins.list(&Default::default()).await.unwrap().items.is_empty());
    assert_eq!(bench.blob_count().await, 0, "what came late is not kept");
}

async fn a_late_attempt_queues_no_fit_again(on: On) {
    let bench = Bench::new(on).await;
    let capture = bench.capture("a").await;
    let new = NewFit { request_id: key(), ..new_fit(&capture) };
    let made = bench.store.jobs().create_fit(new.clone()).await.unwrap();
    bench.store.jobs().delete(made.id.fit().unwrap()).await.unwrap();
    assert_deleted(bench.store.jobs().create_fit(new.clone()).await, &made.id.to_string());
    assert!(bench.store.jobs().fits(&Default::default()).await.unwrap().items.is_empty());
    let other = NewFit { request_id: Some("other".to_owned()), ..new };
    bench.store.jobs().create_fit(other).await.unwrap();
}

/// An ingest goes with the next one of its capture.
async fn a_late_attempt_runs_no_ingest_again(on: On) {
    let bench = Bench::new(on).await;
    let capture = bench.capture("a").await;
    let ingest = |key: &str| NewIngest {
        capture: capture.id,
        settings: "{}".to_owned(),
        request_id: Some(key.to_owned()),
        trace_parent: None,
        creator: Creator::default(),
        requirements: Requirements::default(),
    };
    let run = async |key: &str| {
        let job = bench.store.jobs().create_ingest(ingest(key)).await?;
        bench.store.jobs().cancel(job.id).await?;
        Ok::<_, Error>(job.id.to_string())
    };
    let first = run("first").await.unwrap();
    let second = run("second").await.unwrap();
    assert_deleted(run("first").await, &first);
    assert_eq!(bench.store.jobs().ingest_of(capture.id).await.unwrap().id.to_string(), second);
}

async fn an_id_is_kept_for_a_day(on: On) {
    let bench = Bench::new(on).await;
    let captures = bench.store.captures();
    let made = captures.create(capture_of(bench.stage("a").await)).await.unwrap();
    captures.delete(made.id).await.unwrap();
    bench.clock.advance(KEPT);
    bench.store.collect_garbage().await.unwrap();
    let late = capture_of(bench.stage("a").await);
    assert_deleted(captures.create(late).await, &made.id.to_string());
    bench.clock.advance(Duration::from_secs(1));
    bench.store.collect_garbage().await.unwrap();
    let anew = captures.create(capture_of(bench.stage("a").await)).await.unwrap();
    // Deleted again, it is kept again.
    captures.delete(anew.id).await.unwrap();
    let late = capture_of(bench.stage("a").await);
    assert_deleted(captures.create(late).await, &anew.id.to_string());
}
