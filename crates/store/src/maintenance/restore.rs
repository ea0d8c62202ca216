//! Restore of a backup to a new store of any kind: SQLite or PostgreSQL, a folder or a bucket.
//!
//! The new store gets another identity than the one that was backed up, so that neither can take the
//! content of the other for garbage, however their options are mixed up. The folder `restoring` in the
//! data folder has that identity and the rows on their way. It is made once the target is known to be
//! empty, and removed last: a server refuses to start while it is there, and an interrupted restore is run
//! again and continues. The rows come after all content, in one step.

use std::{
    fs, io,
    path::{Path, PathBuf},
    sync::Arc,
};

use futures::{StreamExt as _, TryStreamExt as _, stream};
use serde::{Deserialize, Serialize};
use sqlx::Connection as _;
use uuid::Uuid;

use super::{
    backup::{copy_token, in_use},
    integrity,
    manifest::Manifest,
    migrate::transfer,
    rest,
    rows::{self, Connection, CopiedTable},
    site::Site,
    source::missing,
    survey::Damage,
};
use crate::{
    CLIENT_TOKEN, Error, Result,
    blobs::{
        Place, files, own,
        references::{self, Reference},
    },
    database::{self, postgres, sqlite},
    folder::{self, disk::Reserve},
    sql::{Readers, query},
};

/// Blobs copied concurrently.
const AT_ONCE: usize = 8;

/// Outcome of a restore.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Restore {
    /// What was restored; none of a copy that an older version made.
    pub manifest: Option<Manifest>,
    /// The database, without a password.
    pub database: String,
    /// The place of content.
    pub objects: String,
    /// The tables of the new store.
    pub tables: Vec<CopiedTable>,
    /// Number of blobs.
    pub blobs: usize,
    /// Sizes of the blobs together [bytes].
    pub blobs_bytes: u64,
    /// True if the client token was restored; otherwise a server makes a new one.
    pub client_token: bool,
    /// Content of rows that the backup lacks, or has damaged.
    pub lost: Vec<Damage>,
}

/// Facts of a restore that has begun.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
struct State {
    /// Identity of the new store.
    identity: String,
    /// What is restored.
    of: Option<Manifest>,
    database: String,
    objects: String,
}

/// Restores a backup to a store that is new and empty.
///
/// # Errors
/// [`Error::NotFound`], [`Error::BackupIncomplete`], [`Error::BackupInUse`], [`Error::DatabaseDamaged`] of
/// the backup; [`Error::DataDirInUse`], [`Error::DataDirNotEmpty`], [`Error::DatabaseNotEmpty`],
/// [`Error::ObjectsNotEmpty`], [`Error::AnotherRestore`] of the target; errors of database, bucket and files.
pub async fn restore(from: &Path, site: &Site) -> Result<Restore> {
    let (manifest, _lock) = open(from).await?;
    folder::make(&site.data_dir)?;
    let _target = database::lock(&site.data_dir)?;
    let staging = site.data_dir.join(database::RESTORING);
    let place = site.new_place()?;
    let state = begin(site, &place, &staging, manifest.clone()).await?;
    let wanted = stage_rows(from, &staging, &state).await?;

    place.set_identity(&state.identity).await?;
    let lost = bring(&own(from), &place, &wanted).await?;
    let client_token = bring_token(from, site)?;
    let tables = place_rows(site, &staging, &state).await?;
    if let Some(objects) = &site.objects {
        database::leave_objects(&site.data_dir, objects)?;
    }
    let sizes = place.sizes().await?;
    // Without its state the folder means nothing.
    fs::remove_file(staging.join(database::RESTORE_STATE))?;
    fs::remove_dir_all(&staging)?;
    folder::sync(&site.data_dir)?;
    Ok(Restore {
        manifest,
        database: state.database,
        objects: state.objects,
        tables,
        blobs: sizes.len(),
        blobs_bytes: sizes.values().sum(),
        client_token,
        lost,
    })
}

