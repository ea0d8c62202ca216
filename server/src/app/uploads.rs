//! Resumable uploads, free of the protocol that carries them: begun, continued at an offset,
//! queried, terminated. The last byte makes the capture, by the same rules as an upload in one
//! piece.

mod checksum;
mod metadata;

use std::time::Duration;

use bendtwin_core::{Category, Problem as _};
use bendtwin_store::{
    Error as StoreError, NewResumableUpload, Page, PageRequest, ResumableUpload, UploadBounds,
    UploadState, UploadWriter,
};
use futures::StreamExt as _;
use tracing::Instrument as _;

use super::{App, Body, Error, Result, rights};
use crate::{access::Scope, audit, context::Context};

pub(crate) use checksum::{ALGORITHMS, Checksum};
use metadata::Metadata;

/// Display name of the capture that an upload with this metadata would become.
pub(crate) fn capture_name(metadata: &str) -> Result<String> {
    super::labels::display_name(Metadata::parse(metadata)?.capture.display_name)
}

/// Scope of all calls about uploads.
const SCOPE: Scope = Scope::CapturesWrite;
/// Time for which a request waits for the request before it to release the upload.
const CLAIM_TIMEOUT: Duration = Duration::from_secs(10);
/// Number of bytes after which received content is made durable.
const COMMIT_BYTES: u64 = 32 << 20;
/// Received bytes below which an upload is soon given up.
const FEW_BYTES: u64 = 1 << 20;

/// A requested upload.
pub(crate) struct NewUpload {
    /// Size of the whole; none if the client does not know it yet.
    pub(crate) length_bytes: Option<u64>,
    /// Metadata as the client wrote it: `key base64, ...`.
    pub(crate) metadata: String,
    /// The idempotency key, if it was given outside the metadata.
    pub(crate) request_id: String,
    /// True if the request brings content.
    pub(crate) has_content: bool,
}

/// Bytes to be appended.
pub(crate) struct Append {
    /// Offset of the first byte.
    pub(crate) offset: u64,
    /// Number of bytes, if known beforehand.
    pub(crate) size_bytes: Option<u64>,
    /// Size of the whole, if the client had not known it before.
    pub(crate) length_bytes: Option<u64>,
    pub(crate) checksum: Option<Checksum>,
    pub(crate) body: Body,
}

impl App {
    /// Begins an upload, or finds the one that was begun under the same request id.
    pub(crate) async fn create_upload(&self, new: NewUpload) -> Result<ResumableUpload> {
        let done: Result<ResumableUpload> = async {
            let metadata = Metadata::parse(&new.metadata)?;
            let request_id = super::request_id(metadata.one_request_id(new.request_id)?)?;
            let expected_digest = super::digest(&metadata.capture.digest)?;
            let facts = self.capture_facts(metadata.capture)?;
            self.check_length(new.length_bytes)?;
            let new = NewResumableUpload {
                display_name: facts.display_name,
                request_id,
                expected_digest,
                metadata: new.metadata,
                length_bytes: new.length_bytes,
                has_content: new.has_content,
                keep: self.options.upload_start(),
                remember: self.options.upload_expiry(),
                creator: Context::current().caller.creator(),
            };
            self.require_room(new.length_bytes.unwrap_or(0))?;
            Ok(self.store.uploads().create(new, self.upload_bounds()).await?)
        }
        .await;
        audit::made("CreateUpload", &done, |upload| upload.id.to_string());
        done
    }

    pub(crate) async fn uploads(&self, page: &PageRequest) -> Result<Page<ResumableUpload>> {
        Ok(self.store.uploads().list(page, rights::confined(SCOPE).as_deref()).await?)
    }

    /// An upload in its current state; a request that sends to it is not interrupted.
    pub(crate) async fn upload(&self, name: &str) -> Result<ResumableUpload> {
        Ok(self.store.uploads().get(self.reach(SCOPE, name).await?).await?)
    }

    /// Prepares to resume: a request that still sends to the upload is asked to stop, because its
    /// connection may be dead. Makes the capture if only that is missing.
    pub(crate) async fn resume_upload(&self, name: &str) -> Result<ResumableUpload> {
        let (app, id) = (self.clone(), self.reach(SCOPE, name).await?);
        let quotas = Context::current().caller.quotas;
        run_detached(async move {
            let mut writer = app.store.uploads().claim(id, CLAIM_TIMEOUT).await?;
            writer.bind(quotas);
            app.finish_if_whole(writer).await
        })
        .await
    }

