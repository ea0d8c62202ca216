//! Content by digest. An upload streams to a temporary file while it is hashed; publishing puts it
//! at the path derived from its digest, so equal content shares one object.
//!
//! Published content is in a folder, where publishing is a rename, or in a bucket ([`Place`]).
//! Temporary files are always local.
//!
//! | folder | content |
//! |---|---|
//! | `blake3` | what rows refer to, by digest |
//! | `incoming` | uploads under way; emptied at start |
//! | `partial` | uploads that can be resumed |
//! | `trash` | what no row referred to, for a day; not in a bucket |
//! | `found` | what a repair found no row for; nothing removes it |

pub(crate) mod arrivals;
mod bucket;
mod content;
pub(crate) mod files;
mod folder;
pub(crate) mod garbage;
mod partial;
mod place;
pub(crate) mod references;
mod staged;
mod transfer;
mod trash;
mod upload;
mod url;

use std::{path::Path as FsPath, sync::Arc};

use object_store::{ObjectStoreExt as _, path::Path};
use tokio::sync::{RwLock, RwLockReadGuard, RwLockWriteGuard};

use crate::{
    Result,
    failpoint::{Armed, Failpoint},
    folder::disk::Reserve,
    store::meter::{Meter, Part},
};

pub(crate) use bucket::{Bucket, Multipart, PART};
pub use content::Content;
pub(crate) use folder::Folder;
pub(crate) use partial::object as partial_objects;
use place::ObjectReader;
pub(crate) use place::{Place, own};
pub(crate) use staged::At;
pub use staged::Staged;
pub(crate) use transfer::Fetched;
use upload::TemporaryFile;
pub use upload::Upload;
pub(crate) use url::Location;
pub use url::ObjectsUrl;

const INCOMING: &str = "incoming";
const PARTIAL: &str = "partial";
const PUBLISHED: &str = "blake3";
const TRASH: &str = "trash";
/// Bytes per chunk of a download. Content of no more is checked before it is opened.
const CHUNK: usize = 1 << 20;

/// The blobs of a store. Clones share it.
#[derive(Clone, Debug)]
pub struct Blobs {
    place: Place,
    /// The folder of temporary files: the place itself, if that is a folder.
    staging: Folder,
    /// Lock shared by callers that publish and then refer, and exclusive for those that delete.
    gate: Arc<RwLock<()>>,
    armed: Arc<Armed>,
    reserve: Arc<Reserve>,
}

impl Blobs {
    /// The blobs in a place, whose temporary files in `data_dir` are removed if it has them there.
    pub(crate) async fn open(
        place: Place,
        data_dir: &FsPath,
        armed: Arc<Armed>,
        reserve: Arc<Reserve>,
    ) -> Result<Self> {
        let staging = match &place {
            Place::Folder(folder) => folder.clone(),
            // Files wait here until they are sent to the bucket, which alone is measured.
            Place::Bucket(_) => Folder::open(&own(data_dir), false, Meter::idle(Part::Content))?,
        };
        staging.clear_incoming().await?;
        Ok(Self { place, staging, gate: Arc::default(), armed, reserve })
    }

    /// The place of published content.
    pub(crate) fn place(&self) -> &Place {
        &self.place
    }

    /// Begins an upload of at most `limit` bytes.
    ///
    /// # Errors
    /// [`crate::Error::DiskFull`]; if no temporary file can be made.
    pub async fn upload(&self, limit: u64) -> Result<Upload> {
        let path = Path::from_iter([INCOMING, &uuid::Uuid::new_v4().simple().to_string()]);
        let sink = self.staging.objects().put_multipart(&path).await?;
        Ok(Upload::new(self.clone(), Some(TemporaryFile { path, sink }), limit))
    }

    /// Begins an upload of at most `limit` bytes that is only compared with what is stored.
    pub(crate) fn comparison(&self, limit: u64) -> Upload {
        Upload::new(self.clone(), None, limit)
    }

    /// Size of a published blob; none if it is not there.
    pub(crate) async fn size(&self, digest: &str) -> Result<Option<u64>> {
        self.place.size(digest).await
    }

    /// Refuses new content of some size on a full disk. Little content gets through: it may be the
    /// result of a job.
    fn admit(&self) -> Result<()> {
        self.reserve.admit()
    }

    /// Proves that content can be stored.
    pub(crate) async fn probe(&self) -> Result<()> {
        self.staging.probe().await?;
        match &self.place {
            Place::Folder(_) => Ok(()),
            Place::Bucket(bucket) => bucket.probe().await,
        }
    }

    /// Puts staged content in its place. The guard is held until the row that refers to it is
    /// committed. One guard for all contents that one transaction refers to: a second one would wait
    /// for a deletion that waits for the first.
    pub(crate) async fn publish(&self, staged: Vec<Staged>) -> Result<RwLockReadGuard<'_, ()>> {
        self.armed.pass(Failpoint::ContentStaged)?;
        let guard = self.gate.read().await;
        for content in staged {
            content.publish().await?;
        }
        self.armed.pass(Failpoint::ContentPublished)?;
        Ok(guard)
    }

    pub(crate) async fn close_gate(&self) -> RwLockWriteGuard<'_, ()> {
        self.gate.write().await
    }

    pub(crate) async fn delete(&self, digest: &str) -> Result<()> {
        self.place.delete(&published(digest)).await
    }
}

/// `trash/abcd...`.
fn trashed(digest: &str) -> Path {
    Path::from_iter([TRASH, digest])
}

/// `blake3/ab/abcd...`: folders of a 256th each keep listings short.
pub(crate) fn published(digest: &str) -> Path {
    Path::from_iter([PUBLISHED, digest.get(..2).unwrap_or("xx"), digest])
}

#[cfg(test)]
mod tests;
