use std::time::Duration;

use bendtwin_core::ids::UploadId;
use bytes::Bytes;
use futures::TryStreamExt;

use super::*;
use crate::{
    Capture, NewCapture, Quotas,
    database::testing::{On, on_both, on_databases},
    failpoint::Failpoint,
    store::tests::{Bench, new_capture},
};

mod shared;

on_both! {
    what_is_committed_survives_and_what_is_not_is_cut_off,
    whole_content_becomes_one_capture_despite_crashes,
    the_holder_is_asked_to_make_room,
    a_request_id_finds_the_upload_that_was_begun,
    an_upload_from_before_a_deletion_makes_no_capture,
    the_wrong_content_is_refused_and_frees_its_place,
    silent_uploads_expire_and_are_forgotten_later,
    uploads_under_way_are_bounded_together,
    uploads_of_which_nothing_has_come_give_way,
    the_room_that_is_kept_grows_with_what_has_come,
    uploads_are_listed_page_by_page,
    declared_lengths_are_set_aside_in_the_quota,
    an_upload_of_unknown_length_is_cut_off_at_the_quota,
}

mod files {
    use super::{a_file_that_is_too_short_is_lost_content, on_databases};
    on_databases! { a_file_that_is_too_short_is_lost_content }
}

const KEEP: Duration = Duration::from_secs(100);
const PATIENCE: Duration = Duration::from_secs(5);
const BOUNDS: UploadBounds = UploadBounds { count: 3, bytes: 1 << 30 };

pub(crate) fn new(content: &str) -> NewResumableUpload {
    NewResumableUpload {
        display_name: "rope".into(),
        request_id: Some("key".into()),
        expected_digest: Some(blake3::hash(content.as_bytes())),
        metadata: "filename cm9wZQ==".into(),
        length_bytes: Some(content.len() as u64),
        has_content: false,
        keep: KEEP,
        remember: KEEP,
        creator: crate::Creator::default(),
    }
}

async fn begin(bench: &Bench, content: &str) -> UploadId {
    bench.store.uploads().create(new(content), BOUNDS).await.unwrap().id
}

async fn claim(bench: &Bench, id: UploadId) -> UploadWriter {
    bench.store.uploads().claim(id, PATIENCE).await.unwrap()
}

pub(crate) async fn append(bench: &Bench, id: UploadId, bytes: &'static str) -> u64 {
    let mut writer = claim(bench, id).await;
    writer.write(&Bytes::from_static(bytes.as_bytes())).await.unwrap();
    writer.commit(KEEP).await.unwrap();
    writer.upload().offset_bytes
}

async fn finish(bench: &Bench, id: UploadId) -> Result<Capture> {
    let mut writer = claim(bench, id).await;
    let content = writer.stage().await?;
    let request_id = writer.upload().request_id.clone();
    let new = NewCapture { request_id, ..new_capture("rope", content) };
    bench.store.captures().create(new).await
}

async fn content(bench: &Bench, capture: &Capture) -> Vec<u8> {
    let (_, content) = bench.store.captures().content(capture.id).await.unwrap();
    content.chunks.try_collect::<Vec<_>>().await.unwrap().concat()
}

async fn what_is_committed_survives_and_what_is_not_is_cut_off(on: On) {
    let bench = Bench::new(on).await;
    let id = begin(&bench, "some content").await;
    assert_eq!(append(&bench, id, "some ").await, 5);
    let mut writer = claim(&bench, id).await;
    let long = Bytes::from(vec![b'x'; 3 << 20]);
    writer.write(&long).await.unwrap();
    drop(writer);
    let bench = bench.reopen().await;
    // For the lease of the server that died.
    bench.clock.advance(Duration::from_secs(11));
    assert_eq!(bench.store.uploads().get(id).await.unwrap().offset_bytes, 5);
    let mut writer = claim(&bench, id).await;
    writer.write(&long).await.unwrap();
    writer.discard().await.unwrap();
    drop(writer);
    assert_eq!(append(&bench, id, "content").await, 12);
    let capture = finish(&bench, id).await.unwrap();
    assert_eq!(content(&bench, &capture).await, b"some content");
    assert_eq!(bench.store.uploads().get(id).await.unwrap().state, UploadState::Stored(capture.id));
    assert!(bench.partials().await.is_empty(), "renamed, not copied");
}

