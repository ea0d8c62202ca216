//! Deletion, restoration and purge.

mod crashes;
mod jobs;
mod model;
mod purge;

use bendtwin_core::{Category, Problem as _, ids::TwinId};

use super::*;
use crate::{
    Capture, CaptureChange, IngestOutcome, IngestResult, Kind, LabelChange, ListQuery, NewCapture,
    NewFit, NewReport, NewSupplement, NewTwin, SupplementKind, TwinFacts,
    database::testing::{On, on_both},
    store::tests::{Bench, LEASE, lease_of, new_capture, new_fit},
};

on_both! {
    a_deleted_capture_is_not_there_and_comes_back_whole,
    a_deleted_fit_or_twin_is_not_there_and_comes_back,
    a_request_id_makes_nothing_while_its_resource_is_in_the_trash,
    a_restored_resource_has_its_request_id_for_a_day,
    the_trash_is_listed_by_page_and_by_owner,
    what_is_in_the_trash_counts_for_its_owner,
    the_check_and_a_backup_have_what_is_in_the_trash,
}

const DAY: Duration = Duration::from_secs(86_400);

/// For a week.
fn deletion() -> Deletion {
    Deletion { kept: 7 * DAY, by: "ada".to_owned() }
}

async fn put(bench: &Bench, resource: impl Into<Resource>) -> Resource {
    let resource = resource.into();
    bench.store.trash().put(resource, &deletion()).await.unwrap();
    resource
}

async fn restore(bench: &Bench, resource: impl Into<Resource>) -> Result<()> {
    bench.store.trash().restore(resource, &Creator::default()).await
}

#[track_caller]
fn assert_in_trash<T: std::fmt::Debug>(read: Result<T>) {
    let error = read.unwrap_err();
    assert_eq!((error.category(), error.reason()), (Category::NotFound, "IN_TRASH"), "{error}");
    let text = error.to_string();
    assert!(text.contains("bendtwin trash restore ") && text.contains(" until "), "{text}");
}

/// A capture whose ingest has made everything, with a supplement.
async fn observed(bench: &Bench, archive: &'static str) -> Capture {
    let capture = bench.fresh_capture(archive).await;
    let lease = lease_of(&bench.claim(Kind::Ingest).await.unwrap());
    let report = NewReport {
        verdict: "good".to_owned(),
        json: bench.stage("{}").await,
        html: bench.stage("<p>").await,
    };
    let result = IngestResult {
        outcome: IngestOutcome::Observed(Box::new(bench.stage("seen").await)),
        playback: Some(bench.stage("played").await),
        masks: Some(bench.stage("followed").await),
        report,
    };
    bench.store.jobs().end_ingest(lease, result).await.unwrap();
    let (kind, content) = (SupplementKind::Calibration, bench.stage("poses").await);
    let new = NewSupplement { capture: capture.id, kind, content, creator: Creator::default() };
    bench.store.captures().add_supplement(new).await.unwrap();
    capture
}

async fn twin(bench: &Bench, name: &str, content: &'static str) -> TwinId {
    let new = NewTwin {
        display_name: name.to_owned(),
        request_id: None,
        facts: TwinFacts { quality: "{}".to_owned(), ..TwinFacts::default() },
        content: bench.stage(content).await,
        creator: Creator::default(),
    };
    bench.store.twins().create(new).await.unwrap().id
}

