//! A crash at any point of a deletion, a restoration or a purge.

use super::*;

on_both! {
    deletions_survive_crashes,
    restorations_survive_crashes,
    purges_survive_crashes,
}

/// All of them have their content, and nothing else is stored.
async fn assert_whole(bench: &Bench, point: Failpoint) -> (usize, usize) {
    let captures = bench.store.captures().list(&Default::default()).await.unwrap().items;
    for capture in &captures {
        bench.store.captures().content(capture.id).await.unwrap();
    }
    let trash = bench.store.trash();
    let trashed =
        trash.list(Collection::Captures, "", None, &PageRequest::default()).await.unwrap();
    let (live, trashed) = (captures.len(), trashed.items.len());
    assert_eq!(bench.blob_count().await, live + trashed, "{point:?}");
    (live, trashed)
}

async fn deletions_survive_crashes(on: On) {
    for point in Failpoint::ALL {
        let bench = Bench::new(on).await;
        bench.capture("kept").await;
        let id = bench.capture("doomed").await.id;
        bench.store.inner.armed.arm(point);
        let done = bench.store.trash().put(id, &deletion()).await.is_ok();
        let bench = bench.reopen().await;
        let lasts = done || point == Failpoint::AfterCommit;
        let expected = if lasts { (1, 1) } else { (2, 0) };
        assert_eq!(assert_whole(&bench, point).await, expected, "{point:?}");
        restore(&bench, id).await.unwrap();
        assert_eq!(assert_whole(&bench, point).await, (2, 0), "{point:?}");
    }
}

async fn restorations_survive_crashes(on: On) {
    for point in Failpoint::ALL {
        let bench = Bench::new(on).await;
        let id = bench.fresh_capture("a").await.id;
        put(&bench, id).await;
        bench.store.inner.armed.arm(point);
        let done = restore(&bench, id).await.is_ok();
        let bench = bench.reopen().await;
        let lasts = done || point == Failpoint::AfterCommit;
        let expected = if lasts { (1, 0) } else { (0, 1) };
        assert_eq!(assert_whole(&bench, point).await, expected, "{point:?}");
        restore(&bench, id).await.unwrap();
        assert_eq!(bench.claim(Kind::Ingest).await.map(|job| job.capture), Some(id));
    }
}

async fn purges_survive_crashes(on: On) {
    for point in Failpoint::ALL {
        let bench = Bench::new(on).await;
        bench.capture("kept").await;
        put(&bench, bench.capture("doomed").await.id).await;
        bench.clock.advance(8 * DAY);
        bench.store.inner.armed.arm(point);
        let done = bench.store.trash().sweep().await.is_ok();
        let bench = bench.reopen().await;
        let lasts = done || point == Failpoint::BeforeRelease;
        let expected = if lasts { (1, 0) } else { (1, 1) };
        assert_eq!(assert_whole(&bench, point).await, expected, "{point:?}");
        bench.store.trash().sweep().await.unwrap();
        assert_eq!(assert_whole(&bench, point).await, (1, 0), "{point:?}");
    }
}
