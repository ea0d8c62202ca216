use std::collections::BTreeSet;

use bendtwin_core::{Problem as _, ids::ServerId};

use super::*;
use crate::{
    Error, Kind, Options, Servers, Store,
    database::{
        self,
        postgres::{connect, migrate},
        testing::{On, TestDatabase, on_databases},
    },
    sql::{query, query_scalar},
    store::tests::{Bench, new_fit},
};

/// The last migration before programs began to accept databases of newer ones.
const LAST_OF_ANY_KIND: i64 = 14;

on_databases! {
    a_database_that_a_newer_version_added_to_is_used_as_before,
    a_database_that_a_newer_version_broke_is_refused_and_not_touched,
}

#[test]
fn every_file_is_listed_under_its_name() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/migrations");
    let files: BTreeSet<_> = std::fs::read_dir(folder)
        .unwrap()
        .map(|file| {
            let file = file.unwrap();
            (file.file_name().into_string().unwrap(), std::fs::read_to_string(file.path()).unwrap())
        })
        .collect();
    let listed: BTreeSet<_> = MIGRATIONS
        .map(|(version, name, sql)| (format!("{version:04}_{name}.sql"), sql.to_owned()))
        .into();
    assert_eq!(listed, files);
}

/// Statements of a migration that a program which does not know them would trip over.
fn that_break(sql: &str) -> Vec<String> {
    let code = |line: &str| line.split("--").next().unwrap_or_default().to_lowercase();
    let code = sql.lines().map(code).collect::<Vec<_>>().join(" ");
    let words = |statement: &str| statement.split_whitespace().collect::<Vec<_>>().join(" ");
    let statements = code.split(';').map(words).filter(|statement| !statement.is_empty());
    let adds = |statement: &String| {
        let column = statement.starts_with("alter table") && statement.contains(" add column ");
        // It inserts rows without the column.
        let is_left_out = !statement.contains("not null") || statement.contains(" default ");
        let mut words = statement.split(|c: char| !c.is_alphanumeric() && c != '_');
        let has_rule = words.any(|word| ["unique", "references", "check"].contains(&word));
        statement.starts_with("create table")
            || statement.starts_with("create index")
            || column && is_left_out && !has_rule
    };
    statements.filter(|statement| !adds(statement)).collect()
}

#[test]
fn a_migration_only_adds_or_is_called_breaking() {
    for (version, name, sql) in MIGRATIONS {
        let may = version <= LAST_OF_ANY_KIND || name.starts_with(BREAKING);
        let breaks = that_break(sql);
        assert!(
            may || breaks.is_empty(),
            "{version:04}_{name}.sql: servers of the version before cannot run beside {breaks:?}: \
             add columns and tables alone, or begin its name with {BREAKING}"
        );
    }
    for adds in [
        "create table a (b text primary key); -- drop table c;\n create index d on a (b);",
        "alter table a add column b text; alter table a add column c bigint not null default 0;",
    ] {
        assert_eq!(that_break(adds), Vec::<String>::new());
    }
    for breaks in [
        "drop table a",
        "drop index a",
        "alter table a rename column b to c",
        "alter table a add column b text not null",
        "alter table a add column b text unique",
        "create unique index a on b (c)",
        "update a set b = 1",
    ] {
        assert_eq!(that_break(&format!("create table d (e text); {breaks};")), [breaks]);
    }
}

/// A database of every earlier version is opened, and what its captures lacked is empty.
#[tokio::test]
async fn a_database_of_any_earlier_version_is_migrated() {
    let id = uuid::Uuid::now_v7();
    for version in 1..newest() {
        let folder = tempfile::tempdir().unwrap();
        let file = database::options(&folder.path().join(database::FILE)).create_if_missing(true);
        let mut connection = sqlx::ConnectOptions::connect(&file).await.unwrap();
        let earlier: Vec<Migration> =
            super::sqlite().iter().filter(|m| m.version <= version).cloned().collect();
        Migrator::with_migrations(earlier).run(&mut connection).await.unwrap();
        let capture = query(
            "insert into captures (id, display_name, created_at, size_bytes, digest)
             values ($1, 'rope', 7, 5, $2)",
        );
        let capture = capture.bind(id.to_string()).bind("0".repeat(64));
        capture.execute(&mut connection).await.unwrap();
        sqlx::Connection::close(connection).await.unwrap();

        let store = Store::open(Options::new(folder.path())).await.unwrap();
        let found = store.captures().overview(id.into()).await.unwrap();
        assert_eq!(
            (found.capture.labels.display_name.as_str(), found.capture.size_bytes),
            ("rope", 5)
        );
        assert!(found.supplements.is_empty() && !found.has_masks && !found.ingest.masks_only);
        assert_eq!(found.ingest.state, crate::State::Queued, "{version}");
        store.close().await;
    }
}

/// Notes a migration as a newer version would after it has run it.
async fn note(bench: &Bench, version: i64, name: &str) {
    let noted = query(
        "insert into _sqlx_migrations (version, description, success, checksum, execution_time)
         select $1, $2, success, checksum, execution_time from _sqlx_migrations where version = 1",
    );
    bench.tell(noted.bind(version).bind(name)).await;
}

