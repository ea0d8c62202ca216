//! Backup of a store into a folder, beside running servers or without them.
//!
//! First all content is copied that the folder lacks, however long that takes. Then a snapshot of the
//! rows is taken, the little that came meanwhile is copied, and the new database takes the place of the
//! old one in the folder; last, content that only the old one needed is removed. So the folder has a whole
//! backup at every moment, and a backup that was killed is run again. What is to be copied is kept from
//! deletion ([`super::source`]). A server of an older version may delete it still; then its row has gone as
//! well, and another snapshot is taken.

use std::{
    collections::{BTreeMap, BTreeSet},
    fs, io,
    path::{Path, PathBuf},
};

use futures::{StreamExt as _, TryStreamExt as _, stream};
use jiff::Timestamp;
use serde::Serialize;
use sqlx::{ConnectOptions as _, Connection as _, sqlite::SqliteConnectOptions};

use super::{
    manifest::Manifest,
    rest,
    rows::{self, Connection, CopiedTable},
    site::Site,
    source::{Source, missing},
    survey::Damage,
};
use crate::{
    CLIENT_TOKEN, Error, Result,
    blobs::{
        Fetched, files, own,
        references::{self, Reference},
    },
    database::{self, migrations, sqlite},
    folder,
    sql::query,
};

/// Snapshots after which a backup gives up.
const MOST_ROUNDS: usize = 100;
/// Passes over the content before the first snapshot, and missing content that needs none of them.
const PASSES: usize = 4;
const FEW: usize = 64;
/// Blobs copied concurrently.
const AT_ONCE: usize = 8;

/// Outcome of a backup.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Backup {
    /// What the folder is.
    pub manifest: Manifest,
    /// The tables as they were read.
    pub tables: Vec<CopiedTable>,
    /// Number of blobs.
    pub blobs: usize,
    /// Sizes of the blobs together [bytes].
    pub blobs_bytes: u64,
    /// Number of blobs that this run brought.
    pub brought: usize,
    /// Number of these that share the files of the store, by hard links.
    pub linked: usize,
    /// True if the client token is part of it.
    pub client_token: bool,
    /// Content of rows that the store itself lacks.
    pub lost: Vec<Damage>,
}

/// Copies a store to a folder that is new or empty, or has an earlier backup of it. Uploads under way are
/// not part of it.
///
/// # Errors
/// [`Error::NotFound`] if there is no store; [`Error::DatabaseElsewhere`], [`Error::ObjectsElsewhere`],
/// [`Error::StoreMismatch`]; [`Error::StoreNewer`] and [`Error::StoreOlder`]; [`Error::BackupNotEmpty`],
/// [`Error::BackupOfAnother`], [`Error::BackupInUse`]; errors of database, bucket and files.
pub async fn backup(site: &Site, to: &Path) -> Result<Backup> {
    let mut source = Source::open(site).await?;
    let made = Run::begin(&source, to);
    let made = match made {
        Ok(run) => run.complete(site, &mut source).await,
        Err(error) => Err(error),
    };
    let closed = source.close().await;
    let made = made?;
    closed.map(|()| made)
}

/// A backup under way.
#[derive(Debug)]
struct Run {
    to: PathBuf,
    blobs: PathBuf,
    manifest: Manifest,
    /// Sizes of the blobs that the folder has [bytes].
    there: BTreeMap<String, u64>,
    brought: usize,
    linked: usize,
    /// Keeps a second backup out of the folder.
    _lock: fs::File,
}

impl Run {
    /// Takes the folder.
    fn begin(source: &Source, to: &Path) -> Result<Self> {
        folder::make(to)?;
        let before = Manifest::read(to)?;
        let strange = |name: std::ffi::OsString| name != database::LOCK;
        let mut entries = fs::read_dir(to)?;
        if before.is_none() && entries.any(|e| e.is_ok_and(|e| strange(e.file_name()))) {
            return Err(Error::BackupNotEmpty { folder: to.to_owned() });
        }
        let lock = database::lock(to).map_err(|error| in_use(error, to))?;
        let mut manifest = Manifest::new(&source.identity, &source.name);
        if let Some(before) = before {
            if before.store != manifest.store {
                return Err(Error::BackupOfAnother { folder: to.to_owned() });
            }
            manifest.taken = before.taken;
        } else {
            manifest.write(to)?;
        }
        folder::close_to_others(to, folder::FOLDER);
        let blobs = own(to);
        let there = files::all(&blobs)?.into_iter().collect();
        let to = to.to_owned();
        Ok(Self { to, blobs, manifest, there, brought: 0, linked: 0, _lock: lock })
    }

    async fn complete(mut self, site: &Site, source: &mut Source) -> Result<Backup> {
        for _ in 0..PASSES {
            let wanted = source.references().await?;
            let missing: Vec<&str> = missing(&wanted, &self.there).collect();
            if missing.len() <= FEW {
                break;
            }
            source.keep(&missing).await?;
            self.bring(source, &wanted).await?;
        }
        let mut lost_before = None;
        for _ in 0..MOST_ROUNDS {
            source.snapshot(&self.there).await?;
            let taken = Timestamp::now();
            let (tables, wanted) = self.copy_rows(source).await?;
            let lost = self.bring(source, &wanted).await?;
            // What two snapshots in a row lack is missing from the store itself.
            if lost.is_empty() || lost_before.as_ref() == Some(&lost) {
                return self.finish(site, source, taken, tables, &wanted, lost).await;
            }
            lost_before = Some(lost);
        }
        Err(Error::DatabaseBusy)
    }

