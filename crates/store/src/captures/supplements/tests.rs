use bendtwin_core::{Category, Problem as _};

use super::*;
use crate::{
    Capture, Kind, Quotas,
    database::testing::{On, on_both},
    store::tests::{Bench, new_fit},
};

on_both! {
    one_of_each_kind_is_kept_and_replaced,
    what_jobs_read_does_not_change_under_them,
    a_supplement_counts_in_the_quota_of_who_adds_it,
    supplements_survive_crashes_whole,
}

async fn add(
    bench: &Bench,
    capture: &Capture,
    kind: SupplementKind,
    content: &'static str,
) -> Result<()> {
    let content = bench.stage(content).await;
    let creator = Creator::default();
    let new = NewSupplement { capture: capture.id, kind, content, creator };
    bench.store.captures().add_supplement(new).await
}

/// Kinds and sizes of the supplements of a capture.
async fn there(bench: &Bench, capture: &Capture) -> Vec<(SupplementKind, u64)> {
    let found = bench.store.captures().supplements(capture.id).await.unwrap();
    found.iter().map(|supplement| (supplement.kind, supplement.size_bytes)).collect()
}

async fn one_of_each_kind_is_kept_and_replaced(on: On) {
    use SupplementKind::{Calibration, Masks};
    let bench = Bench::new(on).await;
    let captures = bench.store.captures();
    let (capture, other) = (bench.capture("a").await, bench.capture("b").await);
    let none = captures.supplement_content(capture.id, Masks).await.err().unwrap();
    assert_eq!((none.category(), none.reason()), (Category::NotFound, "NOT_FOUND"));
    add(&bench, &capture, Calibration, "poses").await.unwrap();
    add(&bench, &capture, Masks, "masks").await.unwrap();
    let first = captures.supplements(capture.id).await.unwrap();
    assert_eq!(there(&bench, &capture).await, [(Masks, 5), (Calibration, 5)]);
    assert!(there(&bench, &other).await.is_empty());
    assert_eq!(captures.supplement_content(capture.id, Calibration).await.unwrap().size_bytes, 5);

    // The same again changes nothing, other content replaces it.
    bench.clock.advance(std::time::Duration::from_secs(5));
    add(&bench, &capture, Masks, "masks").await.unwrap();
    assert_eq!(captures.supplements(capture.id).await.unwrap(), first);
    add(&bench, &capture, Masks, "better masks").await.unwrap();
    let overview = captures.overview(capture.id).await.unwrap();
    assert_eq!(overview.supplements[0].size_bytes, 12);
    assert!(overview.supplements[0].created > first[0].created);
    let all = captures.overviews(&Default::default()).await.unwrap().items;
    let of_capture = all.iter().find(|found| found.capture.id == capture.id).unwrap();
    assert_eq!(of_capture, &overview);
    // Two archives, the poses and the better masks.
    assert_eq!(bench.blob_count().await, 4);

    captures.delete_supplement(capture.id, Masks).await.unwrap();
    let twice = captures.delete_supplement(capture.id, Masks).await;
    assert!(matches!(twice, Err(Error::NotFound { .. })));
    assert_eq!(there(&bench, &capture).await, [(Calibration, 5)]);
    captures.delete(capture.id).await.unwrap();
    assert_eq!(bench.blob_count().await, 1);
    let gone = add(&bench, &capture, Masks, "masks").await;
    assert!(matches!(gone, Err(Error::NotFound { .. })));
    assert_eq!(bench.blob_count().await, 1);
}