async fn a_deleted_capture_is_not_there_and_comes_back_whole(on: On) {
    let bench = Bench::new(on).await;
    let captures = bench.store.captures();
    let id = observed(&bench, "archive").await.id;
    let tags = LabelChange { add_tags: vec!["rope".to_owned()], ..LabelChange::default() };
    captures.update(id, &tags.clone().into()).await.unwrap();
    let before = captures.overview(id).await.unwrap();
    let blobs = bench.blob_count().await;

    let purged = bench.store.trash().put(id, &deletion()).await.unwrap();
    assert_eq!(purged, bench.store.now() + jiff::SignedDuration::from_hours(7 * 24));
    for list in [ListQuery::default(), ListQuery { tag: "rope".into(), ..ListQuery::default() }] {
        assert!(captures.list(&list).await.unwrap().items.is_empty());
        assert!(captures.overviews(&list).await.unwrap().items.is_empty());
    }
    assert_in_trash(captures.get(id).await);
    assert_in_trash(captures.overview(id).await);
    assert_in_trash(captures.content(id).await);
    assert_in_trash(captures.observation_content(id).await);
    assert_in_trash(captures.playback_content(id).await);
    assert_in_trash(captures.playback_digest(id).await);
    assert_in_trash(captures.masks_content(id).await);
    assert_in_trash(captures.report_content(id, false).await);
    assert_in_trash(captures.supplement_content(id, SupplementKind::Calibration).await);
    assert_in_trash(captures.admit_supplement(id, SupplementKind::Calibration).await);
    assert_in_trash(captures.update(id, &CaptureChange::default()).await);
    assert_in_trash(captures.delete_supplement(id, SupplementKind::Calibration).await);
    assert_in_trash(bench.store.jobs().create_fit(new_fit(&before.capture)).await);
    assert_in_trash(bench.store.jobs().get(before.ingest.id).await);
    assert_in_trash(bench.store.trash().put(id, &deletion()).await);
    assert_eq!(
        bench.store.jobs().depth().await.unwrap().counts.iter().map(|c| c.2).sum::<u64>(),
        0
    );
    bench.store.collect_garbage().await.unwrap();

    let bench = bench.reopen().await;
    let captures = bench.store.captures();
    let trashed = bench.store.trash().get(id).await.unwrap();
    assert_eq!((trashed.purged, &*trashed.deleted_by), (purged, "ada"));
    assert_eq!((&*trashed.display_name, trashed.size_bytes), ("a rope", 7));
    restore(&bench, id).await.unwrap();
    // Once more changes nothing.
    restore(&bench, id).await.unwrap();
    let mut after = captures.overview(id).await.unwrap();
    assert!(after.ingest.revision > before.ingest.revision, "watchers see the change");
    after.ingest.revision = before.ingest.revision;
    assert_eq!(after, before);
    captures.content(id).await.unwrap();
    captures.observation_content(id).await.unwrap();
    let playback = captures.playback_content(id).await.unwrap();
    assert_eq!(captures.playback_digest(id).await.unwrap(), playback.digest);
    captures.supplement_content(id, SupplementKind::Calibration).await.unwrap();
    let tagged = ListQuery { tag: "rope".into(), ..ListQuery::default() };
    assert_eq!(captures.list(&tagged).await.unwrap().items.len(), 1);
    assert!(bench.store.trash().get(id).await.is_err());
    assert_eq!(bench.blob_count().await, blobs);
}

async fn a_deleted_fit_or_twin_is_not_there_and_comes_back(on: On) {
    let bench = Bench::new(on).await;
    let (jobs, twins) = (bench.store.jobs(), bench.store.twins());
    let capture = bench.capture("a").await;
    jobs.create_fit(new_fit(&capture)).await.unwrap();
    let lease = lease_of(&bench.claim(Kind::Fit).await.unwrap());
    let facts = TwinFacts { quality: "{}".to_owned(), ..TwinFacts::default() };
    let twin = jobs.complete_fit(lease, &facts, bench.stage("twin").await).await.unwrap();
    let fit = lease.job.fit().unwrap();
    let before = (jobs.get(fit).await.unwrap(), twins.get(twin).await.unwrap());

    put(&bench, fit).await;
    put(&bench, twin).await;
    assert_in_trash(jobs.get(fit).await);
    assert_in_trash(jobs.losses(fit).await);
    assert_in_trash(jobs.cancel(fit).await);
    assert_in_trash(jobs.update_fit(fit, &LabelChange::default()).await);
    assert_in_trash(twins.get(twin).await);
    assert_in_trash(twins.content(twin).await);
    assert_in_trash(twins.update(twin, &LabelChange::default()).await);
    assert!(jobs.fits(&ListQuery::default()).await.unwrap().items.is_empty());
    assert!(twins.list(&ListQuery::default()).await.unwrap().items.is_empty());

    restore(&bench, fit).await.unwrap();
    restore(&bench, twin).await.unwrap();
    let mut after = (jobs.get(fit).await.unwrap(), twins.get(twin).await.unwrap());
    after.0.revision = before.0.revision;
    assert_eq!(after, before);
    twins.content(twin).await.unwrap();

    // The capture may go: they behave as if it had gone before their deletion.
    put(&bench, fit).await;
    put(&bench, twin).await;
    bench.store.captures().delete(capture.id).await.unwrap();
    restore(&bench, fit).await.unwrap();
    restore(&bench, twin).await.unwrap();
    twins.content(twin).await.unwrap();
    assert_eq!(jobs.get(fit).await.unwrap().twin, Some(twin));
}