/// A crash at any point between the last byte and the capture: the remaining steps run again, once.
async fn whole_content_becomes_one_capture_despite_crashes(on: On) {
    for point in Failpoint::ALL {
        let bench = Bench::new(on).await;
        let id = begin(&bench, "whole").await;
        append(&bench, id, "whole").await;
        bench.store.inner.armed.arm(point);
        let first = finish(&bench, id).await;
        let bench = bench.reopen().await;
        // For the lease of the server that died.
        bench.clock.advance(Duration::from_secs(11));
        let unfinished = bench.store.uploads().whole().await.unwrap();
        let capture = match bench.store.uploads().get(id).await.unwrap().state {
            UploadState::Stored(capture) => bench.store.captures().get(capture).await.unwrap(),
            UploadState::Receiving => {
                assert_eq!(unfinished, [id], "{point:?}");
                assert!(first.is_err());
                finish(&bench, id).await.unwrap()
            }
            UploadState::Gone(why) => panic!("{point:?}: {why}"),
        };
        assert_eq!(content(&bench, &capture).await, b"whole", "{point:?}");
        let captures = bench.store.captures().list(&Default::default()).await.unwrap().items;
        assert_eq!(captures.len(), 1, "{point:?}");
        bench.store.captures().delete(capture.id).await.unwrap();
        assert_eq!(bench.reopen().await.blob_count().await, 0, "{point:?}");
    }
}

async fn the_holder_is_asked_to_make_room(on: On) {
    let bench = Bench::new(on).await;
    let id = begin(&bench, "some content").await;
    let mut first = claim(&bench, id).await;
    first.write(&Bytes::from_static(b"some ")).await.unwrap();
    let stubborn = bench.store.uploads().claim(id, Duration::from_millis(20)).await;
    assert!(matches!(stubborn, Err(Error::UploadLocked { .. })));
    let yields = async {
        first.wanted().await;
        first.commit(KEEP).await.unwrap();
        drop(first);
    };
    let uploads = bench.store.uploads();
    let (second, ()) = tokio::join!(uploads.claim(id, PATIENCE), yields);
    let second = second.unwrap();
    assert_eq!(second.upload().offset_bytes, 5);
    // Another writer no longer waits.
    let undisturbed = tokio::time::timeout(Duration::from_millis(20), second.wanted()).await;
    assert!(undisturbed.is_err());
}

async fn a_request_id_finds_the_upload_that_was_begun(on: On) {
    let bench = Bench::new(on).await;
    let id = begin(&bench, "whole").await;
    append(&bench, id, "who").await;
    let again = bench.store.uploads().create(new("whole"), BOUNDS).await.unwrap();
    assert_eq!((again.id, again.offset_bytes), (id, 3));
    let other = bench.store.uploads().create(new("other"), BOUNDS).await;
    assert!(matches!(other, Err(Error::RequestIdTaken { .. })));
    append(&bench, id, "le").await;
    let capture = finish(&bench, id).await.unwrap();
    assert_eq!(begin(&bench, "whole").await, id);
    // Once the upload is forgotten, its capture still answers for it.
    bench.clock.advance(2 * KEEP);
    bench.store.uploads().sweep(KEEP).await.unwrap();
    let found = bench.store.uploads().create(new("whole"), BOUNDS).await.unwrap();
    assert_eq!((found.state.clone(), found.is_whole()), (UploadState::Stored(capture.id), true));
    // Once the capture is deleted, the upload starts again.
    bench.store.captures().delete(capture.id).await.unwrap();
    let anew = bench.store.uploads().create(new("whole"), BOUNDS).await.unwrap();
    assert_eq!((anew.state, anew.offset_bytes), (UploadState::Receiving, 0));
}

/// The same content arrives by an upload, and in one piece.
async fn an_upload_from_before_a_deletion_makes_no_capture(on: On) {
    let bench = Bench::new(on).await;
    let (captures, uploads) = (bench.store.captures(), bench.store.uploads());
    let in_one_piece = async || {
        let content = bench.stage("whole").await;
        captures
            .create(NewCapture { request_id: Some("key".into()), ..new_capture("rope", content) })
            .await
    };
    let before = begin(&bench, "whole").await;
    append(&bench, before, "whole").await;
    captures.delete(in_one_piece().await.unwrap().id).await.unwrap();
    // However long it takes.
    bench.clock.advance(Duration::from_secs(2 * 86_400));
    bench.store.collect_garbage().await.unwrap();
    assert!(matches!(finish(&bench, before).await, Err(Error::DeletedSince { .. })));
    claim(&bench, before).await.end("it was refused", KEEP).await.unwrap();
    // A request that brings content may be a late one; without content it makes nothing yet.
    let late = NewResumableUpload { has_content: true, ..new("whole") };
    assert!(matches!(uploads.create(late, BOUNDS).await, Err(Error::DeletedSince { .. })));
    let after = begin(&bench, "whole").await;
    append(&bench, after, "whole").await;
    assert!(matches!(in_one_piece().await, Err(Error::DeletedSince { .. })));
    let capture = finish(&bench, after).await.unwrap();
    assert_eq!(in_one_piece().await.unwrap().id, capture.id);
    captures.delete(capture.id).await.unwrap();
    assert!(matches!(in_one_piece().await, Err(Error::DeletedSince { .. })));
}

