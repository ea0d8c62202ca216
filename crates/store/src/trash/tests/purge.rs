//! What is due goes, and earlier what a full disk needs.

use super::*;

on_both! {
    what_is_due_is_purged_with_its_content,
    a_shared_content_outlives_the_purge_of_one,
    what_was_deleted_first_is_purged_first_for_the_disk,
    one_server_at_a_time_purges,
}

async fn what_is_due_is_purged_with_its_content(on: On) {
    let bench = Bench::new(on).await;
    let trash = bench.store.trash();
    let kept = bench.capture("kept").await;
    let capture = put(&bench, observed(&bench, "archive").await.id).await;
    let twin = put(&bench, twin(&bench, "a", "twin").await).await;
    let fit = bench.store.jobs().create_fit(new_fit(&kept)).await.unwrap().id.fit().unwrap();
    let fit = put(&bench, fit).await;
    assert_eq!(trash.sweep().await.unwrap(), []);
    bench.clock.advance(7 * DAY - Duration::from_secs(1));
    assert_eq!(trash.sweep().await.unwrap(), []);
    restore(&bench, twin).await.unwrap();
    bench.clock.advance(Duration::from_secs(1));
    assert_eq!(trash.sweep().await.unwrap(), [capture, fit]);
    for gone in [capture, fit] {
        let error = restore(&bench, gone).await.unwrap_err();
        assert_eq!(error.reason(), "NOT_FOUND");
    }
    let Resource::Twin(twin) = twin else { unreachable!() };
    bench.store.twins().content(twin).await.unwrap();
    bench.store.captures().content(kept.id).await.unwrap();
    if on != On::Bucket {
        assert_eq!(bench.published_count().await, 2, "what was purged is released");
    }
}

async fn a_shared_content_outlives_the_purge_of_one(on: On) {
    let bench = Bench::new(on).await;
    let first = bench.capture("same").await;
    let second = bench.capture("same").await;
    put(&bench, first.id).await;
    bench.clock.advance(DAY);
    put(&bench, second.id).await;
    bench.clock.advance(6 * DAY);
    assert_eq!(bench.store.trash().sweep().await.unwrap(), [Resource::from(first.id)]);
    bench.store.collect_garbage().await.unwrap();
    restore(&bench, second.id).await.unwrap();
    bench.store.captures().content(second.id).await.unwrap();
}

async fn what_was_deleted_first_is_purged_first_for_the_disk(on: On) {
    let bench = Bench::new(on).await;
    let mut deleted = Vec::new();
    for content in ["a", "b", "c"] {
        deleted.push(put(&bench, bench.capture(content).await.id).await);
        bench.clock.advance(Duration::from_secs(1));
        deleted.push(put(&bench, twin(&bench, "a", content).await).await);
        bench.clock.advance(Duration::from_secs(1));
    }
    let mut wanted = 3;
    let enough = || {
        wanted -= 1;
        Ok(wanted >= 0)
    };
    let purged = bench.store.trash().purge_while(enough).await.unwrap();
    assert_eq!(purged, deleted[..3]);
    restore(&bench, deleted[3]).await.unwrap();
    // Every disk has more than nothing.
    assert_eq!(bench.store.trash().make_room(0).await.unwrap(), []);
    // No disk has that; a bucket is no disk.
    let all: &[Resource] = if on == On::Bucket { &[] } else { &deleted[4..] };
    assert_eq!(bench.store.trash().make_room(u64::MAX).await.unwrap(), all);
}

async fn one_server_at_a_time_purges(on: On) {
    if on != On::Postgres {
        return;
    }
    let bench = Bench::new(on).await;
    put(&bench, bench.capture("a").await.id).await;
    bench.clock.advance(8 * DAY);
    let turn = bench.store.inner.database.turn(super::super::sweep::TURN).await.unwrap().unwrap();
    assert_eq!(bench.store.trash().sweep().await.unwrap(), []);
    turn.end().await.unwrap();
    assert_eq!(bench.store.trash().sweep().await.unwrap().len(), 1);
}
