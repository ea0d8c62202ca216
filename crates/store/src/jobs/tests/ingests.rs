use std::time::Duration;

use bendtwin_core::{Category, Problem as _, ids::WorkerId};

use super::{fault, progress};
use crate::{
    AttemptEnd, Capture, Error, IngestOutcome, IngestResult, Job, Kind, Lease, NewIngest,
    NewReport, Requirements, State, WorkerEnd,
    database::testing::{On, on_both},
    failpoint::Failpoint,
    sql::query,
    store::tests::{Bench, LEASE, lease_of, new_fit},
};

on_both! {
    a_capture_is_made_with_its_ingest_and_fits_wait_for_it,
    what_fails_the_ingest_fails_its_fits_and_keeps_the_report,
    masks_alone_are_a_success_without_anything_to_fit,
    a_refused_ingest_replaces_what_it_made_and_nothing_else,
    a_cancelled_ingest_says_so_to_fits,
    stalled_ingests_fail_and_checkpoints_go_with_them,
    a_deleted_capture_leaves_nothing,
    captures_from_before_get_their_ingest_at_the_next_start,
    a_capture_without_a_playback_says_that_its_ingest_makes_one,
    an_ingests_end_survives_crashes,
    small_captures_are_read_before_large_ones_that_wait_no_longer_than_they_take,
}

async fn report(bench: &Bench, verdict: &str) -> NewReport {
    let (json, html) = (bench.stage("{}").await, bench.stage("<p>").await);
    NewReport { verdict: verdict.to_owned(), json, html }
}

async fn observe(bench: &Bench, lease: Lease, content: &'static str) -> crate::Result<Job> {
    bench.store.jobs().end_ingest(lease, observed(bench, content).await).await
}

async fn observed(bench: &Bench, content: &'static str) -> IngestResult {
    IngestResult {
        outcome: IngestOutcome::Observed(Box::new(bench.stage(content).await)),
        playback: Some(bench.stage("played").await),
        masks: None,
        report: report(bench, "good").await,
    }
}

/// The end of an ingest up to the masks.
async fn masked(bench: &Bench, masks: &'static str) -> IngestResult {
    let (outcome, masks) = (IngestOutcome::Masked, Some(bench.stage(masks).await));
    IngestResult { outcome, masks, ..observed(bench, "").await }
}

/// The end of an ingest whose capture cannot be fitted, without anything but the report.
async fn refused(bench: &Bench) -> IngestResult {
    let outcome = IngestOutcome::Refused(AttemptEnd::FailedForGood(fault()));
    let report = report(bench, "unusable").await;
    IngestResult { outcome, playback: None, masks: None, report }
}

fn again(capture: &Capture) -> NewIngest {
    NewIngest {
        capture: capture.id,
        settings: "{\"a\":1}".to_owned(),
        request_id: None,
        trace_parent: None,
        creator: crate::Creator::default(),
        requirements: Requirements::default(),
    }
}