    /// Appends bytes. Bytes that have arrived are kept even if the rest does not come, unless the
    /// request has a checksum.
    pub(crate) async fn append_upload(
        &self,
        name: &str,
        append: Append,
    ) -> Result<ResumableUpload> {
        let (app, id) = (self.clone(), self.reach(SCOPE, name).await?);
        let quotas = Context::current().caller.quotas;
        run_detached(async move {
            let mut writer = app.store.uploads().claim(id, CLAIM_TIMEOUT).await?;
            writer.bind(quotas);
            app.append(&mut writer, append).await?;
            app.finish_if_whole(writer).await
        })
        .await
    }

    /// Terminates an upload and frees its storage; a capture that it made stays.
    pub(crate) async fn terminate_upload(&self, name: &str) -> Result<()> {
        let done: Result<()> = async {
            let (app, id) = (self.clone(), self.reach(SCOPE, name).await?);
            run_detached(async move {
                let writer = app.store.uploads().claim(id, CLAIM_TIMEOUT).await?;
                let keep = app.keep(writer.upload().offset_bytes, None);
                writer.end("it was terminated: begin a new one", keep).await?;
                tracing::info!(upload = %id, "upload terminated");
                Ok(())
            })
            .await
        }
        .await;
        audit::changed("TerminateUpload", name, &done);
        done
    }

    /// Ends expired uploads, and finishes those that a crash left complete.
    pub(crate) async fn sweep_uploads(&self) -> Result<()> {
        for id in self.store.uploads().whole().await? {
            // The request with the last byte may be finishing it.
            match self.store.uploads().claim(id, Duration::ZERO).await {
                Ok(writer) => drop(self.finish_if_whole(writer).await),
                Err(error) => tracing::debug!(upload = %id, %error, "not finished now"),
            }
        }
        let given_up = self.store.uploads().sweep(self.options.upload_expiry()).await?;
        if given_up > 0 {
            tracing::info!(given_up, "uploads expired");
        }
        Ok(())
    }

    async fn append(&self, writer: &mut UploadWriter, append: Append) -> Result<()> {
        let offset = writer.upload().offset_bytes;
        if append.offset != offset {
            return Err(Error::UploadOffset { given: append.offset, offset });
        }
        if let Some(length) = append.length_bytes {
            self.check_length(Some(length))?;
            writer.set_length(length, self.upload_bounds()).await?;
        }
        let room = writer.room(self.options.limits.capture_bytes, self.upload_bounds()).await?;
        if append.size_bytes.is_some_and(|n| n > room) {
            return Err(Error::UploadTooLong { limit: offset + room });
        }
        self.require_room(append.size_bytes.unwrap_or(0))?;
        writer.reserve(append.size_bytes.unwrap_or(1)).await?;
        let received = self.receive_into(writer, append, room).await;
        let arrived = writer.pending();
        // A checksum vouches for all or nothing, and after an error of the disk nothing is sure.
        let kept = match &received {
            Ok(()) | Err(Interrupted { keep_it: true, .. }) => {
                self.commit(writer).await.map(|()| true)
            }
            Err(_) => Ok(false),
        };
        if !matches!(kept, Ok(true))
            && let Err(error) = writer.discard().await
        {
            tracing::warn!(%error, "the next request has to cut off what this one left");
        }
        if let Err(error) = writer.give_back().await {
            tracing::debug!(%error, "the next request gives back what this one set aside");
        }
        let kept = kept?;
        self.metrics.upload_bytes(if kept { arrived } else { 0 });
        received.map_err(|interrupted| interrupted.error)
    }

    /// Writes a body until its end or an interruption.
    async fn receive_into(
        &self,
        writer: &mut UploadWriter,
        append: Append,
        room: u64,
    ) -> Result<(), Interrupted> {
        let buffers = self.memory.resumable_upload(self.store.uploads().buffers()).await;
        let _buffers = buffers.map_err(|error| Interrupted { error, keep_it: true })?;
        let (mut body, mut checksum) = (append.body.chunks, append.checksum);
        let idle = self.options.limits.upload_idle();
        let broken = |error: Error, checksum: &Option<Checksum>| Interrupted {
            error,
            keep_it: checksum.is_none(),
        };
        let lost = |error: StoreError| Interrupted { error: error.into(), keep_it: false };
        let wanted = writer.wanted();
        tokio::pin!(wanted);
        let mut left = room;
        loop {
            let next = tokio::select! {
                // Another request first: it would else wait behind a fast sender.
                biased;
                () = &mut wanted => return Err(broken(Error::UploadTakenOver, &checksum)),
                () = self.stopping.cancelled() => return Err(broken(Error::Stopping, &checksum)),
                next = tokio::time::timeout(idle, body.next()) => next,
            };
            let chunk = match next {
                Err(_) => return Err(broken(Error::UploadIdle(idle), &checksum)),
                Ok(None) => break,
                Ok(Some(Err(error))) => return Err(broken(error, &checksum)),
                Ok(Some(Ok(chunk))) => chunk,
            };
            let Some(rest) = left.checked_sub(chunk.len() as u64) else {
                // A sender that counts wrongly is not to be trusted with the bytes before either.
                let error = Error::UploadTooLong { limit: append.offset + room };
                return Err(Interrupted { error, keep_it: false });
            };
            left = rest;
            if let Some(checksum) = &mut checksum {
                checksum.update(&chunk);
            }
            // What came before a chunk without room is sound: the owner may delete something and
            // continue.
            writer.write(&chunk).await.map_err(|error| match error {
                error @ StoreError::QuotaBytes { .. } => broken(error.into(), &checksum),
                error => lost(error),
            })?;
            if checksum.is_none() && writer.pending() >= COMMIT_BYTES {
                let pending = writer.pending();
                self.commit(writer).await.map_err(lost)?;
                self.metrics.upload_bytes(pending);
                let has_room = self.has_room(writer).await;
                left = left.min(has_room.map_err(|error| broken(error, &checksum))?);
            }
        }
        match checksum.map(Checksum::verify).transpose() {
            Ok(_) => Ok(()),
            Err(error) => Err(Interrupted { error, keep_it: false }),
        }
    }

