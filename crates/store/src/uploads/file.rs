//! The bytes of an upload in a file, to which they are appended.

use std::{io::ErrorKind, path::PathBuf};

use bytes::{Bytes, BytesMut};
use tokio::{
    fs::File,
    io::{AsyncSeekExt as _, AsyncWriteExt as _, SeekFrom},
};

use super::ResumableUpload;
use crate::{Digest, Error, Result, Store, blobs::Folder};

/// Bytes buffered before they are written to the file.
pub(super) const BUFFER: usize = 1 << 20;

/// The file that an upload is written to.
#[derive(Debug)]
pub(super) struct FileSink {
    folder: Folder,
    /// Opened by the first write, at the end of the acknowledged bytes.
    file: Option<File>,
    buffer: BytesMut,
}

impl FileSink {
    pub(super) fn new(folder: Folder) -> Self {
        Self { folder, file: None, buffer: BytesMut::new() }
    }

    pub(super) async fn write(
        &mut self,
        store: &Store,
        upload: &ResumableUpload,
        chunk: &Bytes,
    ) -> Result<()> {
        self.buffer.extend_from_slice(chunk);
        if self.buffer.len() >= BUFFER { self.flush(store, upload).await } else { Ok(()) }
    }

    /// Makes the written bytes durable.
    pub(super) async fn sync(&mut self, store: &Store, upload: &ResumableUpload) -> Result<()> {
        self.flush(store, upload).await?;
        if let Some(file) = &mut self.file {
            file.flush().await?;
            file.sync_data().await?;
        }
        Ok(())
    }

    pub(super) async fn discard(&mut self, upload: &ResumableUpload) -> Result<()> {
        self.buffer.clear();
        let Some(mut file) = self.file.take() else { return Ok(()) };
        // What the file collected itself may still be on its way: let it arrive, then cut it off.
        file.flush().await.ok();
        file.set_len(upload.offset_bytes).await?;
        Ok(())
    }

    /// Closes the file. Returns its path, if it exists.
    pub(super) async fn close(&mut self, upload: &ResumableUpload) -> Result<Option<PathBuf>> {
        self.file = None;
        let path = self.folder.partial(upload.id);
        Ok(tokio::fs::try_exists(&path).await?.then_some(path))
    }

    async fn flush(&mut self, store: &Store, upload: &ResumableUpload) -> Result<()> {
        store.admit()?;
        if self.file.is_none() {
            self.file = Some(self.open(upload).await?);
        }
        if let Some(file) = &mut self.file {
            file.write_all(&self.buffer).await?;
            self.buffer.clear();
        }
        Ok(())
    }

    /// The file, cut off after the acknowledged bytes and positioned there.
    async fn open(&self, upload: &ResumableUpload) -> Result<File> {
        let offset = upload.offset_bytes;
        let opened = self.folder.open_partial(upload.id, offset == 0).await;
        let mut file = match opened {
            Err(Error::Io(error)) if error.kind() == ErrorKind::NotFound => {
                return Err(upload.lost());
            }
            opened => opened?,
        };
        let length = file.metadata().await?.len();
        if length < offset {
            return Err(upload.lost());
        }
        if length > offset {
            file.set_len(offset).await?;
        }
        file.seek(SeekFrom::Start(offset)).await?;
        Ok(file)
    }
}

/// Digest and size of a file, computed in a separate thread.
pub(super) async fn hash(path: PathBuf) -> Result<(Digest, u64)> {
    let hashing = tokio::task::spawn_blocking(move || {
        let mut hasher = blake3::Hasher::new();
        hasher.update_reader(std::fs::File::open(path)?)?;
        Ok::<_, std::io::Error>((hasher.finalize(), hasher.count()))
    });
    Ok(hashing.await.map_err(std::io::Error::other)??)
}