async fn a_capture_is_made_with_its_ingest_and_fits_wait_for_it(on: On) {
    let bench = Bench::new(on).await;
    let capture = bench.fresh_capture("a").await;
    let fit = bench.store.jobs().create_fit(new_fit(&capture)).await.unwrap();
    assert!(bench.claim(Kind::Fit).await.is_none());
    let ingest = bench.claim(Kind::Ingest).await.unwrap();
    assert_eq!((ingest.capture, ingest.id.kind()), (capture.id, Kind::Ingest));
    assert!(bench.claim(Kind::Fit).await.is_none() && bench.claim(Kind::Ingest).await.is_none());
    // Others' fits do not wait.
    let other = bench.capture("b").await;
    let free = bench.store.jobs().create_fit(new_fit(&other)).await.unwrap();
    assert_eq!(bench.claim(Kind::Fit).await.unwrap().id, free.id);

    // The epoch alone is no lease.
    let guessed = Lease { worker: WorkerId::generate(), ..lease_of(&ingest) };
    let guessed = observe(&bench, guessed, "guessed").await;
    assert!(matches!(guessed, Err(Error::StaleLease { .. })));
    let ended = observe(&bench, lease_of(&ingest), "seen").await.unwrap();
    assert_eq!(ended.state, State::Succeeded);
    // As if the reply was lost.
    assert_eq!(observe(&bench, lease_of(&ingest), "seen").await.unwrap(), ended);
    let other = observe(&bench, lease_of(&ingest), "other").await;
    assert!(matches!(other, Err(Error::StaleLease { .. })));
    let overview = bench.store.captures().overview(capture.id).await.unwrap();
    assert_eq!(overview.report.unwrap().verdict, "good");
    assert_eq!(bench.store.captures().overviews(&Default::default()).await.unwrap().items.len(), 2);
    bench.store.captures().observation_content(capture.id).await.unwrap();
    let playback = bench.store.captures().playback_content(capture.id).await.unwrap();
    assert_eq!(playback.size_bytes, 6);
    assert_eq!(bench.claim(Kind::Fit).await.unwrap().id, fit.id);
    // Two captures, an observation, a playback, a document and a page.
    assert_eq!(bench.blob_count().await, 6);
}

async fn what_fails_the_ingest_fails_its_fits_and_keeps_the_report(on: On) {
    let bench = Bench::new(on).await;
    let capture = bench.fresh_capture("a").await;
    let jobs = bench.store.jobs();
    let waiting = jobs.create_fit(new_fit(&capture)).await.unwrap();
    let lease = lease_of(&bench.claim(Kind::Ingest).await.unwrap());
    let result = refused(&bench).await;
    assert_eq!(jobs.end_ingest(lease, result).await.unwrap().state, State::Failed);
    let later = jobs.create_fit(new_fit(&capture)).await.unwrap();
    for fit in [waiting.id, later.id] {
        let fit = jobs.get(fit).await.unwrap();
        assert_eq!((fit.state, fit.fault), (State::Failed, Some(fault())));
        assert!(fit.ended.is_some());
    }
    let overview = bench.store.captures().overview(capture.id).await.unwrap();
    assert_eq!(overview.report.unwrap().verdict, "unusable");
    let none = bench.store.captures().observation_content(capture.id).await;
    assert!(matches!(none, Err(Error::NotFound { .. })));

    // A new run may do better; its revisions continue the count.
    let new = jobs.create_ingest(again(&capture)).await.unwrap();
    assert!(new.revision > overview.ingest.revision && new.settings == "{\"a\":1}");
    let early = jobs.create_ingest(again(&capture)).await;
    assert!(matches!(early, Err(Error::IngestUnderWay { .. })));
    let lease = lease_of(&bench.claim(Kind::Ingest).await.unwrap());
    observe(&bench, lease, "seen").await.unwrap();
    let fit = jobs.create_fit(new_fit(&capture)).await.unwrap();
    assert_eq!(fit.state, State::Queued);
    // A fit does not see two observations.
    let refused = jobs.create_ingest(again(&capture)).await;
    assert!(matches!(refused, Err(Error::CaptureInUse { fits: 1, .. })));
}