async fn what_jobs_read_does_not_change_under_them(on: On) {
    use SupplementKind::{Calibration, Masks};
    let bench = Bench::new(on).await;
    let captures = bench.store.captures();
    let capture = bench.fresh_capture("a").await;
    let early = add(&bench, &capture, Masks, "masks").await;
    assert!(matches!(early, Err(Error::IngestUnderWay { .. })));
    let early = captures.admit_supplement(capture.id, Masks).await;
    assert!(matches!(early, Err(Error::IngestUnderWay { .. })));
    assert_eq!(bench.blob_count().await, 1);
    let ingest = bench.store.jobs().ingest_of(capture.id).await.unwrap();
    bench.store.jobs().cancel(ingest.id).await.unwrap();
    captures.admit_supplement(capture.id, Masks).await.unwrap();
    add(&bench, &capture, Masks, "masks").await.unwrap();

    let ready = bench.capture("b").await;
    add(&bench, &ready, Masks, "masks").await.unwrap();
    let fit = bench.store.jobs().create_fit(new_fit(&ready)).await.unwrap();
    // A repetition whose first reply was lost finds what it made.
    captures.admit_supplement(ready.id, Masks).await.unwrap();
    add(&bench, &ready, Masks, "masks").await.unwrap();
    for changed in [
        add(&bench, &ready, Masks, "others").await,
        add(&bench, &ready, Calibration, "poses").await,
        captures.admit_supplement(ready.id, Calibration).await,
        captures.delete_supplement(ready.id, Masks).await,
    ] {
        assert!(matches!(changed, Err(Error::CaptureInUse { fits: 1, .. })), "{changed:?}");
    }
    assert_eq!(there(&bench, &ready).await, [(Masks, 5)]);
    bench.store.jobs().cancel(fit.id).await.unwrap();
    captures.delete_supplement(ready.id, Masks).await.unwrap();
    // Equal masks of the other capture are the same content.
    assert_eq!(bench.blob_count().await, 3);
    assert!(bench.claim(Kind::Ingest).await.is_none());
}

async fn a_supplement_counts_in_the_quota_of_who_adds_it(on: On) {
    let bench = Bench::new(on).await;
    let capture = bench.capture("a").await;
    let quotas = Quotas { stored_bytes: Some(8), ..Quotas::default() };
    let add = async |kind, content: &'static str| {
        let content = bench.stage(content).await;
        let creator = Creator { owner: "ada".to_owned(), quotas };
        let new = NewSupplement { capture: capture.id, kind, content, creator };
        bench.store.captures().add_supplement(new).await
    };
    add(SupplementKind::Masks, "12345").await.unwrap();
    let refused = add(SupplementKind::Calibration, "1234").await.unwrap_err();
    assert!(matches!(refused, Error::QuotaBytes { stored: 5, more: 4, limit: 8, .. }), "{refused}");
    // What it replaces counts no more.
    add(SupplementKind::Masks, "12345678").await.unwrap();
    let refused = add(SupplementKind::Masks, "123456789").await.unwrap_err();
    assert!(matches!(refused, Error::QuotaBytes { stored: 0, more: 9, .. }), "{refused}");
    assert_eq!(there(&bench, &capture).await, [(SupplementKind::Masks, 8)]);
    assert_eq!(bench.blob_count().await, 2);
}

/// A crash at any point of a replacement: the capture has the old file or the new one, whole, and
/// nothing is left over; the repeated call finds or makes it.
async fn supplements_survive_crashes_whole(on: On) {
    let kind = SupplementKind::Masks;
    for point in Failpoint::ALL {
        let bench = Bench::new(on).await;
        let capture = bench.capture("a").await;
        add(&bench, &capture, kind, "old").await.unwrap();
        bench.store.inner.armed.arm(point);
        assert!(add(&bench, &capture, kind, "newer").await.is_err(), "{point:?}");

        let bench = bench.reopen().await;
        let content = bench.store.captures().supplement_content(capture.id, kind).await.unwrap();
        let is_new = matches!(point, Failpoint::AfterCommit | Failpoint::BeforeRelease);
        assert_eq!(content.size_bytes, if is_new { 5 } else { 3 }, "{point:?}");
        assert_eq!(bench.blob_count().await, 2, "{point:?}");
        add(&bench, &capture, kind, "newer").await.unwrap();
        assert_eq!(there(&bench, &capture).await, [(kind, 5)], "{point:?}");
        assert_eq!(bench.blob_count().await, 2, "{point:?}");
    }
}
