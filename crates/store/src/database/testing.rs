//! Databases and buckets for tests: SQLite and content in the folder of a test, a separate database
//! on the PostgreSQL server that `BENDTWIN_TEST_POSTGRES` names (`tests/postgres` starts one), or
//! SQLite with content below a separate path in a bucket of the S3 server that `BENDTWIN_TEST_S3`
//! names (`tests/s3` starts one). Without these the tests that need them say that they are skipped.

use std::io::Write as _;

use sqlx::{AssertSqlSafe, ConnectOptions as _, Connection as _, postgres::PgConnectOptions};

use crate::{DatabaseUrl, ObjectsUrl};

/// Environment variable with the URL of a server on which tests may make databases.
const SERVER: &str = "BENDTWIN_TEST_POSTGRES";
/// Environment variable with the address of an S3 server that has the bucket [`BUCKET`].
const S3: &str = "BENDTWIN_TEST_S3";
/// The bucket of all tests.
const BUCKET: &str = "bendtwin-test";

/// The database of a test, and the place of content.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum On {
    Sqlite,
    Postgres,
    /// SQLite, and content in a bucket.
    Bucket,
}

impl On {
    /// PostgreSQL, if there is a server.
    pub(crate) fn postgres_or_skip() -> Option<Self> {
        there(SERVER, "PostgreSQL server").then_some(Self::Postgres)
    }

    /// A bucket, if there is a server.
    pub(crate) fn bucket_or_skip() -> Option<Self> {
        there(S3, "S3 server").then_some(Self::Bucket)
    }

    /// A place of content for one test, if it is not the folder.
    pub(crate) fn objects(self) -> Option<ObjectsUrl> {
        (self == Self::Bucket).then(own_bucket)
    }
}

/// A new path in the bucket of all tests.
pub(crate) fn own_bucket() -> ObjectsUrl {
    let name = uuid::Uuid::new_v4().simple();
    ObjectsUrl::parse(&format!("s3://{BUCKET}/{name}")).unwrap()
}

/// True if a server is named; else says that the test is skipped.
fn there(variable: &str, what: &str) -> bool {
    if std::env::var_os(variable).is_some() {
        return true;
    }
    // Past the capture of what tests print.
    let mut shown = std::io::stderr().lock();
    let test = std::thread::current().name().unwrap_or_default().to_owned();
    writeln!(shown, "SKIPPED {test}: {variable} names no {what}").ok();
    false
}

/// Runs each of these tests on both databases, and with content in a bucket.
macro_rules! on_both {
    ($($test:ident),* $(,)?) => {
        $crate::database::testing::on_databases!($($test),*);
        mod bucket {
            $(#[tokio::test] async fn $test() {
                if let Some(on) = $crate::database::testing::On::bucket_or_skip() {
                    super::$test(on).await;
                }
            })*
        }
    };
}
pub(crate) use on_both;

/// Runs each of these tests on both databases, with content in the folder.
macro_rules! on_databases {
    ($($test:ident),* $(,)?) => {
        mod sqlite {
            $(#[tokio::test] async fn $test() {
                super::$test($crate::database::testing::On::Sqlite).await;
            })*
        }
        mod postgres {
            $(#[tokio::test] async fn $test() {
                if let Some(on) = $crate::database::testing::On::postgres_or_skip() {
                    super::$test(on).await;
                }
            })*
        }
    };
}
pub(crate) use on_databases;

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
