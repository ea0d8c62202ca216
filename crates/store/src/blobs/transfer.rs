//! Published content between a place and local files, for a backup, a restore and a move. Digests are
//! compared on the way, so damaged content arrives nowhere.

use std::{
    collections::BTreeMap,
    fs, io,
    path::{Path as FsPath, PathBuf},
    sync::Arc,
};

use futures::TryStreamExt as _;
use tokio::io::AsyncWriteExt as _;

use super::{Bucket, Place, TRASH, files, published};
use crate::{Digest, Result, folder};

/// Outcome of bringing content to a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Fetched {
    /// The file is the same as that of the place.
    Linked,
    Copied,
    /// The place has other content than its name says.
    Damaged,
    Missing,
}

impl Place {
    /// Sizes of all published blobs [bytes].
    pub(crate) async fn sizes(&self) -> Result<BTreeMap<String, u64>> {
        match self {
            Self::Folder(folder) => Ok(files::all(folder.root())?.into_iter().collect()),
            Self::Bucket(bucket) => of_bucket(bucket).await,
        }
    }

    /// Brings a published blob to a file, which is there whole or not at all.
    pub(crate) async fn fetch(&self, digest: &str, to: PathBuf) -> Result<Fetched> {
        match self {
            Self::Bucket(bucket) => download(bucket, digest, &to).await,
            Self::Folder(folder) => {
                let (root, digest) = (folder.root().to_owned(), digest.to_owned());
                let fetching = move || link(&root, &digest, &to);
                tokio::task::spawn_blocking(fetching).await.map_err(io::Error::other)?
            }
        }
    }

    /// Puts a local file in its place, where it stays. Returns false, and puts nothing, if its content
    /// is missing or other than the digest says.
    pub(crate) async fn put(&self, digest: &str, file: PathBuf) -> Result<bool> {
        let wanted = digest.to_owned();
        match self {
            Self::Bucket(bucket) => {
                let checked = file.clone();
                let checking = tokio::task::spawn_blocking(move || size_of(&checked, &wanted));
                let size_bytes = checking.await.map_err(io::Error::other)??;
                let Some(size_bytes) = size_bytes else { return Ok(false) };
                bucket.send(&file, &published(digest), size_bytes).await?;
                Ok(true)
            }
            Self::Folder(folder) => {
                let to = folder.file(digest);
                let copying = tokio::task::spawn_blocking(move || copy(&file, &to, &wanted));
                Ok(copying.await.map_err(io::Error::other)?? == Fetched::Copied)
            }
        }
    }
}

async fn of_bucket(bucket: &Bucket) -> Result<BTreeMap<String, u64>> {
    let mut sizes = BTreeMap::new();
    let mut listed = bucket.published();
    while let Some(object) = listed.try_next().await? {
        let digest = object.location.filename().map(str::to_owned);
        sizes.extend(digest.map(|digest| (digest, object.size)));
    }
    Ok(sizes)
}

/// Size of a file with this content [bytes].
fn size_of(file: &FsPath, digest: &str) -> io::Result<Option<u64>> {
    match files::is_content(file, digest) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(None),
        Err(error) => Err(error),
        Ok(false) => Ok(None),
        Ok(true) => Ok(Some(fs::metadata(file)?.len())),
    }
}

async fn download(bucket: &Arc<Bucket>, digest: &str, to: &FsPath) -> Result<Fetched> {
    let Some(mut opened) = bucket.read(&published(digest), None).await? else {
        return Ok(Fetched::Missing);
    };
    folder::make(to.parent().unwrap_or(to))?;
    let partial = to.with_extension("partial");
    let mut file = tokio::fs::File::from_std(folder::create(&partial)?);
    let mut hasher = blake3::Hasher::new();
    while let Some(chunk) = opened.chunks.try_next().await? {
        hasher.update(&chunk);
        file.write_all(&chunk).await?;
    }
    file.sync_all().await?;
    drop(file);
    if !Digest::from_hex(digest).is_ok_and(|wanted| wanted == hasher.finalize()) {
        fs::remove_file(&partial)?;
        return Ok(Fetched::Damaged);
    }
    fs::rename(&partial, to)?;
    Ok(Fetched::Copied)
}

/// Links a blob of a folder or, from another disk, copies it. What a server or a repair has set aside is
/// as good.
fn link(root: &FsPath, digest: &str, to: &FsPath) -> Result<Fetched> {
    folder::make(to.parent().unwrap_or(to))?;
    let mut found = Fetched::Missing;
    for source in [
        files::published(root, digest),
        files::beside(root, TRASH, digest),
        files::beside(root, "found", digest),
    ] {
        match fs::hard_link(&source, to) {
            Ok(()) => return Ok(Fetched::Linked),
            Err(error) if error.kind() == io::ErrorKind::NotFound => continue,
            Err(_) => {}
        }
        match copy(&source, to, digest)? {
            Fetched::Copied => return Ok(Fetched::Copied),
            Fetched::Damaged => found = Fetched::Damaged,
            Fetched::Linked | Fetched::Missing => {}
        }
    }
    Ok(found)
}

/// Copies a file, atomically and durably.
fn copy(source: &FsPath, to: &FsPath, digest: &str) -> Result<Fetched> {
    let parent = to.parent().unwrap_or(to);
    folder::make(parent)?;
    let partial = to.with_extension("partial");
    match fs::copy(source, &partial) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(Fetched::Missing),
        copied => copied?,
    };
    folder::close_to_others(&partial, folder::FILE);
    if !files::is_content(&partial, digest)? {
        fs::remove_file(&partial)?;
        return Ok(Fetched::Damaged);
    }
    fs::File::open(&partial)?.sync_all()?;
    fs::rename(&partial, to)?;
    folder::sync(parent)?;
    Ok(Fetched::Copied)
}
