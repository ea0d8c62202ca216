//! Content by digest. An upload streams to a temporary object while it is hashed; publishing
//! renames it to the path derived from its digest, so equal content shares one object.
//!
//! | folder | content |
//! |---|---|
//! | `blake3` | what rows refer to, by digest |
//! | `incoming` | uploads under way; emptied at start |
//! | `partial` | uploads that can be resumed |
//! | `trash` | what no row referred to, for a day |
//! | `found` | what a repair found no row for; nothing removes it |

mod content;
pub(crate) mod files;
mod partial;
mod trash;
mod upload;

use std::{
    path::{Path as FsPath, PathBuf},
    sync::Arc,
};

use futures::TryStreamExt;
use object_store::{
    ObjectStore, ObjectStoreExt, RenameOptions, local::LocalFileSystem, path::Path,
};
use tokio::sync::{RwLock, RwLockReadGuard, RwLockWriteGuard};

use crate::{
    Result,
    disk::Reserve,
    failpoint::{Armed, Failpoint},
    folder,
};

pub use content::Content;
pub use upload::{Staged, Upload};

const INCOMING: &str = "incoming";
const PUBLISHED: &str = "blake3";
const TRASH: &str = "trash";

/// The blobs of a store. Clones share it.
#[derive(Clone, Debug)]
pub struct Blobs {
    objects: Arc<dyn ObjectStore>,
    root: Arc<PathBuf>,
    /// Lock shared by callers that publish and then refer, and exclusive for those that delete.
    gate: Arc<RwLock<()>>,
    armed: Arc<Armed>,
    reserve: Arc<Reserve>,
}

impl Blobs {
    /// Opens a local folder, and empties its `incoming` if no other server has the folder open.
    pub(crate) async fn open(
        root: &FsPath,
        is_alone: bool,
        armed: Arc<Armed>,
        reserve: Arc<Reserve>,
    ) -> Result<Self> {
        if is_alone {
            match tokio::fs::remove_dir_all(root.join(INCOMING)).await {
                Err(error) if error.kind() != std::io::ErrorKind::NotFound => {
                    return Err(error.into());
                }
                _ => {}
            }
        }
        folder::make(root)?;
        folder::close_to_others(root, folder::FOLDER);
        let objects = LocalFileSystem::new_with_prefix(root)?.with_fsync(true);
        let root = Arc::new(root.to_owned());
        Ok(Self { objects: Arc::new(objects), root, gate: Arc::default(), armed, reserve })
    }

    /// Begins an upload of at most `limit` bytes.
    ///
    /// # Errors
    /// [`crate::Error::DiskFull`]; if no temporary object can be made.
    pub async fn upload(&self, limit: u64) -> Result<Upload> {
        let path = Path::from_iter([INCOMING, &uuid::Uuid::new_v4().simple().to_string()]);
        let sink = self.objects.put_multipart(&path).await?;
        Ok(Upload::new(self.clone(), path, sink, limit))
    }

    /// Refuses new content of some size on a full disk. Little content gets through: it may be the
    /// result of a job.
    fn admit(&self) -> Result<()> {
        self.reserve.admit()
    }

    /// Writes, syncs and removes a small file.
    pub(crate) async fn probe(&self) -> Result<()> {
        let folder = self.root.join(INCOMING);
        let file = folder.join(format!("probe-{}", uuid::Uuid::new_v4().simple()));
        let probed = tokio::task::spawn_blocking(move || {
            folder::make(&folder)?;
            let written = std::fs::write(&file, [0; 4096])
                .and_then(|()| std::fs::OpenOptions::new().write(true).open(&file)?.sync_all());
            std::fs::remove_file(&file).and(written)
        });
        Ok(probed.await.map_err(std::io::Error::other)??)
    }

    /// Puts staged content in its place. The guard is held until the row that
    /// refers to it is committed.
    pub(crate) async fn publish(&self, staged: Staged) -> Result<RwLockReadGuard<'_, ()>> {
        self.publish_all(vec![staged]).await
    }

    /// As [`Blobs::publish`], for several contents that one transaction refers to. One guard for
    /// all of them: a second one would wait for a deletion that waits for the first.
    pub(crate) async fn publish_all(&self, staged: Vec<Staged>) -> Result<RwLockReadGuard<'_, ()>> {
        self.armed.pass(Failpoint::ContentStaged)?;
        let guard = self.gate.read().await;
        for content in staged {
            let to = published(&content.digest().to_hex());
            match content.path() {
                Some(path) => self.objects.rename_opts(path, &to, RenameOptions::new()).await?,
                // Put in place before a crash.
                None => self.require(&content.digest().to_hex(), &to).await?,
            }
            content.disarm();
        }
        self.armed.pass(Failpoint::ContentPublished)?;
        Ok(guard)
    }

    pub(crate) async fn close_gate(&self) -> RwLockWriteGuard<'_, ()> {
        self.gate.write().await
    }

    pub(crate) async fn delete(&self, digest: &str) -> Result<()> {
        self.delete_path(&published(digest)).await
    }

    /// True if this blob is published.
    pub(crate) async fn has(&self, digest: &str) -> Result<bool> {
        match self.objects.head(&published(digest)).await {
            Ok(_) => Ok(true),
            Err(object_store::Error::NotFound { .. }) => Ok(false),
            Err(error) => Err(error.into()),
        }
    }

    async fn delete_path(&self, path: &Path) -> Result<()> {
        match self.objects.delete(path).await {
            Err(object_store::Error::NotFound { .. }) | Ok(()) => Ok(()),
            Err(error) => Err(error.into()),
        }
    }

    /// Digests of all published blobs.
    pub(crate) async fn list(&self) -> Result<Vec<String>> {
        let listing = self.objects.list(Some(&Path::from(PUBLISHED)));
        let names = listing
            .try_filter_map(|meta| async move { Ok(meta.location.filename().map(str::to_owned)) });
        Ok(names.try_collect().await?)
    }
}

/// `trash/abcd...`.
fn trashed(digest: &str) -> Path {
    Path::from_iter([TRASH, digest])
}

/// `blake3/ab/abcd...`: folders of a 256th each keep listings short.
fn published(digest: &str) -> Path {
    Path::from_iter([PUBLISHED, digest.get(..2).unwrap_or("xx"), digest])
}

#[cfg(test)]
mod tests;
