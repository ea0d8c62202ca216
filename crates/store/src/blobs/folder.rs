//! Content in a folder: staged beside it, published by a rename, set aside in a trash.

use std::{
    io::ErrorKind,
    ops::Range,
    path::{Path as FsPath, PathBuf},
    sync::Arc,
    time::{Duration, SystemTime},
};

use futures::{StreamExt as _, TryStreamExt as _, stream::BoxStream};
use object_store::{
    GetOptions, GetRange, GetResult, GetResultPayload, ObjectStore as _, ObjectStoreExt as _,
    RenameOptions, local::LocalFileSystem, path::Path,
};
use tokio::io::{AsyncReadExt as _, AsyncSeekExt as _, SeekFrom};
use tokio_util::io::ReaderStream;

use super::{CHUNK, INCOMING, ObjectReader, PUBLISHED, files, published};
use crate::{Error, Result, folder, store::meter::Meter};

/// Age from which a file in a shared `incoming` is of a server that is gone.
const ABANDONED: Duration = Duration::from_secs(7 * 86_400);

/// A folder with content. Clones share it.
#[derive(Clone, Debug)]
pub(crate) struct Folder {
    objects: Arc<LocalFileSystem>,
    root: Arc<PathBuf>,
    /// True if other servers may have it open.
    is_shared: bool,
    pub(super) meter: Meter,
}

impl Folder {
    pub(super) fn open(root: &FsPath, is_shared: bool, meter: Meter) -> Result<Self> {
        folder::make(root)?;
        folder::close_to_others(root, folder::FOLDER);
        let objects = LocalFileSystem::new_with_prefix(root)?.with_fsync(true);
        Ok(Self { objects: Arc::new(objects), root: Arc::new(root.to_owned()), is_shared, meter })
    }

    /// Empties `incoming` of what another process left there.
    pub(super) async fn clear_incoming(&self) -> Result<()> {
        let incoming = self.root.join(INCOMING);
        if self.is_shared {
            return Ok(tokio::task::spawn_blocking(move || clear_abandoned(&incoming))
                .await
                .map_err(std::io::Error::other)??);
        }
        match tokio::fs::remove_dir_all(incoming).await {
            Err(error) if error.kind() != ErrorKind::NotFound => Err(error.into()),
            _ => Ok(()),
        }
    }

    pub(super) fn objects(&self) -> &LocalFileSystem {
        &self.objects
    }

    pub(crate) fn root(&self) -> &FsPath {
        &self.root
    }

    pub(crate) fn is_shared(&self) -> bool {
        self.is_shared
    }

    /// Writes, syncs and removes a small file.
    pub(super) async fn probe(&self) -> Result<()> {
        let folder = self.root.join(INCOMING);
        let file = folder.join(format!("probe-{}", uuid::Uuid::new_v4().simple()));
        let probed = tokio::task::spawn_blocking(move || {
            folder::make(&folder)?;
            let written = std::fs::write(&file, [0; 4096])
                .and_then(|()| std::fs::OpenOptions::new().write(true).open(&file)?.sync_all());
            std::fs::remove_file(&file).and(written)
        });
        self.meter
            .measure("write", async { Ok(probed.await.map_err(std::io::Error::other)??) })
            .await
    }

    pub(super) async fn rename(&self, from: &Path, to: &Path) -> Result<()> {
        let renamed = self.objects.rename_opts(from, to, RenameOptions::new());
        self.meter.measure("write", async { Ok(renamed.await?) }).await
    }

    pub(super) async fn delete(&self, path: &Path) -> Result<()> {
        let deleted = self.meter.measure("delete", async { Ok(self.objects.delete(path).await?) });
        match deleted.await {
            Err(Error::Objects(object_store::Error::NotFound { .. })) | Ok(()) => Ok(()),
            Err(error) => Err(error),
        }
    }

    /// Size of a file; none if it is not there.
    pub(super) async fn size(&self, path: &Path) -> Result<Option<u64>> {
        match self.objects.head(path).await {
            Err(object_store::Error::NotFound { .. }) => Ok(None),
            found => Ok(Some(found?.size)),
        }
    }

    /// Digests of all published blobs.
    pub(crate) async fn list(&self) -> Result<Vec<String>> {
        let listing = self.objects.list(Some(&Path::from(PUBLISHED)));
        let names = listing
            .try_filter_map(|meta| async move { Ok(meta.location.filename().map(str::to_owned)) });
        self.meter.measure("list", async { Ok(names.try_collect().await?) }).await
    }

    /// Opens an object, or a range of it; none if it is not there.
    pub(super) async fn read(
        &self,
        path: &Path,
        range: Option<Range<u64>>,
    ) -> Result<Option<ObjectReader>> {
        let options = GetOptions { range: range.map(GetRange::Bounded), ..GetOptions::default() };
        let got = async { Ok(self.objects.get_opts(path, options).await?) };
        match self.meter.measure("read", got).await {
            Err(Error::Objects(object_store::Error::NotFound { .. })) => Ok(None),
            got => {
                let got = got?;
                Ok(Some(ObjectReader { size_bytes: got.meta.size, chunks: chunks(got).await? }))
            }
        }
    }

    /// Path of a published blob's file.
    pub(crate) fn file(&self, digest: &str) -> PathBuf {
        files::published(&self.root, digest)
    }

    /// Takes content back from the trash. Returns false if it is not there.
    pub(super) async fn take_back(&self, digest: &str) -> Result<bool> {
        match self.rename(&super::trashed(digest), &published(digest)).await {
            Err(Error::Objects(object_store::Error::NotFound { .. })) => Ok(false),
            Err(error) => Err(error),
            Ok(()) => {
                tracing::warn!(digest, "content is taken back from the trash");
                Ok(true)
            }
        }
    }
}

/// The bytes of the range that was asked for.
async fn chunks(got: GetResult) -> Result<BoxStream<'static, Result<bytes::Bytes>>> {
    let Range { start, end } = got.range;
    Ok(match got.payload {
        GetResultPayload::File(file, _) => {
            let mut file = tokio::fs::File::from_std(file);
            if start > 0 {
                file.seek(SeekFrom::Start(start)).await?;
            }
            let part = file.take(end.saturating_sub(start));
            ReaderStream::with_capacity(part, CHUNK).map_err(Error::from).boxed()
        }
        GetResultPayload::Stream(stream) => stream.map_err(Error::from).boxed(),
    })
}

fn clear_abandoned(incoming: &FsPath) -> std::io::Result<()> {
    for (file, _) in files::list(incoming)? {
        let written = std::fs::metadata(&file).and_then(|found| found.modified());
        let age = written.ok().and_then(|since| SystemTime::now().duration_since(since).ok());
        if age.is_some_and(|age| age > ABANDONED) {
            std::fs::remove_file(&file)?;
        }
    }
    Ok(())
}