fn requested(key: &str, content: crate::Staged) -> NewCapture {
    NewCapture { request_id: Some(key.to_owned()), ..new_capture("rope", content) }
}

async fn a_request_id_makes_nothing_while_its_resource_is_in_the_trash(on: On) {
    let bench = Bench::new(on).await;
    let captures = bench.store.captures();
    let made = captures.create(requested("key", bench.stage("a").await)).await.unwrap();
    put(&bench, made.id).await;
    let again = captures.create(requested("key", bench.stage("a").await)).await.unwrap_err();
    assert_eq!(again.reason(), "DELETED_SINCE");
    // Deleted for good, its id is still known.
    captures.delete(made.id).await.unwrap();
    let again = captures.create(requested("key", bench.stage("a").await)).await.unwrap_err();
    assert_eq!(again.reason(), "DELETED_SINCE");
    assert_eq!(bench.blob_count().await, 0);
}

async fn a_restored_resource_has_its_request_id_for_a_day(on: On) {
    let bench = Bench::new(on).await;
    let captures = bench.store.captures();
    let made = captures.create(requested("key", bench.stage("a").await)).await.unwrap();
    put(&bench, made.id).await;
    restore(&bench, made.id).await.unwrap();
    let again = captures.create(requested("key", bench.stage("a").await)).await.unwrap();
    assert_eq!(again.id, made.id);
    put(&bench, made.id).await;
    bench.clock.advance(2 * DAY);
    bench.store.collect_garbage().await.unwrap();
    let other = captures.create(requested("key", bench.stage("a").await)).await.unwrap();
    restore(&bench, made.id).await.unwrap();
    let again = captures.create(requested("key", bench.stage("a").await)).await.unwrap();
    assert_eq!(again.id, other.id, "a day later the id is free");

    let fit = NewFit { request_id: Some("fit".to_owned()), ..new_fit(&other) };
    let made = bench.store.jobs().create_fit(fit.clone()).await.unwrap();
    put(&bench, made.id.fit().unwrap()).await;
    restore(&bench, made.id.fit().unwrap()).await.unwrap();
    assert_eq!(bench.store.jobs().create_fit(fit).await.unwrap().id, made.id);
}