/// Opens a backup: one with a manifest, or a data folder that no server has open, as older versions made
/// backups.
async fn open(from: &Path) -> Result<(Option<Manifest>, fs::File)> {
    let file = from.join(sqlite::FILE);
    let manifest = Manifest::read(from)?;
    if manifest.as_ref().is_some_and(|manifest| manifest.taken.is_none()) {
        return Err(Error::BackupIncomplete { folder: from.to_owned() });
    }
    if !file.try_exists()? {
        return Err(Error::NotFound { name: file.display().to_string() });
    }
    database::require_none(from)?;
    database::require_local_objects(from, "back the store up first (`bendtwin store backup`)")?;
    // A backup may be on a file system that can only be read.
    let lock = match fs::File::open(from.join(database::LOCK)) {
        Ok(lock) => lock,
        Err(_) => fs::File::open(&file)?,
    };
    match lock.try_lock_shared() {
        Ok(()) => {}
        Err(fs::TryLockError::WouldBlock) => return Err(in_use(Error::DataDirInUse, from)),
        Err(fs::TryLockError::Error(error)) => return Err(error.into()),
    }
    let mut connection = integrity::read_only(from).await?;
    if let Some(fault) = integrity::faults(&mut connection).await?.into_iter().next() {
        return Err(Error::BackupDamaged { folder: from.to_owned(), fault });
    }
    connection.close().await?;
    Ok((manifest, lock))
}

/// Begins a restore to an empty target, or continues the one that was begun there.
async fn begin(site: &Site, place: &Place, staging: &Path, of: Option<Manifest>) -> Result<State> {
    let (database, objects) = (site.database_name(), place.name());
    let identity = Uuid::new_v4().to_string();
    let state = State { identity, of, database, objects };
    match fs::read(staging.join(database::RESTORE_STATE)) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => {}
        text => {
            let before: State = serde_json::from_slice(&text?).map_err(io::Error::other)?;
            let same = State { identity: before.identity.clone(), ..state };
            if same != before {
                return Err(Error::AnotherRestore { folder: site.data_dir.clone() });
            }
            return Ok(before);
        }
    }
    require_empty(site, place).await?;
    folder::make(staging)?;
    let text = serde_json::to_vec_pretty(&state).map_err(io::Error::other)?;
    folder::write(&staging.join(database::RESTORE_STATE), &text)?;
    folder::sync(&site.data_dir)?;
    Ok(state)
}

/// Refuses a target that has anything of a store.
async fn require_empty(site: &Site, place: &Place) -> Result<()> {
    for entry in fs::read_dir(&site.data_dir)? {
        let entry = entry?;
        let name = entry.file_name();
        let harmless = name == database::LOCK
            || name == CLIENT_TOKEN
            || name == database::RESTORING
            // The place of content, which is looked at below.
            || name == "blobs"
            // Some file systems have it.
            || name == "lost+found";
        if !harmless {
            return Err(Error::DataDirNotEmpty { folder: site.data_dir.clone() });
        }
    }
    if files::any(&own(&site.data_dir))? || files::identity(&own(&site.data_dir))?.is_some() {
        return Err(Error::DataDirNotEmpty { folder: site.data_dir.clone() });
    }
    if place.any().await? || place.identity().await?.is_some() {
        return Err(Error::ObjectsNotEmpty { objects: place.name() });
    }
    if site.database.is_some() {
        let mut database = connect(site).await?;
        if !database.is_empty(&rows::tables().await?).await? {
            return Err(Error::DatabaseNotEmpty { database: site.database_name() });
        }
        database.close().await?;
    }
    Ok(())
}

/// A connection to the database of PostgreSQL, with all tables.
async fn connect(site: &Site) -> Result<Connection> {
    let Some(url) = &site.database else {
        return Err(Error::NotFound { name: site.database_name() });
    };
    let mut connection = postgres::connect(&url.options()?).await?;
    postgres::prepare(&mut connection).await?;
    Ok(Connection::Postgres(connection))
}

