//! Content by digest. An upload streams to a temporary object while it is hashed; publishing
//! renames it to the path derived from its digest, so equal content shares one object.

mod partial;
mod upload;

use std::{
    path::{Path as FsPath, PathBuf},
    sync::Arc,
};

use bytes::Bytes;
use futures::{StreamExt, TryStreamExt, stream::BoxStream};
use object_store::{
    GetResultPayload, ObjectStore, ObjectStoreExt, RenameOptions, local::LocalFileSystem,
    path::Path,
};
use tokio::sync::{RwLock, RwLockReadGuard, RwLockWriteGuard};
use tokio_util::io::ReaderStream;

use crate::{
    Digest, Error, Result,
    failpoint::{Armed, Failpoint},
};

pub use upload::{Staged, Upload};

const INCOMING: &str = "incoming";
const PUBLISHED: &str = "blake3";
/// Bytes per chunk of a download.
const CHUNK: usize = 1 << 20;

/// The blobs of a store. Clones share it.
#[derive(Clone, Debug)]
pub struct Blobs {
    objects: Arc<dyn ObjectStore>,
    root: Arc<PathBuf>,
    /// Lock shared by callers that publish and then refer, and exclusive for those that delete.
    gate: Arc<RwLock<()>>,
    armed: Arc<Armed>,
}

/// A blob being read. The reader is not affected if it is deleted meanwhile.
pub struct Content {
    /// Size [bytes].
    pub size_bytes: u64,
    /// Its bytes, in chunks of up to 1 MiB.
    pub chunks: BoxStream<'static, Result<Bytes>>,
}

impl std::fmt::Debug for Content {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Content").field("size_bytes", &self.size_bytes).finish_non_exhaustive()
    }
}

impl Blobs {
    /// Opens a local folder and empties its `incoming`.
    pub(crate) async fn open(root: &FsPath, armed: Arc<Armed>) -> Result<Self> {
        match tokio::fs::remove_dir_all(root.join(INCOMING)).await {
            Err(error) if error.kind() != std::io::ErrorKind::NotFound => return Err(error.into()),
            _ => {}
        }
        tokio::fs::create_dir_all(root).await?;
        let objects = LocalFileSystem::new_with_prefix(root)?.with_fsync(true);
        let root = Arc::new(root.to_owned());
        Ok(Self { objects: Arc::new(objects), root, gate: Arc::default(), armed })
    }

    /// Begins an upload of at most `limit` bytes.
    ///
    /// # Errors
    /// If no temporary object can be made.
    pub async fn upload(&self, limit: u64) -> Result<Upload> {
        let path = Path::from_iter([INCOMING, &uuid::Uuid::new_v4().simple().to_string()]);
        let sink = self.objects.put_multipart(&path).await?;
        Ok(Upload::new(self.clone(), path, sink, limit))
    }

    /// Opens the content that a row refers to; `name` is the row's, for the error.
    ///
    /// # Errors
    /// [`Error::ContentLost`] if it is not there.
    pub async fn read(&self, digest: &Digest, name: &str) -> Result<Content> {
        let got = match self.objects.get(&published(&digest.to_hex())).await {
            Err(object_store::Error::NotFound { .. }) => {
                let (name, digest) = (name.to_owned(), digest.to_hex().to_string());
                return Err(Error::ContentLost { name, digest });
            }
            got => got?,
        };
        let size_bytes = got.meta.size;
        let chunks = match got.payload {
            GetResultPayload::File(file, _) => {
                let file = tokio::fs::File::from_std(file);
                ReaderStream::with_capacity(file, CHUNK).map_err(Error::from).boxed()
            }
            GetResultPayload::Stream(stream) => stream.map_err(Error::from).boxed(),
        };
        Ok(Content { size_bytes, chunks })
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
                None => drop(self.objects.head(&to).await?),
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

/// `blake3/ab/abcd...`: folders of a 256th each keep listings short.
fn published(digest: &str) -> Path {
    Path::from_iter([PUBLISHED, digest.get(..2).unwrap_or("xx"), digest])
}

#[cfg(test)]
mod tests;
