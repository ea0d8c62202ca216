//! Backup of a store, beside a running server or without one.
//!
//! The database is copied first, as a snapshot, and then the content that its rows refer to.
//! Content never changes, so the only race is with deletions: if content that the copy needs has
//! gone, its row has gone as well, and the database is copied once more. Content that is missing
//! from two copies in a row is missing from the store itself.

use std::{
    collections::BTreeSet,
    fs, io,
    path::{Path, PathBuf},
};

use serde::Serialize;
use sqlx::{ConnectOptions as _, Connection as _};

use super::{
    check, integrity,
    survey::{self, Damage, UPLOAD},
};
use crate::{
    Error, Result,
    blobs::{files, references::Reference},
    database, folder,
};

/// Copies of the database after which a backup gives up.
const MOST_ROUNDS: usize = 100;

/// Outcome of a backup.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Backup {
    /// Number of blobs.
    pub blobs: usize,
    /// Sizes of the blobs together [bytes].
    pub blobs_bytes: u64,
    /// Number of blobs that share the files of the store, by hard links.
    pub linked: usize,
    /// Content of rows that the store itself lacks.
    pub lost: Vec<Damage>,
}

/// Copies a store to a folder that is new or empty. Uploads under way are not part of it.
///
/// # Errors
/// [`Error::NotFound`] if there is no database, [`Error::BackupNotEmpty`]; database and file errors.
pub async fn backup(data_dir: &Path, to: &Path) -> Result<Backup> {
    database::require_none(data_dir)?;
    database::require_local_objects(data_dir, "back it up there, and the database by itself")?;
    folder::make(to)?;
    if fs::read_dir(to)?.next().is_some() {
        return Err(Error::BackupNotEmpty { folder: to.to_owned() });
    }
    let mut source = integrity::read_only(data_dir).await?;
    let copy = to.join(database::FILE);
    let (from, into) = (data_dir.join("blobs"), to.join("blobs"));
    let mut done = Backup::default();
    let mut missing = None;
    for _ in 0..MOST_ROUNDS {
        let partial = to.join("database.partial");
        fs::remove_file(&partial).or_else(unless_missing)?;
        sqlx::query("vacuum into $1")
            .bind(partial.to_string_lossy().into_owned())
            .execute(&mut source)
            .await?;
        folder::close_to_others(&partial, folder::FILE);
        fs::rename(&partial, &copy)?;
        let wanted = without_uploads(&copy).await?;
        let places = (from.clone(), into.clone());
        let fetched = tokio::task::spawn_blocking(move || fetch(&places.0, &places.1, &wanted));
        let (linked, lost) = fetched.await.map_err(io::Error::other)??;
        done.linked += linked;
        if lost.is_empty() || missing.as_ref() == Some(&lost) {
            done.lost = lost;
            return finish(done, &from, to).await;
        }
        missing = Some(lost);
    }
    Err(Error::DatabaseBusy)
}

/// Ends the uploads in a copy, whose files are not copied. Returns what its rows refer to.
async fn without_uploads(copy: &Path) -> Result<Vec<Reference>> {
    let options = sqlx::sqlite::SqliteConnectOptions::new().filename(copy);
    let mut connection = options.connect().await?;
    sqlx::query(
        "update uploads set state = 'gone', why = 'it was under way in a backup: begin a new one',
             digest = null, request_id = null where state = 'receiving'",
    )
    .execute(&mut connection)
    .await?;
    let wanted = check::all(&mut connection).await?;
    connection.close().await?;
    Ok(wanted.into_iter().filter(|reference| reference.part != UPLOAD).collect())
}

/// Brings all content that is wanted, and removes other. Returns the number of links and what could
/// not be brought.
fn fetch(from: &Path, into: &Path, wanted: &[Reference]) -> Result<(usize, Vec<Damage>)> {
    let (mut linked, mut lost) = (0, Vec::new());
    for reference in wanted {
        let Reference { name, part, digest, .. } = reference;
        let place = files::published(into, digest);
        if place.exists() {
            continue;
        }
        let sources = [
            files::published(from, digest),
            files::beside(from, "trash", digest),
            files::beside(from, "found", digest),
        ];
        let brought = sources.iter().find_map(|source| bring(source, &place, digest).transpose());
        match brought.transpose()? {
            Some(Brought::Linked) => linked += 1,
            Some(Brought::Copied) => {}
            found => {
                let fault = if found.is_some() { "other content" } else { "missing" }.to_owned();
                let (name, part, digest) = (name.clone(), part.clone(), digest.clone());
                lost.push(Damage { name, part, digest, fault });
            }
        }
    }
    lost.sort();
    let known: BTreeSet<&str> = wanted.iter().map(|r| r.digest.as_str()).collect();
    for (digest, _) in files::all(into)? {
        if !known.contains(digest.as_str()) {
            fs::remove_file(files::published(into, &digest))?;
        }
    }
    Ok((linked, lost))
}

enum Brought {
    Linked,
    Copied,
    /// The source has other content than its name says.
    Damaged,
}

/// Links a file or, from another disk, copies it. None if it is not there.
fn bring(source: &PathBuf, place: &Path, digest: &str) -> Result<Option<Brought>> {
    folder::make(place.parent().unwrap_or(place))?;
    match fs::hard_link(source, place) {
        Ok(()) => return Ok(Some(Brought::Linked)),
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
        Err(_) => {}
    }
    let partial = place.with_extension("partial");
    match fs::copy(source, &partial) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
        copied => copied?,
    };
    if !survey::is_content(&partial, digest)? {
        fs::remove_file(&partial)?;
        return Ok(Some(Brought::Damaged));
    }
    fs::File::open(&partial)?.sync_all()?;
    fs::rename(&partial, place)?;
    Ok(Some(Brought::Copied))
}

/// Completes the folder, and makes it last.
async fn finish(mut done: Backup, from: &Path, to: &Path) -> Result<Backup> {
    let into = to.join("blobs");
    folder::make(&into)?;
    if from.join("identity").exists() {
        fs::copy(from.join("identity"), into.join("identity"))?;
    }
    let there = files::all(&into)?;
    done.blobs = there.len();
    // Those of rows that went between two copies of the database were linked for nothing.
    done.linked = done.linked.min(done.blobs);
    done.blobs_bytes = there.iter().map(|(_, size_bytes)| size_bytes).sum();
    fs::File::open(to.join(database::FILE))?.sync_all()?;
    folder::sync(&into)?;
    folder::sync(to)?;
    Ok(done)
}

fn unless_missing(error: io::Error) -> io::Result<()> {
    if error.kind() == io::ErrorKind::NotFound { Ok(()) } else { Err(error) }
}
