//! The place of content: a folder or a bucket, with what the store asks of either.

use std::{ops::Range, path::Path as FsPath, sync::Arc};

use bytes::Bytes;
use futures::stream::BoxStream;
use object_store::path::Path;

use super::{Bucket, Folder, Location, ObjectsUrl, files, published};
use crate::{Result, store::meter::Meter};

/// An object that is being read.
pub(super) struct ObjectReader {
    /// Size of all of it [bytes].
    pub(super) size_bytes: u64,
    /// The bytes asked for, in chunks of up to 1 MiB.
    pub(super) chunks: BoxStream<'static, Result<Bytes>>,
}

/// The place of content. Clones share it.
#[derive(Clone, Debug)]
pub(crate) enum Place {
    Folder(Folder),
    Bucket(Arc<Bucket>),
}

impl Place {
    /// The place that a URL names; without one the folder `blobs` of the data folder, which other
    /// servers may have open if `is_shared`; its calls are measured.
    ///
    /// # Errors
    /// [`crate::Error::InvalidObjectsUrl`], [`crate::Error::ObjectsRefused`]; file errors.
    pub(crate) fn open(
        url: Option<&ObjectsUrl>,
        data_dir: &FsPath,
        is_shared: bool,
        meter: Meter,
    ) -> Result<Self> {
        match url.map(ObjectsUrl::location).transpose()? {
            None => Ok(Self::Folder(Folder::open(&own(data_dir), is_shared, meter)?)),
            Some(Location::Folder(root)) => Ok(Self::Folder(Folder::open(&root, true, meter)?)),
            Some(Location::Bucket(name, prefix)) => {
                Ok(Self::Bucket(Arc::new(Bucket::open(&name, prefix, meter)?)))
            }
        }
    }

    /// True if other servers may use it at the same time.
    pub(crate) fn is_shared(&self) -> bool {
        match self {
            Self::Folder(folder) => folder.is_shared(),
            Self::Bucket(_) => true,
        }
    }

    /// Name in messages.
    pub(crate) fn name(&self) -> String {
        match self {
            Self::Folder(folder) => folder.root().display().to_string(),
            Self::Bucket(bucket) => bucket.name().to_owned(),
        }
    }

    /// The identity of the database that its content belongs to.
    pub(crate) async fn identity(&self) -> Result<Option<String>> {
        match self {
            Self::Folder(folder) => files::identity(folder.root()),
            Self::Bucket(bucket) => bucket.identity().await,
        }
    }

    pub(crate) async fn set_identity(&self, identity: &str) -> Result<()> {
        match self {
            Self::Folder(folder) => files::set_identity(folder.root(), identity),
            Self::Bucket(bucket) => bucket.set_identity(identity).await,
        }
    }

    /// True if it has any published blob.
    pub(crate) async fn any(&self) -> Result<bool> {
        match self {
            Self::Folder(folder) => Ok(files::any(folder.root())?),
            Self::Bucket(bucket) => bucket.any().await,
        }
    }

    /// True if it has this blob.
    pub(crate) async fn has(&self, digest: &str) -> Result<bool> {
        Ok(self.size(digest).await?.is_some())
    }

    /// Size of a blob; none if it is not there.
    pub(crate) async fn size(&self, digest: &str) -> Result<Option<u64>> {
        match self {
            Self::Folder(folder) => folder.size(&published(digest)).await,
            Self::Bucket(bucket) => bucket.size(&published(digest)).await,
        }
    }

    /// Opens an object, or a range of it; none if it is not there.
    pub(super) async fn read(
        &self,
        path: &Path,
        range: Option<Range<u64>>,
    ) -> Result<Option<ObjectReader>> {
        match self {
            Self::Folder(folder) => folder.read(path, range).await,
            Self::Bucket(bucket) => bucket.read(path, range).await,
        }
    }

    pub(super) async fn delete(&self, path: &Path) -> Result<()> {
        match self {
            Self::Folder(folder) => folder.delete(path).await,
            Self::Bucket(bucket) => bucket.delete(path).await,
        }
    }

    /// Takes content back from the trash, where there is one. Returns false if it is not there.
    pub(super) async fn take_back(&self, digest: &str) -> Result<bool> {
        match self {
            Self::Folder(folder) => folder.take_back(digest).await,
            Self::Bucket(_) => Ok(false),
        }
    }
}

/// The folder of content in a data folder.
pub(crate) fn own(data_dir: &FsPath) -> std::path::PathBuf {
    data_dir.join("blobs")
}
