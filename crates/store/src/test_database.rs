//! Databases for tests: SQLite in the folder of a test, or a database of its own on the PostgreSQL
//! server that `BENDTWIN_TEST_POSTGRES` names (`tests/postgres` starts one). Without that the tests
//! on PostgreSQL say that they are skipped.

use std::io::Write as _;

use sqlx::{AssertSqlSafe, ConnectOptions as _, Connection as _, postgres::PgConnectOptions};

use crate::DatabaseUrl;

/// Environment variable with the URL of a server on which tests may make databases.
const SERVER: &str = "BENDTWIN_TEST_POSTGRES";

/// The database of a test.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum On {
    Sqlite,
    Postgres,
}

impl On {
    /// PostgreSQL, if there is a server.
    pub(crate) fn postgres_or_skip() -> Option<Self> {
        if std::env::var_os(SERVER).is_some() {
            return Some(Self::Postgres);
        }
        // Past the capture of what tests print.
        let mut shown = std::io::stderr().lock();
        let test = std::thread::current().name().unwrap_or_default().to_owned();
        writeln!(shown, "SKIPPED {test}: {SERVER} names no PostgreSQL server").ok();
        None
    }
}

/// Runs each of these tests on both databases.
macro_rules! on_both {
    ($($test:ident),* $(,)?) => {
        mod sqlite {
            $(#[tokio::test] async fn $test() {
                super::$test($crate::test_database::On::Sqlite).await;
            })*
        }
        mod postgres {
            $(#[tokio::test] async fn $test() {
                if let Some(on) = $crate::test_database::On::postgres_or_skip() {
                    super::$test(on).await;
                }
            })*
        }
    };
}
pub(crate) use on_both;

/// A database on the server, removed at its end.
#[derive(Debug)]
pub(crate) struct TestDatabase {
    pub(crate) url: DatabaseUrl,
    name: String,
}

fn server() -> PgConnectOptions {
    std::env::var(SERVER).unwrap().parse().unwrap()
}

impl TestDatabase {
    pub(crate) async fn new() -> Self {
        let name = format!("bendtwin_test_{}", uuid::Uuid::new_v4().simple());
        let mut connection = server().connect().await.unwrap();
        let create = AssertSqlSafe(format!("create database {name}"));
        sqlx::query(create).execute(&mut connection).await.unwrap();
        connection.close().await.unwrap();
        let server = std::env::var(SERVER).unwrap();
        let (server, _) = server.rsplit_once('/').unwrap();
        let url = DatabaseUrl::parse(&format!("{server}/{name}")).unwrap();
        Self { url, name }
    }
}

impl Drop for TestDatabase {
    fn drop(&mut self) {
        // A test's runtime cannot wait in here.
        let remove = AssertSqlSafe(format!("drop database {} with (force)", self.name));
        let removed = std::thread::spawn(move || {
            let runtime =
                tokio::runtime::Builder::new_current_thread().enable_all().build().ok()?;
            runtime.block_on(async {
                let mut connection = server().connect().await.ok()?;
                sqlx::query(remove).execute(&mut connection).await.ok()
            })
        });
        removed.join().ok();
    }
}