/// Copies the rows of the backup to a database in the staging folder, with the tables of this version and
/// the new identity. Returns what they refer to.
async fn stage_rows(from: &Path, staging: &Path, state: &State) -> Result<Vec<Reference>> {
    for suffix in ["-wal", "-shm", ""] {
        let file = staging.join(format!("{}{suffix}", sqlite::FILE));
        if let Err(error) = fs::remove_file(file)
            && error.kind() != io::ErrorKind::NotFound
        {
            return Err(error.into());
        }
    }
    let file = staging.join(sqlite::FILE);
    let mut backup = integrity::read_only(from).await?;
    sqlx::query("vacuum into $1")
        .bind(file.to_string_lossy().into_owned())
        .execute(&mut backup)
        .await?;
    backup.close().await?;
    let (writer, readers) = sqlite::open(staging, Arc::new(Reserve::open(staging))).await?;
    if let Readers::Sqlite(readers) = readers {
        readers.close().await;
    }
    writer.close().await;
    let Connection::Sqlite(mut connection) = Connection::sqlite(&file).await? else {
        return Ok(Vec::new());
    };
    query("begin immediate").execute(&mut connection).await?;
    rest::bring(&mut connection).await?;
    query("update store set identity = $1").bind(&state.identity).execute(&mut connection).await?;
    query("commit").execute(&mut connection).await?;
    query("pragma wal_checkpoint(truncate)").execute(&mut connection).await?;
    let wanted = query(references::ALL).fetch_all(&mut connection).await?;
    connection.close().await?;
    Ok(wanted)
}

/// Puts all content in its place that is not there. Returns what the backup lacks.
async fn bring(from: &Path, place: &Place, wanted: &[Reference]) -> Result<Vec<Damage>> {
    let there = place.sizes().await?;
    let digests: Vec<String> = missing(wanted, &there).map(str::to_owned).collect();
    let lacking = stream::iter(digests)
        .map(|digest| async move {
            let put = place.put(&digest, files::published(from, &digest)).await?;
            Ok::<_, Error>((!put).then_some(digest))
        })
        .buffer_unordered(AT_ONCE)
        .try_filter_map(|digest| std::future::ready(Ok(digest)))
        .try_collect::<std::collections::BTreeSet<String>>()
        .await?;
    let lost = wanted.iter().filter(|reference| lacking.contains(&reference.digest));
    let lost = lost.map(|reference| {
        let Reference { name, part, digest, .. } = reference.clone();
        let is_there = files::published(from, &digest).exists();
        let fault = if is_there { "other content" } else { "missing" }.to_owned();
        Damage { name, part, digest, fault }
    });
    Ok(lost.collect())
}

/// Copies the client token, unless the target has one. Returns false if the backup has none.
fn bring_token(from: &Path, site: &Site) -> Result<bool> {
    let to: PathBuf = site.data_dir.join(CLIENT_TOKEN);
    if site.client_token.is_some() || to.try_exists()? {
        return Ok(false);
    }
    copy_token(&from.join(CLIENT_TOKEN), &site.data_dir)
}

/// Puts the rows in their place, in one step.
async fn place_rows(site: &Site, staging: &Path, state: &State) -> Result<Vec<CopiedTable>> {
    let file = staging.join(sqlite::FILE);
    let mut staged = Connection::sqlite(&file).await?;
    let Some(url) = &site.database else {
        let mut tables = Vec::new();
        for table in rows::tables().await? {
            tables.push(staged.digest(&table).await?);
        }
        staged.close().await?;
        fs::File::open(&file)?.sync_all()?;
        fs::rename(&file, site.data_dir.join(sqlite::FILE))?;
        folder::sync(&site.data_dir)?;
        return Ok(tables);
    };
    let mut target = connect(site).await?;
    let done = transfer(&mut staged, &mut target, &state.database).await?;
    target.close().await?;
    staged.close().await?;
    database::leave_marker(&site.data_dir, url)?;
    Ok(done.tables)
}

#[cfg(test)]
mod tests;