async fn masks_alone_are_a_success_without_anything_to_fit(on: On) {
    let bench = Bench::new(on).await;
    let capture = bench.fresh_capture("a").await;
    let (jobs, captures) = (bench.store.jobs(), bench.store.captures());
    let missing = captures.masks_content(capture.id).await.err().unwrap();
    assert_eq!(
        (missing.category(), missing.reason()),
        (Category::NotFound, "CAPTURE_HAS_NO_MASKS")
    );
    observe(&bench, lease_of(&bench.claim(Kind::Ingest).await.unwrap()), "seen").await.unwrap();

    jobs.create_ingest(again(&capture)).await.unwrap();
    let waiting = jobs.create_fit(new_fit(&capture)).await.unwrap();
    let lease = lease_of(&bench.claim(Kind::Ingest).await.unwrap());
    let ended = jobs.end_ingest(lease, masked(&bench, "masks").await).await.unwrap();
    assert_eq!((ended.state, ended.masks_only), (State::Succeeded, true));
    // As if the reply was lost; other masks are another result.
    assert_eq!(jobs.end_ingest(lease, masked(&bench, "masks").await).await.unwrap(), ended);
    for other in [masked(&bench, "others").await, observed(&bench, "seen").await] {
        let other = jobs.end_ingest(lease, other).await;
        assert!(matches!(other, Err(Error::StaleLease { .. })), "{other:?}");
    }
    let overview = captures.overview(capture.id).await.unwrap();
    assert!(overview.has_masks && overview.report.is_some());
    assert!(captures.overviews(&Default::default()).await.unwrap().items[0].has_masks);
    assert_eq!(captures.masks_content(capture.id).await.unwrap().size_bytes, 5);
    captures.playback_content(capture.id).await.unwrap();
    let none = captures.observation_content(capture.id).await;
    assert!(matches!(none, Err(Error::NotFound { .. })));
    let waiting = jobs.get(waiting.id).await.unwrap();
    let reason = waiting.fault.unwrap().reason;
    assert_eq!((waiting.state, reason.as_str()), (State::Failed, "CAPTURE_NOT_LIFTED"));
    let early = jobs.create_fit(new_fit(&capture)).await.unwrap_err();
    assert_eq!(
        (early.category(), early.reason()),
        (Category::FailedPrecondition, "CAPTURE_NOT_LIFTED")
    );
    // The archive, masks, playback, a document and a page.
    assert_eq!(bench.blob_count().await, 5);

    jobs.create_ingest(again(&capture)).await.unwrap();
    let fit = jobs.create_fit(new_fit(&capture)).await.unwrap();
    let lease = lease_of(&bench.claim(Kind::Ingest).await.unwrap());
    let both =
        IngestResult { masks: Some(bench.stage("masks").await), ..observed(&bench, "seen").await };
    let ended = jobs.end_ingest(lease, both).await.unwrap();
    assert_eq!((ended.state, ended.masks_only), (State::Succeeded, false));
    assert_eq!(bench.claim(Kind::Fit).await.unwrap().id, fit.id);
    captures.masks_content(capture.id).await.unwrap();
    let worker = jobs.get(fit.id).await.unwrap().worker.unwrap();
    jobs.cancel(fit.id).await.unwrap();
    jobs.forfeit(worker, WorkerEnd::Lost).await.unwrap();

    // One without strokes makes none.
    jobs.create_ingest(again(&capture)).await.unwrap();
    observe(&bench, lease_of(&bench.claim(Kind::Ingest).await.unwrap()), "seen").await.unwrap();
    assert!(!captures.overview(capture.id).await.unwrap().has_masks);
    captures.delete(capture.id).await.unwrap();
    assert_eq!(bench.blob_count().await, 0);
}

async fn a_refused_ingest_replaces_what_it_made_and_nothing_else(on: On) {
    let bench = Bench::new(on).await;
    let capture = bench.fresh_capture("a").await;
    let (jobs, captures) = (bench.store.jobs(), bench.store.captures());
    let end = async |result: IngestResult| {
        let lease = lease_of(&bench.claim(Kind::Ingest).await.unwrap());
        jobs.end_ingest(lease, result).await.unwrap();
        jobs.create_ingest(again(&capture)).await.unwrap();
    };
    let sizes = async || {
        let playback = captures.playback_content(capture.id).await.map(|c| c.size_bytes).ok();
        (playback, captures.masks_content(capture.id).await.map(|c| c.size_bytes).ok())
    };
    // Images without points, for a recording that cannot be fitted yet.
    let images = Some(bench.stage("images").await);
    end(IngestResult { playback: images, ..refused(&bench).await }).await;
    assert_eq!(sizes().await, (Some(6), None));
    let masks = Some(bench.stage("masks").await);
    end(IngestResult { masks, ..observed(&bench, "seen").await }).await;
    end(refused(&bench).await).await;
    assert_eq!(sizes().await, (Some(6), Some(5)));
    captures.observation_content(capture.id).await.unwrap();
    let masks = Some(bench.stage("better masks").await);
    end(IngestResult { masks, ..refused(&bench).await }).await;
    assert_eq!(sizes().await, (Some(6), Some(12)));
    captures.observation_content(capture.id).await.unwrap();
    // The archive, observation, playback, masks, a document and a page.
    assert_eq!(bench.blob_count().await, 6);
}