async fn a_database_that_a_newer_version_added_to_is_used_as_before(on: On) {
    let bench = Bench::new(on).await;
    let capture = bench.capture("a").await;
    let fit = bench.store.jobs().create_fit(new_fit(&capture)).await.unwrap();
    bench.tell(query("alter table jobs add column flavour text not null default 'plain'")).await;
    bench.tell(query("create table flavours (name text primary key)")).await;
    note(&bench, newest() + 1, "flavours").await;
    let is_function_of_newer = on == On::Postgres;
    if is_function_of_newer {
        let function = "create or replace function bendtwin_wake() returns trigger language plpgsql
             as $$ begin perform pg_notify('bendtwin_queue', 'newer'); return null; end $$";
        bench.tell(query(function)).await;
    }

    let bench = bench.reopen().await;
    bench.store.servers().seen(ServerId::generate(), "an older build").await.unwrap();
    bench.store.probe_write().await.unwrap();
    assert_eq!(bench.claim(Kind::Fit).await.unwrap().id, fit.id);
    let second = bench.store.jobs().create_fit(new_fit(&capture)).await.unwrap();
    let kept = query_scalar("select flavour from jobs where id = $1");
    let kept = kept.bind(second.id.uuid().to_string());
    let kept: String = kept.fetch_one(bench.store.inner.database.read()).await.unwrap();
    assert_eq!(kept, "plain");
    if is_function_of_newer {
        let source = query_scalar("select prosrc from pg_proc where proname = 'bendtwin_wake'");
        let source: String = source.fetch_one(bench.store.inner.database.read()).await.unwrap();
        assert!(source.contains("'newer'"), "an older server has replaced it: {source}");
    }
}

async fn a_database_that_a_newer_version_broke_is_refused_and_not_touched(on: On) {
    let bench = Bench::new(on).await;
    let capture = bench.capture("a").await;
    bench.tell(query("alter table store add column probed_by text")).await;
    let broken = newest() + 2;
    note(&bench, newest() + 1, "flavours").await;
    note(&bench, broken, "breaking_probes").await;
    // A server that stood still meanwhile.
    let seen = bench.store.servers().seen(ServerId::generate(), "an older build").await;
    let probed = bench.store.probe_write().await;
    let opened = bench.opened().await.map(drop);
    for refused in [seen, probed, opened] {
        let refused = refused.unwrap_err();
        assert_eq!(refused.reason(), "DATABASE_NEWER");
        let Error::DatabaseNewer { migration, name, known } = refused else { panic!() };
        assert_eq!((migration, name.as_str(), known), (broken, "probes", newest()));
    }
    let taken_back = query("delete from _sqlx_migrations where version > $1").bind(newest());
    if on == On::Sqlite {
        let folder = bench.close().await;
        let options = database::options(&folder.path().join(database::FILE));
        let mut connection = sqlx::ConnectOptions::connect(&options).await.unwrap();
        taken_back.execute(&mut connection).await.unwrap();
        let store = Store::open(Options::new(folder.path())).await.unwrap();
        assert_eq!(store.captures().get(capture.id).await.unwrap().id, capture.id);
    } else {
        let mut connection = connect(&bench.url().unwrap().options().unwrap()).await.unwrap();
        taken_back.execute(&mut connection).await.unwrap();
        let bench = bench.reopen().await;
        assert_eq!(bench.store.captures().get(capture.id).await.unwrap().id, capture.id);
    }
}

#[tokio::test]
async fn a_migration_that_breaks_others_waits_until_they_are_stopped() {
    let Some(_) = On::postgres_or_skip() else { return };
    let (database, folder) = (TestDatabase::new().await, tempfile::tempdir().unwrap());
    let url = Some(database.url.clone());
    // With the system's clock: the migration goes by that of the database.
    let options = Options { database: url, ..Options::new(folder.path()) };
    let older = Store::open(options).await.unwrap();
    let (server, build) = (ServerId::generate(), "an older build");
    let servers = Servers { store: &older };
    servers.seen(server, build).await.unwrap();
    let mut all: Vec<Migration> = super::postgres().iter().cloned().collect();
    let statement = SqlStr::from_static("alter table store rename column probed_at to asked_at");
    let kind = MigrationType::Simple;
    all.push(Migration::new(newest() + 1, "breaking_store".into(), kind, statement, false));
    let newer = Migrator::with_migrations(all);

    let connected = async || connect(&database.url.options().unwrap()).await.unwrap();
    let mut connection = connected().await;
    let refused = migrate(&mut connection, &newer).await.unwrap_err();
    assert!(matches!(refused, Error::OlderServersRun { servers: 1 }), "{refused}");
    drop(connection);
    servers.seen(server, build).await.unwrap();
    older.probe_write().await.unwrap();

    servers.forget(server).await.unwrap();
    let mut connection = connected().await;
    let of_older = migrate(&mut connection, &newer).await;
    // The tables are migrated; that this program cannot use them is what it says next.
    assert!(matches!(of_older, Err(Error::DatabaseNewer { .. })), "{of_older:?}");
    let begun = servers.seen(server, build).await;
    assert!(matches!(begun, Err(Error::DatabaseNewer { .. })), "{begun:?}");
}