    /// Copies the snapshot of the rows to a new database. Returns what its rows refer to.
    async fn copy_rows(&self, source: &mut Source) -> Result<(Vec<CopiedTable>, Vec<Reference>)> {
        let file = self.partial();
        fs::remove_file(&file).or_else(unless_missing)?;
        folder::create(&file)?;
        // The file counts only once it is whole and synced.
        let options = SqliteConnectOptions::new()
            .filename(&file)
            // Rows come table by table, and were consistent where they come from.
            .foreign_keys(false)
            .journal_mode(sqlx::sqlite::SqliteJournalMode::Memory)
            .synchronous(sqlx::sqlite::SqliteSynchronous::Off);
        let mut connection = options.connect().await?;
        migrations::sqlite().run(&mut connection).await?;
        let mut copy = Connection::Sqlite(connection);
        copy.begin_writing().await?;
        let mut tables = Vec::new();
        for table in &source.tables {
            let name = file.display().to_string();
            tables.push(rows::copy(&mut source.reader, &mut copy, table, &name).await?);
        }
        source.reader.commit().await?;
        let Connection::Sqlite(mut connection) = copy else { return Err(Error::DatabaseBusy) };
        rest::bring(&mut connection).await?;
        query("commit").execute(&mut connection).await?;
        let wanted: Vec<Reference> = query(references::ALL).fetch_all(&mut connection).await?;
        connection.close().await?;
        Ok((tables, wanted))
    }

    fn partial(&self) -> PathBuf {
        self.to.join("database.partial")
    }

    /// Brings all content that is wanted and not there. Returns what could not be brought.
    async fn bring(&mut self, source: &Source, wanted: &[Reference]) -> Result<Vec<Damage>> {
        let digests: Vec<String> = missing(wanted, &self.there).map(str::to_owned).collect();
        let (place, blobs) = (&source.place, &self.blobs);
        let fetched = stream::iter(digests)
            .map(|digest| async move {
                let to = files::published(blobs, &digest);
                let fetched = place.fetch(&digest, to.clone()).await?;
                let size_bytes = match fetched {
                    Fetched::Linked | Fetched::Copied => fs::metadata(&to)?.len(),
                    Fetched::Damaged | Fetched::Missing => 0,
                };
                Ok::<_, Error>((digest, fetched, size_bytes))
            })
            .buffer_unordered(AT_ONCE)
            .try_collect::<Vec<_>>()
            .await?;
        let mut faults = BTreeMap::new();
        for (digest, fetched, size_bytes) in fetched {
            match fetched {
                Fetched::Damaged => drop(faults.insert(digest, "other content")),
                Fetched::Missing => drop(faults.insert(digest, "missing")),
                Fetched::Linked | Fetched::Copied => {
                    self.linked += usize::from(fetched == Fetched::Linked);
                    self.brought += 1;
                    self.there.insert(digest, size_bytes);
                }
            }
        }
        let damage = |reference: &Reference| {
            let Reference { name, part, digest, .. } = reference.clone();
            let fault = (*faults.get(&digest)?).to_owned();
            Some(Damage { name, part, digest, fault })
        };
        let mut lost: Vec<Damage> = wanted.iter().filter_map(damage).collect();
        lost.sort();
        Ok(lost)
    }

    /// Makes the folder a backup of this snapshot.
    async fn finish(
        mut self,
        site: &Site,
        source: &Source,
        taken: Timestamp,
        tables: Vec<CopiedTable>,
        wanted: &[Reference],
        lost: Vec<Damage>,
    ) -> Result<Backup> {
        files::set_identity(&self.blobs, &source.identity)?;
        let client_token = copy_token(&site.client_token(), &self.to)?
            || self.to.join(CLIENT_TOKEN).try_exists()?;
        sync_all(&self.blobs)?;
        let partial = self.partial();
        fs::File::open(&partial)?.sync_all()?;
        fs::rename(&partial, self.to.join(sqlite::FILE))?;
        self.manifest.taken = Some(taken);
        self.manifest.write(&self.to)?;
        let known: BTreeSet<&str> = wanted.iter().map(|r| r.digest.as_str()).collect();
        for (digest, _) in files::all(&self.blobs)? {
            if !known.contains(digest.as_str()) {
                fs::remove_file(files::published(&self.blobs, &digest)).or_else(unless_missing)?;
                self.there.remove(&digest);
            }
        }
        Ok(Backup {
            manifest: self.manifest,
            tables,
            blobs: self.there.len(),
            blobs_bytes: self.there.values().sum(),
            brought: self.brought,
            linked: self.linked,
            client_token,
            lost,
        })
    }
}

/// Copies the client token to a folder. Returns false if it is missing.
pub(super) fn copy_token(from: &Path, to: &Path) -> Result<bool> {
    match fs::read(from) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(false),
        token => {
            folder::write(&to.join(CLIENT_TOKEN), &token?)?;
            Ok(true)
        }
    }
}

/// Makes the names of all blobs last.
fn sync_all(blobs: &Path) -> io::Result<()> {
    for folder in files::folders(blobs)? {
        folder::sync(&folder)?;
    }
    folder::sync(blobs)
}

/// The error of a lock that another backup or a restore holds.
pub(super) fn in_use(error: Error, folder: &Path) -> Error {
    match error {
        Error::DataDirInUse => Error::BackupInUse { folder: folder.to_owned() },
        error => error,
    }
}

fn unless_missing(error: io::Error) -> io::Result<()> {
    if error.kind() == io::ErrorKind::NotFound { Ok(()) } else { Err(error) }
}

#[cfg(test)]
mod tests;