async fn a_cancelled_ingest_says_so_to_fits(on: On) {
    let bench = Bench::new(on).await;
    let capture = bench.fresh_capture("a").await;
    let jobs = bench.store.jobs();
    let fit = jobs.create_fit(new_fit(&capture)).await.unwrap();
    let ingest = jobs.ingest_of(capture.id).await.unwrap();
    assert_eq!(jobs.cancel(ingest.id).await.unwrap().state, State::Cancelled);
    let fit = jobs.get(fit.id).await.unwrap();
    assert_eq!(
        (fit.state, fit.fault.unwrap().reason.as_str()),
        (State::Failed, "INGEST_CANCELLED")
    );
}

async fn stalled_ingests_fail_and_checkpoints_go_with_them(on: On) {
    let bench = Bench::new(on).await;
    let capture = bench.fresh_capture("a").await;
    let fit = bench.store.jobs().create_fit(new_fit(&capture)).await.unwrap();
    for attempt in 0..4 {
        let ingest = bench.claim(Kind::Ingest).await.unwrap();
        if attempt == 0 {
            let checkpoint = bench.stage("half way").await;
            let jobs = bench.store.jobs();
            jobs.report(lease_of(&ingest), Some(&progress(0.5)), LEASE).await.unwrap();
            jobs.save_checkpoint(lease_of(&ingest), checkpoint, LEASE).await.unwrap();
        }
        assert_eq!(ingest.checkpoint.is_some(), attempt > 0);
        bench.store.jobs().forfeit(ingest.worker.unwrap(), WorkerEnd::Lost).await.unwrap();
    }
    assert!(bench.claim(Kind::Ingest).await.is_none());
    let fit = bench.store.jobs().get(fit.id).await.unwrap();
    assert_eq!((fit.state, fit.fault.unwrap().reason.as_str()), (State::Failed, "WORKER_LOST"));
    assert_eq!(bench.blob_count().await, 1);
}

async fn a_deleted_capture_leaves_nothing(on: On) {
    let bench = Bench::new(on).await;
    let done = bench.fresh_capture("a").await;
    observe(&bench, lease_of(&bench.claim(Kind::Ingest).await.unwrap()), "seen").await.unwrap();
    let under_way = bench.fresh_capture("b").await;
    let lease = lease_of(&bench.claim(Kind::Ingest).await.unwrap());
    let checkpoint = bench.stage("half way").await;
    bench.store.jobs().save_checkpoint(lease, checkpoint, LEASE).await.unwrap();
    for capture in [done, under_way] {
        bench.store.captures().delete(capture.id).await.unwrap();
    }
    let gone = bench.store.jobs().report(lease, None, LEASE).await;
    assert!(matches!(gone, Err(Error::NotFound { .. })));
    assert!(observe(&bench, lease, "late").await.is_err());
    assert_eq!(bench.blob_count().await, 0);
}

async fn captures_from_before_get_their_ingest_at_the_next_start(on: On) {
    let bench = Bench::new(on).await;
    let old = bench.capture("a").await;
    bench.tell(query("delete from jobs")).await;
    let bench = bench.reopen().await;
    assert_eq!(bench.store.jobs().ingest_of(old.id).await.unwrap().state, State::Queued);
    let bench = bench.reopen().await;
    assert_eq!(bench.store.jobs().depth().await.unwrap().count(Kind::Ingest, State::Queued), 1);
}