async fn the_trash_is_listed_by_page_and_by_owner(on: On) {
    let bench = Bench::new(on).await;
    let mut deleted = Vec::new();
    for n in 0..5 {
        let owner = if n == 2 { "bob" } else { "" };
        let creator = Creator { owner: owner.to_owned(), ..Creator::default() };
        let new = NewCapture { creator, ..new_capture("rope", bench.stage("a").await) };
        let id = bench.store.captures().create(new).await.unwrap().id;
        // Two are deleted in the same moment.
        if n != 3 {
            bench.clock.advance(Duration::from_secs(1));
        }
        deleted.push(put(&bench, id).await);
    }
    let kept = bench.capture("b").await;
    let trash = bench.store.trash();
    let mut seen = Vec::new();
    let mut page = PageRequest { size: 2, token: String::new() };
    loop {
        let got = trash.list(Collection::Captures, "", None, &page).await.unwrap();
        assert!(got.items.len() <= 2);
        seen.extend(got.items.iter().map(|trashed| trashed.resource));
        page.token = got.next_token;
        if page.token.is_empty() {
            break;
        }
    }
    deleted.reverse();
    assert_eq!(seen, deleted);
    let of_bob =
        trash.list(Collection::Captures, "bob", None, &PageRequest::default()).await.unwrap();
    assert_eq!(of_bob.items.iter().map(|t| t.resource).collect::<Vec<_>>(), [deleted[2]]);
    for collection in [Collection::Fits, Collection::Twins] {
        let none = trash.list(collection, "", None, &PageRequest::default()).await.unwrap();
        assert!(none.items.is_empty(), "ingests follow their captures");
    }
    let token = trash.list(Collection::Captures, "", None, &PageRequest { size: 2, ..page }).await;
    let page = PageRequest { size: 2, token: token.unwrap().next_token };
    let other = trash.list(Collection::Twins, "", None, &page).await;
    assert!(matches!(other, Err(Error::InvalidPageToken)));
    assert!(trash.get(kept.id).await.is_err());
}

async fn what_is_in_the_trash_counts_for_its_owner(on: On) {
    let bench = Bench::new(on).await;
    let quotas = crate::Quotas { stored_bytes: Some(10), ..Default::default() };
    let creator = Creator { owner: "ada".to_owned(), quotas };
    let new = async |content| NewCapture {
        creator: creator.clone(),
        ..new_capture("rope", bench.stage(content).await)
    };
    let captures = bench.store.captures();
    let first = captures.create(new("12345678").await).await.unwrap();
    put(&bench, first.id).await;
    let refused = captures.create(new("123").await).await.unwrap_err();
    assert!(matches!(refused, Error::QuotaBytes { .. }) && refused.to_string().contains("trash"));
    captures.delete(first.id).await.unwrap();
    captures.create(new("123").await).await.unwrap();
}

/// The check sees content that is gone, a backup has it, and a repair brings back what it can, as
/// for what is not in the trash.
async fn the_check_and_a_backup_have_what_is_in_the_trash(on: On) {
    use crate::maintenance::{Depth, Site, backup, check, repair, restore};
    if on != On::Sqlite {
        return;
    }
    let bench = Bench::new(on).await;
    let capture = observed(&bench, "archive").await;
    put(&bench, capture.id).await;
    let dir = bench.dir.path();
    let report = check(dir, Depth::Digests).await.unwrap();
    assert!(report.is_sound() && report.unreferenced.is_empty(), "{report:?}");
    assert_eq!((report.references, report.blobs), (7, 7));
    let copy = tempfile::tempdir().unwrap();
    let (kept, to) = (copy.path().join("kept"), copy.path().join("restored"));
    backup(&Site::new(dir), &kept).await.unwrap();
    restore(&kept, &Site::new(&to)).await.unwrap();
    let store = Store::open(crate::Options::new(&to)).await.unwrap();
    store.trash().restore(capture.id, &Creator::default()).await.unwrap();
    store.captures().content(capture.id).await.unwrap();
    store.close().await;

    let observation = bench.store.captures().observation(capture.id).await.unwrap().unwrap();
    bench.damage(&observation.digest, None).await;
    let dir = bench.close().await;
    repair(dir.path()).await.unwrap();
    let store = Store::open(crate::Options::new(dir.path())).await.unwrap();
    let worker = bendtwin_core::ids::WorkerId::generate();
    let claimed = store.jobs().claim(Kind::Ingest, worker, LEASE).await.unwrap();
    assert_eq!(claimed, None, "it is in the trash");
    store.trash().restore(capture.id, &Creator::default()).await.unwrap();
    let claimed = store.jobs().claim(Kind::Ingest, worker, LEASE).await.unwrap();
    assert_eq!(claimed.map(|job| job.capture), Some(capture.id), "it is read again");
}