async fn the_wrong_content_is_refused_and_frees_its_place(on: On) {
    let bench = Bench::new(on).await;
    let id = begin(&bench, "right").await;
    append(&bench, id, "wrong").await;
    assert!(matches!(finish(&bench, id).await, Err(Error::DigestMismatch { .. })));
    claim(&bench, id).await.end("it was refused", KEEP).await.unwrap();
    let gone = bench.store.uploads().claim(id, PATIENCE).await;
    assert!(matches!(gone, Err(Error::UploadGone { .. })));
    assert!(bench.partials().await.is_empty());
    begin(&bench, "right").await;
}

async fn silent_uploads_expire_and_are_forgotten_later(on: On) {
    let bench = Bench::new(on).await;
    let (held, idle) = (begin(&bench, "held").await, {
        let new = NewResumableUpload { request_id: None, ..new("idle") };
        bench.store.uploads().create(new, BOUNDS).await.unwrap().id
    });
    append(&bench, idle, "id").await;
    let holder = claim(&bench, held).await;
    bench.clock.advance(2 * KEEP);
    assert_eq!(bench.store.uploads().sweep(KEEP).await.unwrap(), 1);
    let gone = bench.store.uploads().claim(idle, PATIENCE).await;
    assert!(matches!(gone, Err(Error::UploadGone { .. })));
    assert!(bench.partials().await.is_empty());
    drop(holder);
    bench.clock.advance(2 * KEEP);
    bench.store.uploads().sweep(KEEP).await.unwrap();
    let forgotten = bench.store.uploads().get(idle).await;
    assert!(matches!(forgotten, Err(Error::NotFound { .. })));
}

fn sized(length_bytes: Option<u64>) -> NewResumableUpload {
    NewResumableUpload { request_id: None, length_bytes, ..new("") }
}

async fn uploads_under_way_are_bounded_together(on: On) {
    let bench = Bench::new(on).await;
    let uploads = bench.store.uploads();
    let bounds = UploadBounds { count: 2, bytes: 10 };
    let first = uploads.create(sized(Some(6)), bounds).await.unwrap();
    append(&bench, first.id, "a").await;
    let refused = uploads.create(sized(Some(5)), bounds).await;
    assert!(matches!(refused, Err(Error::UploadsFull { count: 1, bytes: 6 })));
    let open = uploads.create(sized(None), bounds).await.unwrap();
    let mut writer = claim(&bench, open.id).await;
    // Its writer keeps the place of an empty upload.
    let refused = uploads.create(sized(Some(1)), bounds).await;
    assert!(matches!(refused, Err(Error::UploadsFull { count: 2, .. })));
    assert_eq!(writer.room(100, bounds).await.unwrap(), 4);
    assert!(matches!(writer.set_length(5, bounds).await, Err(Error::UploadsFull { .. })));
    writer.set_length(4, bounds).await.unwrap();
    writer.set_length(4, bounds).await.unwrap();
    assert!(matches!(writer.set_length(3, bounds).await, Err(Error::UploadLength { .. })));
    drop(writer);
    append(&bench, open.id, "b").await;
    assert_eq!(uploads.in_use().await.unwrap(), UploadUse { count: 2, bytes: 10 });
    let refused = uploads.create(sized(Some(1)), bounds).await;
    assert!(matches!(refused, Err(Error::UploadsFull { count: 2, .. })));
}

