//! Repair of a store. It never deletes anything of possible value: a damaged database stays beside
//! the rebuilt one, damaged content goes to `blobs/damaged`, content without a row to
//! `blobs/found`.

use std::{fs, path::Path, sync::Arc};

use jiff::Timestamp;
use serde::Serialize;
use sqlx::{ConnectOptions as _, Connection as _};

use super::{
    integrity, mend,
    survey::{self, Damage, Depth},
};
use crate::{
    Error, Result,
    blobs::{
        Place, files,
        references::{self, Reference},
    },
    database::{self, Database},
    folder::{self, disk::Reserve},
    sql::query,
    store::meter::{Meter, Part},
    store::{clock::micros, identity},
};

/// Outcome of a repair.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Repair {
    /// All that was done, a sentence each.
    pub actions: Vec<String>,
    /// Content that could not be brought back. Uploading the same archive or importing the same
    /// twin file brings it back, since content is found by its digest.
    pub lost: Vec<Damage>,
}

/// Repairs a store that no server has open.
///
/// # Errors
/// [`Error::DataDirInUse`]; [`Error::BeyondRepair`] if the database cannot be read well enough to
/// be rebuilt; database and file errors.
pub async fn repair(data_dir: &Path) -> Result<Repair> {
    let mut done = Repair::default();
    if !data_dir.is_dir() {
        return Err(Error::NotFound { name: data_dir.display().to_string() });
    }
    database::require_settled(data_dir)?;
    database::require_none(data_dir)?;
    database::require_local_objects(data_dir, "restore a version of it there")?;
    let lock = database::lock(data_dir)?;
    let file = data_dir.join(database::FILE);
    if file.try_exists()? {
        mend_database(&file, &mut done).await.map_err(|error| match error {
            Error::DatabaseDamaged { fault } => Error::BeyondRepair { fault },
            error => error,
        })?;
    } else {
        done.actions.push(format!("made a new database {}", file.display()));
    }
    let reserve = Arc::new(Reserve::open(data_dir));
    let database =
        Database::open(data_dir, None, lock, reserve, Meter::idle(Part::Database)).await?;
    let mended = mend_content(data_dir, &database, &mut done).await;
    database.close().await;
    mended.map(|()| done)
}

/// Rebuilds a damaged database: its indexes from the tables, else the file from what can be read.
async fn mend_database(file: &Path, done: &mut Repair) -> Result<()> {
    let mut connection = database::options(file).connect().await?;
    let faults = integrity::faults(&mut connection).await?;
    let Some(first) = faults.first() else { return Ok(connection.close().await?) };
    tracing::info!(faults = faults.len(), first, "the database is damaged");
    let reindexed = sqlx::query("reindex").execute(&mut connection).await.is_ok();
    if reindexed && integrity::faults(&mut connection).await?.is_empty() {
        done.actions.push(format!("rebuilt the indexes of the database ({first})"));
        return Ok(connection.close().await?);
    }
    let rebuilt = file.with_extension("rebuilt");
    fs::remove_file(&rebuilt).or_else(unless_missing)?;
    let copied = sqlx::query("vacuum into $1")
        .bind(rebuilt.to_string_lossy().into_owned())
        .execute(&mut connection)
        .await;
    connection.close().await.ok();
    let sound = match copied {
        Ok(_) => integrity::faults(&mut integrity::open(&rebuilt).await?).await?.is_empty(),
        Err(_) => false,
    };
    if !sound {
        fs::remove_file(&rebuilt).or_else(unless_missing)?;
        return Err(Error::BeyondRepair { fault: first.clone() });
    }
    let kept = file.with_extension(format!("damaged-{}", Timestamp::now().as_second()));
    for suffix in ["-wal", "-shm", ""] {
        let with = |path: &Path| {
            let mut name = path.as_os_str().to_owned();
            name.push(suffix);
            name
        };
        fs::rename(with(file), with(&kept)).or_else(unless_missing)?;
    }
    fs::File::open(&rebuilt)?.sync_all()?;
    fs::rename(&rebuilt, file)?;
    file.parent().map(folder::sync).transpose()?;
    done.actions.push(format!(
        "rebuilt the database from what can be read of it ({first}); the damaged one is {}",
        kept.display()
    ));
    Ok(())
}

/// Makes rows and content agree.
async fn mend_content(data_dir: &Path, database: &Database, done: &mut Repair) -> Result<()> {
    let blobs = data_dir.join("blobs");
    let now = micros(Timestamp::now());
    let (mine, theirs) = (identity::of_database(database.read()).await?, files::identity(&blobs)?);
    if mine.is_none() || mine != theirs {
        let place = Place::open(None, data_dir, false, Meter::idle(Part::Content))?;
        identity::join(database, mine, &place, now).await?;
        done.actions.push("gave the database and the content one identity".to_owned());
    }
    let references: Vec<Reference> = query(references::ALL).fetch_all(database.read()).await?;
    let mut lost = Vec::new();
    for reference in &references {
        let Some(damage) = survey::inspect(&blobs, reference, Depth::Digests)? else { continue };
        if !restore(&blobs, &damage, done)? {
            lost.push(damage);
        }
    }
    done.lost = mend::rows(database, lost, now, &mut done.actions).await?;
    set_aside_strangers(&blobs, &references, done)
}

/// Puts content back that is in the trash or was found before. Returns false if it is in neither.
fn restore(blobs: &Path, damage: &Damage, done: &mut Repair) -> Result<bool> {
    let place = files::published(blobs, &damage.digest);
    if place.exists() {
        // Two rows may share what the first of them brought back.
        if files::is_content(&place, &damage.digest)? {
            return Ok(true);
        }
        let kept = files::beside(blobs, "damaged", &damage.digest);
        shift(&place, &kept)?;
        done.actions.push(format!(
            "moved the damaged {} of {} to {}",
            damage.part,
            damage.name,
            kept.display()
        ));
    }
    for folder in ["trash", "found"] {
        let file = files::beside(blobs, folder, &damage.digest);
        if file.exists() && files::is_content(&file, &damage.digest)? {
            shift(&file, &place)?;
            let Damage { name, part, .. } = damage;
            done.actions.push(format!("took the {part} of {name} back from blobs/{folder}"));
            return Ok(true);
        }
    }
    Ok(false)
}

/// Moves blobs that no row refers to to a folder that nothing empties.
fn set_aside_strangers(blobs: &Path, references: &[Reference], done: &mut Repair) -> Result<()> {
    let known: std::collections::BTreeSet<&str> =
        references.iter().map(|reference| reference.digest.as_str()).collect();
    let (mut count, mut bytes) = (0, 0);
    for (digest, size_bytes) in files::all(blobs)? {
        if !known.contains(digest.as_str()) {
            shift(&files::published(blobs, &digest), &files::beside(blobs, "found", &digest))?;
            (count, bytes) = (count + 1, bytes + size_bytes);
        }
    }
    if count > 0 {
        done.actions.push(format!(
            "moved {count} blobs without a row ({bytes} bytes) to {}: nothing removes them there",
            blobs.join("found").display()
        ));
    }
    Ok(())
}

/// Renames a file, and syncs the names.
fn shift(from: &Path, to: &Path) -> Result<()> {
    let parent = to.parent().unwrap_or(to);
    folder::make(parent)?;
    fs::rename(from, to)?;
    folder::sync(parent)?;
    Ok(())
}

fn unless_missing(error: std::io::Error) -> std::io::Result<()> {
    if error.kind() == std::io::ErrorKind::NotFound { Ok(()) } else { Err(error) }
}
