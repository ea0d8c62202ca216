//! Files of resumable uploads: `partial/{id}` beside the blobs, so that renaming makes complete
//! content a blob. Unlike `incoming` they outlive the process.

use std::{io::ErrorKind, path::PathBuf};

use bendtwin_core::ids::UploadId;
use object_store::path::Path;
use tokio::fs::{self, File, OpenOptions};
use uuid::Uuid;

use super::{Folder, PARTIAL};
use crate::Result;

/// The path of its file, or of all its objects in a bucket.
pub(crate) fn object(id: UploadId) -> Path {
    Path::from_iter([PARTIAL, &id.uuid().to_string()])
}

impl Folder {
    /// Path of the file of an upload.
    pub(crate) fn partial(&self, id: UploadId) -> PathBuf {
        self.root().join(PARTIAL).join(id.uuid().to_string())
    }

    /// Opens the file of an upload for writing. If it is created, its name is synced.
    pub(crate) async fn open_partial(&self, id: UploadId, create: bool) -> Result<File> {
        let folder = self.root().join(PARTIAL);
        if create {
            fs::create_dir_all(&folder).await?;
        }
        let mut options = OpenOptions::new();
        let file =
            options.write(true).create(create).truncate(false).open(self.partial(id)).await?;
        if create {
            for folder in [folder.as_path(), self.root()] {
                File::open(folder).await?.sync_all().await?;
            }
        }
        Ok(file)
    }

    /// Removes the file of an upload, if there is one.
    pub(crate) async fn remove_partial(&self, id: UploadId) -> Result<()> {
        match fs::remove_file(self.partial(id)).await {
            Err(error) if error.kind() != ErrorKind::NotFound => Err(error.into()),
            _ => Ok(()),
        }
    }

    /// Uploads that have a file.
    pub(crate) async fn partials(&self) -> Result<Vec<UploadId>> {
        let mut entries = match fs::read_dir(self.root().join(PARTIAL)).await {
            Err(error) if error.kind() == ErrorKind::NotFound => return Ok(Vec::new()),
            entries => entries?,
        };
        let mut ids = Vec::new();
        while let Some(entry) = entries.next_entry().await? {
            if let Ok(uuid) = Uuid::try_parse(&entry.file_name().to_string_lossy()) {
                ids.push(uuid.into());
            }
        }
        Ok(ids)
    }
}