/// Creations cost their sender next to nothing, so they must not lock others out.
async fn uploads_of_which_nothing_has_come_give_way(on: On) {
    let bench = Bench::new(on).await;
    let uploads = bench.store.uploads();
    let bounds = UploadBounds { count: 3, bytes: 10 };
    let begun = uploads.create(sized(Some(4)), bounds).await.unwrap();
    append(&bench, begun.id, "a").await;
    let mut empty = Vec::new();
    for _ in 0..10 {
        bench.clock.advance(Duration::from_micros(1));
        empty.push(uploads.create(sized(Some(6)), bounds).await.unwrap().id);
    }
    assert_eq!(uploads.in_use().await.unwrap(), UploadUse { count: 3, bytes: 4 });
    let state = async |id| uploads.get(id).await.unwrap().state;
    assert_eq!(state(begun.id).await, UploadState::Receiving);
    assert!(matches!(state(empty[7]).await, UploadState::Gone(_)));
    assert_eq!(state(empty[8]).await, UploadState::Receiving);
    // Space for the bytes is reserved when they arrive.
    let second = claim(&bench, empty[9]).await;
    assert_eq!(second.room(100, bounds).await.unwrap(), 6);
    drop(second);
    append(&bench, empty[8], "b").await;
    let second = claim(&bench, empty[9]).await;
    let full = second.room(100, bounds).await;
    assert!(matches!(full, Err(Error::UploadsFull { bytes: 10, .. })));
}

/// The reserved space is computed in the same way in SQL and here.
async fn the_room_that_is_kept_grows_with_what_has_come(on: On) {
    let bench = Bench::new(on).await;
    let uploads = bench.store.uploads();
    let (mib, gib) = (1u64 << 20, 1u64 << 30);
    for (offset, length, kept) in [
        (0, Some(8 * gib), 0),
        (1, Some(8 * gib), FIRST_ROOM),
        (16 * mib, Some(8 * gib), FIRST_ROOM),
        (17 * mib, Some(8 * gib), 68 * mib),
        (3 * gib, Some(8 * gib), 8 * gib),
        (1, Some(5), 5),
        (20 * mib, Some(70 * mib), 70 * mib),
        (20 * mib, None, 20 * mib),
    ] {
        let bounds = UploadBounds { count: 9, bytes: 1 << 40 };
        let id = uploads.create(sized(length), bounds).await.unwrap().id;
        let mut tx = bench.store.inner.database.write().await.unwrap();
        let moved = "update uploads set offset_bytes = $2 where id = $1";
        let moved = crate::sql::query(moved).bind(id.uuid().to_string()).bind(offset as i64);
        moved.execute(&mut tx).await.unwrap();
        tx.commit().await.unwrap();
        assert_eq!(uploads.in_use().await.unwrap().bytes, kept, "{offset} of {length:?}");
        if offset > 0 {
            assert_eq!(kept_room(offset, length), kept);
        }
        claim(&bench, id).await.end("counted", KEEP).await.unwrap();
    }
}

fn of_ada(length_bytes: Option<u64>, quota: u64) -> NewResumableUpload {
    let quotas = Quotas { stored_bytes: Some(quota), ..Quotas::default() };
    let creator = crate::Creator { owner: "ada".into(), quotas };
    NewResumableUpload { expected_digest: None, creator, ..sized(length_bytes) }
}

async fn of_uploads(bench: &Bench) -> u64 {
    bench.store.usage().of("ada").await.unwrap().stored.uploads
}

async fn declared_lengths_are_set_aside_in_the_quota(on: On) {
    let bench = Bench::new(on).await;
    let uploads = bench.store.uploads();
    let first = uploads.create(of_ada(Some(6), 8), BOUNDS).await.unwrap();
    let refused = uploads.create(of_ada(Some(3), 8), BOUNDS).await.unwrap_err();
    assert!(matches!(refused, Error::QuotaBytes { stored: 6, more: 3, limit: 8, .. }), "{refused}");
    assert_eq!(of_uploads(&bench).await, 6);
    // A length that is declared later.
    let open = uploads.create(of_ada(None, 8), BOUNDS).await.unwrap();
    let mut writer = claim(&bench, open.id).await;
    writer.bind(of_ada(None, 8).creator.quotas);
    let refused = writer.set_length(3, BOUNDS).await.unwrap_err();
    assert!(matches!(refused, Error::QuotaBytes { stored: 6, more: 3, .. }), "{refused}");
    writer.set_length(2, BOUNDS).await.unwrap();
    drop(writer);
    assert_eq!(of_uploads(&bench).await, 8);
    // It comes to its end, although its owner has more by then.
    append(&bench, first.id, "123456").await;
    bench
        .tell(
            crate::sql::query("update uploads set length_bytes = 9 where id = $1")
                .bind(open.id.uuid().to_string()),
        )
        .await;
    let mut writer = claim(&bench, first.id).await;
    writer.bind(of_ada(None, 8).creator.quotas);
    let (content, creator) = (writer.stage().await.unwrap(), writer.creator());
    let new = NewCapture { creator, ..new_capture("rope", content) };
    bench.store.captures().create(new).await.unwrap();
    drop(writer);
    // What is given up is free again.
    claim(&bench, open.id).await.end("terminated", KEEP).await.unwrap();
    assert_eq!(of_uploads(&bench).await, 0);
    uploads.create(of_ada(Some(2), 8), BOUNDS).await.unwrap();
    bench.clock.advance(2 * KEEP);
    uploads.sweep(KEEP).await.unwrap();
    assert_eq!(of_uploads(&bench).await, 0);
}

