//! Databases that a newer version of the program has migrated, and servers of an older one that a
//! migration would break.

use std::collections::HashSet;

use sqlx::{PgConnection, migrate::Migrator};

use super::{BREAKING, newest};
use crate::{
    Error, Result,
    fleet::servers,
    sql::{Target, query, query_scalar},
};

/// The newest migration of a database, if it is one of a newer version of the program.
///
/// # Errors
/// [`Error::DatabaseNewer`] if this program cannot use the database any more.
pub(crate) async fn newer<'t>(target: impl Into<Target<'t>>) -> Result<Option<i64>> {
    let later = query(
        "select version, description from _sqlx_migrations where version > $1 order by version",
    );
    let later: Vec<(i64, String)> = later.bind(newest()).fetch_all(target).await?;
    let breaking = later.iter().find(|(_, name)| name.starts_with(BREAKING));
    if let Some((migration, name)) = breaking {
        let (migration, name) = (*migration, name[BREAKING.len()..].to_owned());
        return Err(Error::DatabaseNewer { migration, name, known: newest() });
    }
    Ok(later.last().map(|(version, _)| *version))
}

/// Refuses a migration that would break servers which have the database open.
///
/// Until the connection ends, or [`Migrator::run`] has made its changes, no server can begin: each
/// registers itself in a transaction that waits for this lock and finds the changes then.
pub(crate) async fn require_alone(
    connection: &mut PgConnection,
    migrator: &Migrator,
    write_lock: i64,
) -> Result<()> {
    let there = "select to_regclass('_sqlx_migrations')::text is not null
         and to_regclass('servers')::text is not null";
    if !query_scalar(there).fetch_one(&mut *connection).await? {
        return Ok(());
    }
    let applied: Vec<i64> =
        query_scalar("select version from _sqlx_migrations").fetch_all(&mut *connection).await?;
    let applied: HashSet<i64> = applied.into_iter().collect();
    let is_breaking = |name: &str| name.starts_with(BREAKING);
    if !migrator.iter().any(|m| !applied.contains(&m.version) && is_breaking(&m.description)) {
        return Ok(());
    }
    let locked = query_scalar("select pg_advisory_lock($1)::text").bind(write_lock);
    let _: String = locked.fetch_one(&mut *connection).await?;
    match servers::count_lately(connection).await? {
        0 => Ok(()),
        servers => Err(Error::OlderServersRun { servers }),
    }
}
