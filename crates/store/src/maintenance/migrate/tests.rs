use bendtwin_core::Problem as _;

use super::*;
use crate::{
    CaptureChange, Creator, Kind, LabelChange, ListQuery, NewSupplement, Options, Store,
    SupplementKind, TwinFacts,
    database::testing::{On, TestDatabase},
    maintenance::{Depth, check},
    store::tests::{Bench, LEASE, lease_of, new_fit},
};

/// More rows than one statement takes.
const MANY: usize = 600;

/// A store with rows in most tables.
async fn filled() -> Bench {
    let bench = Bench::new(On::Sqlite).await;
    let capture = bench.capture("a").await;
    let labels = LabelChange {
        note: Some("quotes ' and \"ünïcode\" \\ too".into()),
        add_tags: vec!["b-c".into(), "bc".into(), "B".into()],
        ..LabelChange::default()
    };
    let change = CaptureChange { labels, recorded_by: Some("Ada".into()) };
    bench.store.captures().update(capture.id, &change).await.unwrap();
    let (kind, content) = (SupplementKind::Masks, bench.stage("masks").await);
    let new = NewSupplement { capture: capture.id, kind, content, creator: Creator::default() };
    bench.store.captures().add_supplement(new).await.unwrap();
    for _ in 0..MANY {
        bench.store.jobs().create_fit(new_fit(&capture)).await.unwrap();
    }
    let lease = lease_of(&bench.claim(Kind::Fit).await.unwrap());
    let facts = TwinFacts { quality: "{}".into(), fps: 0.1 + 0.2, ..TwinFacts::default() };
    bench.store.jobs().complete_fit(lease, &facts, bench.stage("twin").await).await.unwrap();
    let lease = lease_of(&bench.claim(Kind::Fit).await.unwrap());
    bench.store.jobs().save_checkpoint(lease, bench.stage("half").await, LEASE).await.unwrap();
    bench
}

#[tokio::test]
async fn a_store_moves_with_all_its_rows() {
    let Some(_) = On::postgres_or_skip() else { return };
    let bench = filled().await;
    let query = ListQuery::default();
    let before = (
        bench.store.captures().list(&query).await.unwrap().items,
        bench.store.jobs().fits(&query).await.unwrap().items,
        bench.store.twins().list(&query).await.unwrap().items,
    );
    let to = TestDatabase::new().await;
    let busy = migrate(bench.dir.path(), &to.url).await.unwrap_err();
    assert_eq!(busy.reason(), "DATA_DIR_IN_USE");
    let dir = bench.close().await;
    let file = dir.path().join(database::FILE);
    let kept = std::fs::read(&file).unwrap();
    let moved = migrate(dir.path(), &to.url).await.unwrap();
    let jobs = moved.tables.iter().find(|table| table.name == "jobs").unwrap();
    assert_eq!((moved.was_moved, jobs.rows), (false, MANY as u64 + 1));

    // A start without the URL touches nothing, and neither do the commands for SQLite.
    assert!(!file.exists());
    let refused = Store::open(Options::new(dir.path())).await.unwrap_err();
    assert_eq!(refused.reason(), "DATABASE_ELSEWHERE");
    let refused = check(dir.path(), Depth::Sizes).await.unwrap_err();
    assert_eq!(refused.reason(), "DATABASE_ELSEWHERE");

    // Interrupted before the old file was put away: the command completes it.
    std::fs::write(&file, kept).unwrap();
    let again = migrate(dir.path(), &to.url).await.unwrap();
    assert_eq!((again.was_moved, &again.tables), (true, &moved.tables));
    assert!(!file.exists());

    let options = Options { database: Some(to.url.clone()), ..Options::new(dir.path()) };
    let store = Store::open(options).await.unwrap();
    let after = (
        store.captures().list(&query).await.unwrap().items,
        store.jobs().fits(&query).await.unwrap().items,
        store.twins().list(&query).await.unwrap().items,
    );
    assert_eq!(after, before);
    let recorded = ListQuery { recorded_by: "Ada".into(), ..ListQuery::default() };
    assert_eq!(store.captures().list(&recorded).await.unwrap().items, after.0);
    store.twins().content(after.2[0].id).await.unwrap();
    let capture = after.0[0].id;
    store.captures().supplement_content(capture, SupplementKind::Masks).await.unwrap();
    store.close().await;
}

#[tokio::test]
async fn a_database_with_rows_and_a_folder_that_was_not_moved_are_refused() {
    let Some(on) = On::postgres_or_skip() else { return };
    let other = Bench::new(on).await;
    other.capture("another").await;
    let bench = filled().await;
    let dir = bench.close().await;
    let refused = migrate(dir.path(), &other.url().unwrap()).await.unwrap_err();
    assert_eq!(refused.reason(), "DATABASE_NOT_EMPTY");
    assert!(dir.path().join(database::FILE).exists());
    let to = TestDatabase::new().await;
    let options = Options { database: Some(to.url.clone()), ..Options::new(dir.path()) };
    let refused = Store::open(options).await.unwrap_err();
    assert_eq!(refused.reason(), "STORE_NOT_MIGRATED");
    Store::open(Options::new(dir.path())).await.unwrap().close().await;
    migrate(dir.path(), &to.url).await.unwrap();
}