async fn an_upload_of_unknown_length_is_cut_off_at_the_quota(on: On) {
    const QUOTA: u64 = 3 << 20;
    let bench = Bench::new(on).await;
    let uploads = bench.store.uploads();
    let quotas = of_ada(None, QUOTA).creator.quotas;
    let id = uploads.create(of_ada(None, QUOTA), BOUNDS).await.unwrap().id;
    let mut writer = claim(&bench, id).await;
    writer.bind(quotas);
    let refused = writer.reserve(QUOTA + 1).await.unwrap_err();
    assert!(matches!(refused, Error::QuotaBytes { stored: 0, .. }), "{refused}");
    let chunk = Bytes::from(vec![b'x'; 100_000]);
    let refused = loop {
        if let Err(error) = writer.write(&chunk).await {
            break error;
        }
        let counted = of_uploads(&bench).await;
        assert!((writer.pending()..=QUOTA).contains(&counted), "{counted}");
    };
    assert!(matches!(refused, Error::QuotaBytes { .. }), "{refused}");
    let whole = QUOTA / 100_000 * 100_000;
    assert_eq!((writer.pending(), of_uploads(&bench).await), (whole, QUOTA));
    writer.commit(KEEP).await.unwrap();
    writer.give_back().await.unwrap();
    assert_eq!((writer.upload().offset_bytes, of_uploads(&bench).await), (whole, whole));
    drop(writer);
    // Others of the owner have the rest alone, and the upload none of it then.
    let rest = uploads.create(of_ada(Some(QUOTA - whole), QUOTA), BOUNDS).await.unwrap();
    let mut writer = claim(&bench, id).await;
    writer.bind(quotas);
    let refused = writer.write(&Bytes::from_static(b"x")).await.unwrap_err();
    assert!(matches!(refused, Error::QuotaBytes { .. }), "{refused}");
    claim(&bench, rest.id).await.end("terminated", KEEP).await.unwrap();
    writer.write(&Bytes::from_static(b"x")).await.unwrap();
    // A server that dies keeps no more than it had set aside, until the next request.
    drop(writer);
    let bench = bench.reopen().await;
    bench.clock.advance(Duration::from_secs(11));
    assert!(of_uploads(&bench).await <= QUOTA);
    let mut writer = claim(&bench, id).await;
    writer.give_back().await.unwrap();
    assert_eq!(of_uploads(&bench).await, whole);
}

async fn uploads_are_listed_page_by_page(on: On) {
    let bench = Bench::new(on).await;
    let uploads = bench.store.uploads();
    let mut ids = Vec::new();
    for _ in 0..3 {
        ids.push(uploads.create(sized(None), BOUNDS).await.unwrap().id);
    }
    ids.sort_by_key(|id| std::cmp::Reverse(*id));
    let first =
        uploads.list(&PageRequest { size: 2, ..PageRequest::default() }, None).await.unwrap();
    let rest = PageRequest { size: 2, token: first.next_token };
    let second = uploads.list(&rest, None).await.unwrap();
    let listed: Vec<_> = first.items.iter().chain(&second.items).map(|u| u.id).collect();
    assert_eq!((listed, second.next_token.as_str()), (ids, ""));
}

async fn a_file_that_is_too_short_is_lost_content(on: On) {
    let bench = Bench::new(on).await;
    let id = begin(&bench, "some content").await;
    append(&bench, id, "some ").await;
    let Place::Folder(folder) = bench.store.blobs().place() else { panic!("a test of files") };
    std::fs::write(folder.partial(id), "so").unwrap();
    let mut writer = claim(&bench, id).await;
    writer.write(&Bytes::from_static(b"content")).await.unwrap();
    assert!(matches!(writer.commit(KEEP).await, Err(Error::ContentLost { .. })));
    drop(writer);
    folder.remove_partial(id).await.unwrap();
    let mut writer = claim(&bench, id).await;
    writer.write(&Bytes::from_static(b"content")).await.unwrap();
    assert!(matches!(writer.commit(KEEP).await, Err(Error::ContentLost { .. })));
}
