use std::time::Duration;

use bytes::Bytes;

use super::*;
use crate::{
    Capture, Incoming, IngestOutcome, IngestResult, Kind, ListQuery, NewCapture, NewFit, NewReport,
    NewTwin, Staged, Store, StoredBytes, TwinFacts, Upload,
    database::testing::{On, on_both},
    failpoint::Failpoint,
    store::tests::{Bench, LEASE, lease_of, new_capture, new_fit},
};

on_both! {
    content_of_a_declared_size_has_its_bytes_set_aside_before_it_comes,
    content_of_unknown_size_is_cut_off_before_it_is_written,
    content_that_does_not_come_to_its_end_frees_its_bytes,
    uploads_at_a_time_do_not_exceed_a_quota_together,
    a_crash_leaves_nothing_set_aside,
    what_workers_made_counts_and_is_stored_beyond_the_quota_too,
    a_repetition_takes_no_room,
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

fn bounded(stored_bytes: u64) -> Creator {
    creator("ada", Quotas { stored_bytes: Some(stored_bytes), ..Quotas::default() })
}

fn incoming(creator: Creator, size_bytes: Option<u64>) -> Incoming {
    let (limit, silence) = (1 << 30, Duration::from_secs(60));
    Incoming { creator, jobs: 1, size_bytes, limit, silence, is_repetition: false }
}

async fn write(upload: &mut Upload, bytes: usize) -> Result<()> {
    upload.write(Bytes::from(vec![b'x'; bytes])).await
}

async fn stored(store: &Store) -> StoredBytes {
    store.usage().of("ada").await.unwrap().stored
}

/// Waits until this number of bytes is set aside: a separate task releases them.
async fn set_aside(store: &Store, bytes: u64) {
    let deadline = tokio::time::Instant::now() + Duration::from_secs(20);
    while stored(store).await.uploads != bytes {
        assert!(tokio::time::Instant::now() < deadline, "{:?}", stored(store).await);
        tokio::task::yield_now().await;
    }
}

async fn capture_of(store: &Store, content: Staged, creator: Creator) -> Result<Capture> {
    store.captures().create(NewCapture { creator, ..new_capture("a", content) }).await
}

/// Bytes of all files below the folder of content, wherever they are.
fn bytes_on_disk(bench: &Bench) -> u64 {
    fn sum(path: &std::path::Path) -> u64 {
        let Ok(entries) = std::fs::read_dir(path) else { return 0 };
        let size = |entry: std::fs::DirEntry| match entry.path().is_dir() {
            true => sum(&entry.path()),
            false => entry.metadata().map_or(0, |file| file.len()),
        };
        entries.flatten().map(size).sum()
    }
    let identity = std::fs::metadata(bench.dir.path().join("blobs/identity"));
    sum(&bench.dir.path().join("blobs")) - identity.map_or(0, |file| file.len())
}

async fn content_of_a_declared_size_has_its_bytes_set_aside_before_it_comes(on: On) {
    let bench = Bench::new(on).await;
    let store = &bench.store;
    let mut first = store.receive(incoming(bounded(8), Some(6))).await.unwrap();
    assert_eq!(stored(store).await.uploads, 6);
    let refused = store.receive(incoming(bounded(8), Some(3))).await.unwrap_err();
    assert!(matches!(refused, Error::QuotaBytes { stored: 6, more: 3, limit: 8, .. }), "{refused}");
    let limit = store.receive(incoming(bounded(u64::MAX), Some(2 << 30))).await.unwrap_err();
    assert!(matches!(limit, Error::TooLarge { .. }), "{limit}");
    // Other owners have their own.
    let other = creator("bob", Quotas { stored_bytes: Some(3), ..Quotas::default() });
    store.receive(incoming(other, Some(3))).await.unwrap();
    write(&mut first, 6).await.unwrap();
    // Until the content has a row, and not a moment longer.
    let content = first.finish(None).await.unwrap();
    assert_eq!(stored(store).await.uploads, 6);
    capture_of(store, content, bounded(8)).await.unwrap();
    assert_eq!(stored(store).await, StoredBytes { captures: 6, ..StoredBytes::default() });
    // Jobs are compared before the content, too.
    let quotas = Quotas { queued_jobs: Some(1), ..Quotas::default() };
    let refused = store.receive(incoming(creator("ada", quotas), Some(1))).await.unwrap_err();
    assert!(matches!(refused, Error::QuotaJobs { .. }), "{refused}");
}

async fn content_of_unknown_size_is_cut_off_before_it_is_written(on: On) {
    const QUOTA: u64 = 5 << 20;
    let bench = Bench::new(on).await;
    let store = &bench.store;
    let mut upload = store.receive(incoming(bounded(QUOTA), None)).await.unwrap();
    let mut written = 0;
    let refused = loop {
        match write(&mut upload, 100_000).await {
            Ok(()) => written += 100_000,
            Err(error) => break error,
        }
        // What has come is set aside, and never more than there is.
        let uploads = stored(store).await.uploads;
        assert!((written..=QUOTA).contains(&uploads), "{uploads} for {written}");
        assert!(bytes_on_disk(&bench) <= QUOTA);
    };
    assert!(matches!(refused, Error::QuotaBytes { .. }), "{refused}");
    assert_eq!(written, QUOTA / 100_000 * 100_000);
    let refused = store.receive(incoming(bounded(QUOTA), None)).await.unwrap_err();
    assert!(matches!(refused, Error::QuotaBytes { more: 1, .. }), "{refused}");
    drop(upload);
    set_aside(store, 0).await;
    store.receive(incoming(bounded(QUOTA), None)).await.unwrap();
}

async fn content_that_does_not_come_to_its_end_frees_its_bytes(on: On) {
    let bench = Bench::new(on).await;
    let store = &bench.store;
    let mut broken = store.receive(incoming(bounded(8), Some(8))).await.unwrap();
    write(&mut broken, 4).await.unwrap();
    drop(broken);
    set_aside(store, 0).await;
    let mut whole = store.receive(incoming(bounded(8), Some(8))).await.unwrap();
    write(&mut whole, 8).await.unwrap();
    let content = whole.finish(None).await.unwrap();
    // Refused for another reason.
    let new = NewTwin {
        display_name: "a twin".into(),
        request_id: Some("key".into()),
        facts: TwinFacts::default(),
        content,
        creator: bounded(8),
    };
    let twin = store.twins().create(new).await.unwrap();
    store.twins().delete(twin.id).await.unwrap();
    let mut again = store.receive(incoming(bounded(8), Some(8))).await.unwrap();
    write(&mut again, 8).await.unwrap();
    let content = again.finish(None).await.unwrap();
    let new = NewTwin {
        display_name: "a twin".into(),
        request_id: Some("key".into()),
        facts: TwinFacts::default(),
        content,
        creator: bounded(8),
    };
    let refused = store.twins().create(new).await.unwrap_err();
    assert!(matches!(refused, Error::DeletedSince { .. }), "{refused}");
    set_aside(store, 0).await;
}

/// Also at two servers, where there may be several.
async fn uploads_at_a_time_do_not_exceed_a_quota_together(on: On) {
    const QUOTA: u64 = 10;
    let bench = Bench::new(on).await;
    let second = if on == On::Postgres { Some(bench.second().await) } else { None };
    let stores = [&bench.store, second.as_ref().map_or(&bench.store, |second| &second.store)];
    let attempts = (0..12).map(|nth| {
        let store = stores[nth % 2].clone();
        async move {
            let declared = (nth % 3 > 0).then_some(3);
            let mut upload = store.receive(incoming(bounded(QUOTA), declared)).await?;
            for _ in 0..3 {
                write(&mut upload, 1).await?;
            }
            let content = upload.finish(None).await?;
            capture_of(&store, content, bounded(QUOTA)).await
        }
    });
    let made = futures::future::join_all(attempts).await;
    let refused = made.iter().filter_map(|made| made.as_ref().err());
    for error in refused {
        assert!(matches!(error, Error::QuotaBytes { .. }), "{error}");
    }
    let made = made.iter().flatten().count() as u64;
    assert!((1..=3).contains(&made), "{made}");
    set_aside(&bench.store, 0).await;
    assert_eq!(stored(&bench.store).await.total(), 3 * made);
}

async fn a_crash_leaves_nothing_set_aside(on: On) {
    for point in Failpoint::ALL {
        let bench = Bench::new(on).await;
        let mut upload = bench.store.receive(incoming(bounded(8), None)).await.unwrap();
        write(&mut upload, 5).await.unwrap();
        let under_way = bench.store.receive(incoming(creator("ada", Quotas::default()), Some(2)));
        let under_way = under_way.await.unwrap();
        let content = upload.finish(None).await.unwrap();
        bench.store.inner.armed.arm(point);
        let made = capture_of(&bench.store, content, bounded(8)).await.is_ok();
        // Without the end of either: this process is gone.
        bench.store.close().await;
        drop(under_way);
        let bench = bench.reopen().await;
        if bench.store.is_shared() {
            // Another server may have begun them.
            bench.clock.advance(Duration::from_secs(3600));
            bench.store.uploads().sweep(Duration::ZERO).await.unwrap();
        }
        let captures = if made || point == Failpoint::AfterCommit { 5 } else { 0 };
        let expected = StoredBytes { captures, ..StoredBytes::default() };
        assert_eq!(stored(&bench.store).await, expected, "{point:?}");
    }
}

async fn what_workers_made_counts_and_is_stored_beyond_the_quota_too(on: On) {
    let bench = Bench::new(on).await;
    let store = &bench.store;
    let content = bench.stage("archive").await;
    let capture = capture_of(store, content, bounded(10)).await.unwrap();
    let fit = NewFit { creator: bounded(10), ..new_fit(&capture) };
    store.jobs().create_fit(fit.clone()).await.unwrap();
    let lease = lease_of(&bench.claim(Kind::Ingest).await.unwrap());
    let checkpoint = bench.stage("check").await;
    store.jobs().save_checkpoint(lease, checkpoint, LEASE).await.unwrap();
    assert_eq!(stored(store).await.checkpoints, 5);
    let (json, html) = (bench.stage("{}").await, bench.stage("<p>").await);
    let result = IngestResult {
        outcome: IngestOutcome::Observed(Box::new(bench.stage("seen").await)),
        playback: Some(bench.stage("played").await),
        masks: Some(bench.stage("followed").await),
        report: NewReport { verdict: "good".to_owned(), json, html },
    };
    store.jobs().end_ingest(lease, result).await.unwrap();
    let made = StoredBytes { captures: 7, derived: 23, ..StoredBytes::default() };
    assert_eq!(stored(store).await, made);
    // The owner makes nothing new now, neither content nor work.
    let refused = store.receive(incoming(bounded(10), Some(1))).await.unwrap_err();
    assert!(matches!(refused, Error::QuotaBytes { stored: 30, .. }), "{refused}");
    let refused = store.jobs().create_fit(fit).await.unwrap_err();
    assert!(matches!(refused, Error::QuotaBytes { stored: 30, .. }), "{refused}");
    // What has begun comes to its end.
    let lease = lease_of(&bench.claim(Kind::Fit).await.unwrap());
    let twin = bench.stage("twin").await;
    let twin = store.jobs().complete_fit(lease, &TwinFacts::default(), twin).await.unwrap();
    assert_eq!(stored(store).await, StoredBytes { twins: 4, ..made });
    store.twins().delete(twin).await.unwrap();
    store.captures().delete(capture.id).await.unwrap();
    assert_eq!(stored(store).await, StoredBytes::default());
}

/// A client that missed the answer sends everything again, also when its owner has nothing left.
async fn a_repetition_takes_no_room(on: On) {
    let bench = Bench::new(on).await;
    let captures = bench.store.captures();
    let content = bench.stage("archive").await;
    let new = NewCapture {
        creator: bounded(7),
        request_id: Some("key".into()),
        ..new_capture("a", content)
    };
    let first = captures.create(new).await.unwrap();
    assert!(captures.has_requested("ada", "key").await.unwrap());
    let again = async |content: &'static str| {
        let repetition = Incoming { is_repetition: true, ..incoming(bounded(7), Some(7)) };
        let mut upload = bench.store.receive(repetition).await.unwrap();
        upload.write(Bytes::from_static(content.as_bytes())).await.unwrap();
        let content = upload.finish(None).await.unwrap();
        assert!(content.is_compared());
        captures.repeated("ada", "key", "a", content.digest()).await
    };
    assert_eq!(again("archive").await.unwrap(), first);
    let refused = again("another").await.unwrap_err();
    assert!(matches!(refused, Error::RequestIdTaken { .. }), "{refused}");
    captures.delete(first.id).await.unwrap();
    let refused = again("archive").await.unwrap_err();
    assert!(matches!(refused, Error::DeletedSince { .. }), "{refused}");
    assert_eq!(stored(&bench.store).await, StoredBytes::default());
}
