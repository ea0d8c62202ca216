use std::time::Duration;

use bendtwin_core::{Category, Problem as _};
use sqlx::Connection as _;

use crate::{
    Error, Kind, State,
    database::testing::On,
    store::tests::{Bench, LEASE, lease_of, new_fit},
};

/// Runs a statement on the connection that writes.
async fn tell(bench: &Bench, statement: &'static str) {
    sqlx::query(statement).execute(bench.store.inner.database.writer()).await.unwrap();
}

/// Lets the database grow no further, as a full disk does.
async fn fill(bench: &Bench) {
    let pages: i64 = sqlx::query_scalar("pragma page_count")
        .fetch_one(bench.store.inner.database.writer())
        .await
        .unwrap();
    let limit = sqlx::AssertSqlSafe(format!("pragma max_page_count = {pages}"));
    sqlx::query(limit).execute(bench.store.inner.database.writer()).await.unwrap();
}

/// Writes a row that does not fit on the existing pages: SQLite ends the transaction by itself.
async fn overflow(bench: &Bench) -> Error {
    let mut tx = bench.store.inner.database.write().await.unwrap();
    let large =
        "insert into workers (id, endpoint, backend, device, build, lanes, supervised, started_at)
         values ('a', hex(zeroblob(500000)), '', '', '', 0, false, 0)";
    crate::sql::query(large).execute(&mut tx).await.unwrap_err()
}

#[tokio::test]
async fn writes_work_again_once_a_full_disk_has_room() {
    let bench = Bench::new(On::Sqlite).await;
    let capture = bench.capture("a").await;
    let jobs = bench.store.jobs();
    let fit = jobs.create_fit(new_fit(&capture)).await.unwrap();
    bench.claim(Kind::Fit).await.unwrap();
    fill(&bench).await;
    let full = overflow(&bench).await;
    assert_eq!((full.category(), full.reason()), (Category::ResourceExhausted, "DISK_FULL"));
    tell(&bench, "pragma max_page_count = 1000000").await;
    // The fit of a worker that fell silent meanwhile goes back to the queue.
    assert_eq!(bench.pass(2 * LEASE).await.len(), 1);
    assert_eq!(jobs.get(fit.id).await.unwrap().state, State::Queued);
    bench.store.probe_write().await.unwrap();
    bench.store.captures().delete(bench.capture("b").await.id).await.unwrap();
}

#[tokio::test]
async fn a_connection_that_lost_its_transaction_is_not_used_again() {
    let bench = Bench::new(On::Sqlite).await;
    // As SQLite does after an error of the disk, behind the back of the pool.
    let mut tx = bench.store.inner.database.write().await.unwrap();
    crate::sql::query("rollback").execute(&mut tx).await.unwrap();
    drop(tx);
    bench.store.probe_write().await.unwrap();
    // The same where the pool has no transaction and SQLite has.
    tell(&bench, "begin immediate").await;
    bench.store.probe_write().await.unwrap();
}

#[tokio::test]
async fn writes_that_are_given_up_half_way_leave_no_transaction() {
    let bench = Bench::new(On::Sqlite).await;
    for steps in 0..40 {
        let mut write = Box::pin(bench.store.probe_write());
        for _ in 0..steps {
            if futures::poll!(&mut write).is_ready() {
                break;
            }
            tokio::time::sleep(Duration::from_micros(200)).await;
        }
        drop(write);
        bench.capture("a").await;
    }
    bench.store.probe_write().await.unwrap();
}

#[tokio::test]
async fn the_lock_of_another_program_is_no_failure_of_the_server() {
    let bench = Bench::new(On::Sqlite).await;
    let capture = bench.capture("a").await;
    tell(&bench, "pragma busy_timeout = 20").await;
    let file = bench.dir.path().join(super::FILE);
    let mut other = sqlx::SqliteConnection::connect(file.to_str().unwrap()).await.unwrap();
    let held = other.begin_with("begin immediate").await.unwrap();
    let busy = bench.store.jobs().create_fit(new_fit(&capture)).await.unwrap_err();
    assert_eq!((busy.category(), busy.reason()), (Category::Unavailable, "DATABASE_BUSY"));
    drop(held);
    other.close().await.unwrap();
    bench.store.jobs().create_fit(new_fit(&capture)).await.unwrap();
    let lease = lease_of(&bench.claim(Kind::Fit).await.unwrap());
    bench.store.jobs().report(lease, None, LEASE).await.unwrap();
}

#[tokio::test]
async fn damaged_pages_are_noticed_at_start() {
    let bench = Bench::new(On::Sqlite).await;
    bench.capture("a").await;
    let dir = bench.close().await;
    let file = dir.path().join(super::FILE);
    let mut bytes = std::fs::read(&file).unwrap();
    // All pages but the first, which has the schema.
    bytes[4096..].iter_mut().for_each(|byte| *byte ^= 0x55);
    std::fs::write(&file, bytes).unwrap();
    let refused = crate::Store::open(crate::Options::new(dir.path())).await.unwrap_err();
    assert_eq!((refused.category(), refused.reason()), (Category::DataLoss, "DATABASE_DAMAGED"));
    assert!(refused.to_string().contains("bendtwin store check"), "{refused}");
    std::fs::write(&file, "no database at all, for a hundred bytes and more ".repeat(99)).unwrap();
    let refused = crate::Store::open(crate::Options::new(dir.path())).await.unwrap_err();
    assert_eq!(refused.reason(), "DATABASE_DAMAGED");
}

#[cfg(unix)]
#[tokio::test]
async fn other_users_can_read_nothing() {
    use std::os::unix::fs::PermissionsExt;
    let folder = tempfile::tempdir().unwrap();
    let data_dir = folder.path().join("new");
    let mode =
        |name: &str| std::fs::metadata(data_dir.join(name)).unwrap().permissions().mode() & 0o777;
    let open = async || crate::Store::open(crate::Options::new(&data_dir)).await.unwrap();
    open().await.close().await;
    assert_eq!((mode(""), mode("blobs"), mode("bendtwin.sqlite")), (0o700, 0o700, 0o600));
    // A folder that others made is theirs to open; what is in it is not.
    for (name, open) in [("", 0o755), ("blobs", 0o755), ("bendtwin.sqlite", 0o644)] {
        let open = PermissionsExt::from_mode(open);
        std::fs::set_permissions(data_dir.join(name), open).unwrap();
    }
    open().await.close().await;
    assert_eq!((mode(""), mode("blobs"), mode("bendtwin.sqlite")), (0o755, 0o700, 0o600));
}