    /// Free space on the disk and among all uploads for the missing bytes of an upload.
    async fn has_room(&self, writer: &UploadWriter) -> Result<u64> {
        self.require_room(0)?;
        let limit = self.options.limits.capture_bytes;
        Ok(writer.room(limit, self.upload_bounds()).await?)
    }

    async fn commit(&self, writer: &mut UploadWriter) -> bendtwin_store::Result<()> {
        let upload = writer.upload();
        let bytes = upload.offset_bytes + writer.pending();
        let keep = self.keep(bytes, upload.length_bytes);
        writer.commit(keep).await.inspect_err(|error| self.write_failed(error))
    }

    /// Time for which an upload with `bytes` received is kept without further ones. To send a few
    /// bytes again costs little, and uploads of only a few bytes cost their sender little.
    fn keep(&self, bytes: u64, length_bytes: Option<u64>) -> Duration {
        if bytes < FEW_BYTES && length_bytes != Some(bytes) {
            self.options.upload_start()
        } else {
            self.options.upload_expiry()
        }
    }

    /// Makes the capture of a complete upload, and returns the upload's new state.
    async fn finish_if_whole(&self, mut writer: UploadWriter) -> Result<ResumableUpload> {
        let upload = writer.upload().clone();
        if upload.state != UploadState::Receiving || !upload.is_whole() {
            return Ok(upload);
        }
        match self.finish(&mut writer, &upload).await {
            Ok(()) => Ok(self.store.uploads().get(upload.id).await?),
            // Trying again will not help: the client is to learn it once more if it missed it now.
            Err(error)
                if matches!(
                    error.category(),
                    Category::InvalidArgument | Category::AlreadyExists
                ) =>
            {
                let why = format!("it was refused: {error}");
                writer.end(&why, self.options.upload_expiry()).await?;
                Err(error)
            }
            Err(error) => Err(error),
        }
    }

    async fn finish(&self, writer: &mut UploadWriter, upload: &ResumableUpload) -> Result<()> {
        let facts = self.capture_facts(Metadata::parse(&upload.metadata)?.capture)?;
        let content = writer.stage().await?;
        let (request_id, creator) = (upload.request_id.clone(), writer.creator());
        self.store_capture(facts, request_id, content, creator).await?;
        Ok(())
    }

    fn check_length(&self, length_bytes: Option<u64>) -> Result<()> {
        let limit = self.options.limits.capture_bytes;
        match length_bytes {
            Some(0) => Err(Error::invalid("upload-length", "is 0: send a capture archive")),
            Some(length) if length > limit => Err(Error::UploadTooLong { limit }),
            _ => Ok(()),
        }
    }

    fn upload_bounds(&self) -> UploadBounds {
        let limits = &self.options.limits;
        UploadBounds { count: limits.uploads, bytes: limits.uploads_bytes }
    }
}

/// Reason for which a body was not read to its end.
struct Interrupted {
    error: Error,
    /// True if the bytes that arrived are sound.
    keep_it: bool,
}

/// Runs the work to its end even if the client goes away: bytes that have arrived by then are kept.
async fn run_detached<T: Send + 'static>(
    work: impl Future<Output = Result<T>> + Send + 'static,
) -> Result<T> {
    let work = Context::current().scope(work);
    match tokio::spawn(work.in_current_span()).await {
        Ok(done) => done,
        Err(panic) => Err(Error::Internal(format!("a resumable upload: {panic}"))),
    }
}
