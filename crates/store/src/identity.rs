//! The identity of a store, which its database and its blobs share. A database beside the blobs of
//! another would take all of them for garbage.

use std::{fs, io, io::Write as _, path::Path};

use crate::{
    Error, Result,
    blobs::files,
    database::{self, Database},
    folder, references,
    references::Reference,
    servers,
    sql::{Readers, query, query_scalar},
};

/// Name of the file in the folder of the blobs.
const FILE: &str = "identity";

/// Refuses blobs without a database, before a new one is made beside them.
pub(crate) fn require_database(data_dir: &Path) -> Result<()> {
    let file = data_dir.join(database::FILE);
    if !file.try_exists()? && files::any(&data_dir.join("blobs"))? {
        return Err(Error::DatabaseMissing { file });
    }
    Ok(())
}

/// Refuses a folder without blobs beside a database that another server has open just now: what its
/// rows refer to is elsewhere, and would be missed here.
pub(crate) async fn require_content(database: &Database, data_dir: &Path) -> Result<()> {
    let blobs = data_dir.join("blobs");
    if of_blobs(&blobs)?.is_none()
        && of_database(database.read()).await?.is_some()
        && servers::any_lately(database).await?
    {
        return Err(Error::ContentElsewhere { database: database.name().to_owned(), blobs });
    }
    Ok(())
}

/// Checks that database and blobs belong together. Gives them an identity if they are new, or from
/// before there were identities.
pub(crate) async fn settle(database: &Database, data_dir: &Path, now: i64) -> Result<()> {
    let blobs = data_dir.join("blobs");
    let mine = of_database(database.read()).await?;
    let theirs = of_blobs(&blobs)?;
    if mine.is_some() && mine == theirs {
        return Ok(());
    }
    let sqlite = data_dir.join(database::FILE);
    if mine.is_none() && database.is_remote() && sqlite.try_exists()? {
        let database = database.name().to_owned();
        return Err(Error::StoreNotMigrated { file: sqlite, database });
    }
    let strangers = theirs.is_some() || !any_referred(database.read(), &blobs).await?;
    if strangers && files::any(&blobs)? {
        return Err(Error::StoreMismatch { database: database.name().to_owned(), blobs });
    }
    join(database, mine, &blobs, now).await
}

/// Checks that database and blobs still belong together.
pub(crate) async fn verify(database: &Database, data_dir: &Path) -> Result<()> {
    let blobs = data_dir.join("blobs");
    let mine = of_database(database.read()).await?;
    if mine.is_some() && mine == of_blobs(&blobs)? {
        return Ok(());
    }
    Err(Error::StoreMismatch { database: database.name().to_owned(), blobs })
}

/// Makes database and blobs belong together.
pub(crate) async fn join(
    database: &Database,
    mine: Option<String>,
    blobs: &Path,
    now: i64,
) -> Result<()> {
    let identity = match mine {
        Some(identity) => identity,
        None => {
            let identity = uuid::Uuid::new_v4().to_string();
            let mut tx = database.write().await?;
            query("insert into store (id, identity, probed_at) values (1, $1, $2)")
                .bind(&identity)
                .bind(now)
                .execute(&mut tx)
                .await?;
            tx.commit().await?;
            identity
        }
    };
    folder::make(blobs)?;
    // Whole or not at all: half an identity would be another one.
    let partial = blobs.join("identity.partial");
    let mut file = fs::File::create(&partial)?;
    writeln!(file, "{identity}")?;
    file.sync_all()?;
    fs::rename(partial, blobs.join(FILE))?;
    folder::sync(blobs)?;
    Ok(())
}

pub(crate) async fn of_database(readers: &Readers) -> Result<Option<String>> {
    let identity = query_scalar("select identity from store where id = 1");
    identity.fetch_optional(readers).await
}

pub(crate) fn of_blobs(blobs: &Path) -> Result<Option<String>> {
    match fs::read_to_string(blobs.join(FILE)) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(None),
        read => Ok(Some(read?.trim().to_owned())),
    }
}

/// True if any row refers to any blob that is there.
async fn any_referred(readers: &Readers, blobs: &Path) -> Result<bool> {
    let all: Vec<Reference> = query(references::ALL).fetch_all(readers).await?;
    Ok(all.iter().any(|reference| files::published(blobs, &reference.digest).exists()))
}

#[cfg(test)]
mod tests;
