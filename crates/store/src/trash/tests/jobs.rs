//! Jobs that go to the trash and come back.

use super::*;
use crate::{AttemptEnd, IngestOutcome, State};

on_both! {
    a_queued_ingest_waits_again_once_its_capture_is_restored,
    a_running_ingest_is_taken_from_its_worker_and_resumes_from_its_checkpoint,
    a_queued_fit_waits_again_once_it_is_restored,
    a_restored_fit_without_its_capture_is_cancelled,
    a_restored_fit_of_an_unusable_capture_fails,
    what_is_in_use_is_not_deleted,
    restored_jobs_keep_to_the_quota,
}

async fn a_queued_ingest_waits_again_once_its_capture_is_restored(on: On) {
    let bench = Bench::new(on).await;
    let capture = bench.fresh_capture("a").await;
    put(&bench, capture.id).await;
    assert_eq!(bench.claim(Kind::Ingest).await, None);
    restore(&bench, capture.id).await.unwrap();
    let ingest = bench.store.jobs().ingest_of(capture.id).await.unwrap();
    assert_eq!((ingest.state, ingest.ended), (State::Queued, None));
    assert_eq!(bench.claim(Kind::Ingest).await.map(|job| job.capture), Some(capture.id));
}

async fn a_running_ingest_is_taken_from_its_worker_and_resumes_from_its_checkpoint(on: On) {
    let bench = Bench::new(on).await;
    let jobs = bench.store.jobs();
    let capture = bench.fresh_capture("a").await;
    let lease = lease_of(&bench.claim(Kind::Ingest).await.unwrap());
    jobs.save_checkpoint(lease, bench.stage("half way").await, LEASE).await.unwrap();
    put(&bench, capture.id).await;
    assert_in_trash(jobs.report(lease, None, LEASE).await);
    assert_in_trash(jobs.end_attempt(lease, AttemptEnd::Released).await);
    assert!(bench.pass(2 * LEASE).await.is_empty(), "its lease ends nothing");
    bench.store.collect_garbage().await.unwrap();
    restore(&bench, capture.id).await.unwrap();
    assert!(matches!(jobs.report(lease, None, LEASE).await, Err(Error::StaleLease { .. })));
    let again = bench.claim(Kind::Ingest).await.unwrap();
    assert_eq!((again.capture, again.attempts), (capture.id, 1), "the attempt did not count");
    jobs.checkpoint(again.id).await.unwrap();
}

async fn a_queued_fit_waits_again_once_it_is_restored(on: On) {
    let bench = Bench::new(on).await;
    let capture = bench.capture("a").await;
    let fit = bench.store.jobs().create_fit(new_fit(&capture)).await.unwrap();
    put(&bench, fit.id.fit().unwrap()).await;
    assert_eq!(bench.claim(Kind::Fit).await, None);
    restore(&bench, fit.id.fit().unwrap()).await.unwrap();
    assert_eq!(bench.claim(Kind::Fit).await.map(|job| job.id), Some(fit.id));
}

async fn a_restored_fit_without_its_capture_is_cancelled(on: On) {
    let bench = Bench::new(on).await;
    for purged in [false, true] {
        let capture = bench.capture("a").await;
        let fit = bench.store.jobs().create_fit(new_fit(&capture)).await.unwrap();
        let fit = fit.id.fit().unwrap();
        put(&bench, fit).await;
        put(&bench, capture.id).await;
        if purged {
            bench.store.captures().delete(capture.id).await.unwrap();
        }
        restore(&bench, fit).await.unwrap();
        let fit = bench.store.jobs().get(fit).await.unwrap();
        assert_eq!((fit.state, fit.ended.is_some()), (State::Cancelled, true));
        assert_eq!(bench.claim(Kind::Fit).await, None);
    }
}

async fn a_restored_fit_of_an_unusable_capture_fails(on: On) {
    let bench = Bench::new(on).await;
    let jobs = bench.store.jobs();
    let capture = bench.fresh_capture("a").await;
    let fit = jobs.create_fit(new_fit(&capture)).await.unwrap().id.fit().unwrap();
    put(&bench, fit).await;
    let lease = lease_of(&bench.claim(Kind::Ingest).await.unwrap());
    let (json, html) = (bench.stage("{}").await, bench.stage("<p>").await);
    let result = IngestResult {
        outcome: IngestOutcome::Masked,
        playback: None,
        masks: Some(bench.stage("masks").await),
        report: NewReport { verdict: "masks".to_owned(), json, html },
    };
    jobs.end_ingest(lease, result).await.unwrap();
    restore(&bench, fit).await.unwrap();
    let fit = jobs.get(fit).await.unwrap();
    assert_eq!(fit.state, State::Failed);
    assert!(fit.fault.is_some() && fit.ended.is_some());
}

async fn what_is_in_use_is_not_deleted(on: On) {
    let bench = Bench::new(on).await;
    let trash = bench.store.trash();
    let capture = bench.capture("a").await;
    let fit = bench.store.jobs().create_fit(new_fit(&capture)).await.unwrap();
    let refused = trash.put(capture.id, &deletion()).await;
    assert!(matches!(refused, Err(Error::CaptureInUse { fits: 1, .. })));
    bench.claim(Kind::Fit).await.unwrap();
    let refused = trash.put(fit.id.fit().unwrap(), &deletion()).await;
    assert!(matches!(refused, Err(Error::FitRunning { .. })));
    bench.store.captures().get(capture.id).await.unwrap();
    bench.store.jobs().get(fit.id).await.unwrap();
}

async fn restored_jobs_keep_to_the_quota(on: On) {
    let bench = Bench::new(on).await;
    let quotas = crate::Quotas { queued_jobs: Some(1), ..Default::default() };
    let creator = Creator { owner: "ada".to_owned(), quotas };
    let capture = bench.capture("a").await;
    let new = NewFit { creator: creator.clone(), ..new_fit(&capture) };
    let first = bench.store.jobs().create_fit(new.clone()).await.unwrap().id.fit().unwrap();
    put(&bench, first).await;
    bench.store.jobs().create_fit(new).await.unwrap();
    let refused = bench.store.trash().restore(first, &creator).await;
    assert!(matches!(refused, Err(Error::QuotaJobs { .. })));
    assert_in_trash(bench.store.jobs().get(first).await);
}