async fn a_capture_without_a_playback_says_that_its_ingest_makes_one(on: On) {
    let bench = Bench::new(on).await;
    let capture = bench.fresh_capture("a").await;
    let playback = async || bench.store.captures().playback_content(capture.id).await;
    let missing = playback().await.err().unwrap();
    assert_eq!((missing.category(), missing.reason()), (Category::NotFound, "PLAYBACK_MISSING"));
    assert!(missing.to_string().contains("ingest again"), "{missing}");
    observe(&bench, lease_of(&bench.claim(Kind::Ingest).await.unwrap()), "seen").await.unwrap();
    playback().await.unwrap();
    // A worker from before makes none, and the old one is not of the new observation.
    bench.store.jobs().create_ingest(again(&capture)).await.unwrap();
    let lease = lease_of(&bench.claim(Kind::Ingest).await.unwrap());
    let result = IngestResult { playback: None, ..observed(&bench, "anew").await };
    bench.store.jobs().end_ingest(lease, result).await.unwrap();
    assert!(matches!(playback().await, Err(Error::PlaybackMissing { .. })));
    // The archive, an observation, a document and a page.
    assert_eq!(bench.blob_count().await, 4);
    bench.store.captures().delete(capture.id).await.unwrap();
    assert!(matches!(playback().await, Err(Error::NotFound { .. })));
}

/// A crash at any point of an ingest's end: the worker repeats its call, and all of it is stored.
async fn an_ingests_end_survives_crashes(on: On) {
    for point in Failpoint::ALL {
        let bench = Bench::new(on).await;
        let capture = bench.fresh_capture("a").await;
        let lease = lease_of(&bench.claim(Kind::Ingest).await.unwrap());
        let checkpoint = bench.stage("checkpoint").await;
        bench.store.jobs().save_checkpoint(lease, checkpoint, LEASE).await.unwrap();
        let result = observed(&bench, "seen").await;
        bench.store.inner.armed.arm(point);
        assert!(bench.store.jobs().end_ingest(lease, result).await.is_err(), "{point:?}");

        let bench = bench.reopen().await;
        assert_eq!(observe(&bench, lease, "seen").await.unwrap().state, State::Succeeded);
        bench.store.captures().observation_content(capture.id).await.unwrap();
        for page in [false, true] {
            bench.store.captures().report_content(capture.id, page).await.unwrap();
        }
        bench.store.captures().playback_content(capture.id).await.unwrap();
        assert_eq!(bench.reopen().await.blob_count().await, 5, "{point:?}");
    }
}

/// A capture of gigabytes does not delay the report of a small one, nor is it delayed for ever.
async fn small_captures_are_read_before_large_ones_that_wait_no_longer_than_they_take(on: On) {
    let bench = Bench::new(on).await;
    let sized = async |content: &'static str, bytes: i64| {
        let capture = bench.fresh_capture(content).await;
        let size = "update captures set size_bytes = $2 where id = $1";
        bench.tell(query(size).bind(capture.id.uuid().to_string()).bind(bytes)).await;
        // Queued again, with that size.
        let ingest = bench.store.jobs().ingest_of(capture.id).await.unwrap();
        bench.store.jobs().cancel(ingest.id).await.unwrap();
        bench.store.jobs().create_ingest(again(&capture)).await.unwrap();
        capture.id
    };
    let next = async || bench.claim(Kind::Ingest).await.map(|job| job.capture);
    let huge = sized("huge", 1 << 40).await;
    let large = sized("large", 200_000_000).await;
    let small = sized("small", 1_000).await;
    bench.clock.advance(Duration::from_secs(100));
    let later = sized("later", 1_000).await;
    assert_eq!(next().await, Some(small));
    assert_eq!(next().await, Some(later));
    // 200 s after the large one, those that come now are behind it.
    bench.clock.advance(Duration::from_secs(101));
    let last = sized("last", 1_000).await;
    assert_eq!(next().await, Some(large));
    // Ten minutes after the huge one, regardless of size.
    bench.clock.advance(Duration::from_secs(400));
    let never = sized("never", 1_000).await;
    assert_eq!(next().await, Some(last));
    assert_eq!(next().await, Some(huge));
    assert_eq!(next().await, Some(never));
    assert_eq!(next().await, None);
}
