//! The identity of a store, which its database and its blobs share. A database beside the blobs of
//! another would take all of them for garbage.

use std::path::Path;

use crate::{
    Error, Result,
    blobs::{
        Place,
        references::{self, Reference},
    },
    database::{self, Database},
    fleet::servers,
    sql::{Reading, query, query_scalar},
};

/// Refuses blobs without a database, before a new one is made beside them.
pub(crate) async fn require_database(data_dir: &Path, place: &Place) -> Result<()> {
    let file = data_dir.join(database::FILE);
    if !file.try_exists()? && place.any().await? {
        return Err(Error::DatabaseMissing { file });
    }
    Ok(())
}

/// Refuses a place without an identity beside a database that another server has open just now: what
/// its rows refer to is elsewhere, and would be missed here.
pub(crate) async fn require_content(database: &Database, place: &Place) -> Result<()> {
    if place.identity().await?.is_none()
        && of_database(database.read()).await?.is_some()
        && servers::any_lately(database).await?
    {
        let (database, blobs) = (database.name().to_owned(), place.name());
        return Err(Error::ContentElsewhere { database, blobs });
    }
    Ok(())
}

/// Checks that database and blobs belong together. Gives them an identity if they are new, or from
/// before there were identities.
pub(crate) async fn settle(
    database: &Database,
    data_dir: &Path,
    place: &Place,
    now: i64,
) -> Result<()> {
    // In this order: another server that begins at the same time writes that of the database first.
    let theirs = place.identity().await?;
    let mine = of_database(database.read()).await?;
    if mine.is_some() && mine == theirs {
        return Ok(());
    }
    let sqlite = data_dir.join(database::FILE);
    if mine.is_none() && database.is_remote() && sqlite.try_exists()? {
        let database = database.name().to_owned();
        return Err(Error::StoreNotMigrated { file: sqlite, database });
    }
    let strangers = theirs.is_some() || !any_referred(database.read(), place).await?;
    // Another server may be about to put content there.
    let taken = theirs.is_some() && place.is_shared();
    if taken || strangers && place.any().await? {
        return Err(mismatch(database, place));
    }
    join(database, mine, place, now).await
}

/// Checks that database and blobs still belong together.
pub(crate) async fn verify(database: &Database, place: &Place) -> Result<()> {
    let mine = of_database(database.read()).await?;
    if mine.is_some() && mine == place.identity().await? {
        return Ok(());
    }
    Err(mismatch(database, place))
}

fn mismatch(database: &Database, place: &Place) -> Error {
    Error::StoreMismatch { database: database.name().to_owned(), blobs: place.name() }
}

/// Makes database and blobs belong together.
pub(crate) async fn join(
    database: &Database,
    mine: Option<String>,
    place: &Place,
    now: i64,
) -> Result<()> {
    let identity = match mine {
        Some(identity) => identity,
        None => new_identity(database, now).await?,
    };
    place.set_identity(&identity).await
}

/// Gives a database an identity, unless another server has done so in this moment.
async fn new_identity(database: &Database, now: i64) -> Result<String> {
    let mut tx = database.write().await?;
    query("insert into store (id, identity, probed_at) values (1, $1, $2) on conflict do nothing")
        .bind(uuid::Uuid::new_v4().to_string())
        .bind(now)
        .execute(&mut tx)
        .await?;
    let identity = query_scalar("select identity from store where id = 1");
    let identity = identity.fetch_one(&mut tx).await?;
    tx.commit().await?;
    Ok(identity)
}

pub(crate) async fn of_database(readers: Reading<'_>) -> Result<Option<String>> {
    let identity = query_scalar("select identity from store where id = 1");
    identity.fetch_optional(readers).await
}

/// True if any row refers to an existing blob.
async fn any_referred(readers: Reading<'_>, place: &Place) -> Result<bool> {
    if !place.any().await? {
        return Ok(false);
    }
    let all: Vec<Reference> = query(references::ALL).fetch_all(readers).await?;
    for reference in all {
        if place.has(&reference.digest).await? {
            return Ok(true);
        }
    }
    Ok(false)
}

#[cfg(test)]
mod tests;
