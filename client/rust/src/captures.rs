//! Captures.

mod supplements;
mod uploads;

use std::{path::Path, time::Duration};

use bendtwin_core::{ids::CaptureId, settings::ingest::IngestSettings};
use bendtwin_proto::v1::{
    CancelIngestRequest, DeleteCaptureRequest, ExportMasksRequest, ExportObservationRequest,
    GetCaptureReportRequest, GetCaptureRequest, IngestCaptureRequest, WatchIngestRequest,
    capture_service_client::CaptureServiceClient, get_capture_report_request::Format,
};
use bytes::Bytes;
use futures::{Stream, TryStreamExt as _};
use hyper::Method;
use serde::Deserialize;
use tokio::io::{AsyncReadExt as _, AsyncWriteExt as _};
use tokio_util::io::ReaderStream;
use tonic::Status;
use url::Url;
use uuid::Uuid;

use crate::{
    Capture, CaptureFacts, Error, ListQuery, Requirements, Update, Watch,
    client::{Channel, http::Http, problem},
    labels::{capture_list, capture_update},
    page::{self, Page},
    resources::if_any,
    watch,
};
pub use supplements::SupplementKind;
use uploads::Sender;

/// Most attempts at an upload.
const ATTEMPTS: u32 = 3;
/// Time between two attempts.
const RETRY_INTERVAL: Duration = Duration::from_secs(1);

/// Calls about captures.
#[derive(Clone, Debug)]
pub struct Captures {
    service: CaptureServiceClient<Channel>,
    http: Http,
    url: String,
}

/// The part of the HTTP response that is needed; the rest is fetched by name.
#[derive(Deserialize)]
struct Created {
    name: CaptureId,
}

/// Address that a file is sent to.
struct Destination<'d> {
    method: Method,
    url: &'d str,
    /// Idempotency key of a creation.
    key: Option<&'d str>,
}

impl Captures {
    pub(crate) fn new(service: CaptureServiceClient<Channel>, http: Http, url: String) -> Self {
        Self { service, http, url }
    }

    /// Uploads a capture archive (ZIP) over HTTP, streamed from disk, its digest checked by the
    /// server. A broken connection is retried under the same idempotency key, so there is never
    /// more than one capture.
    ///
    /// # Errors
    /// If the file cannot be read, or the server refuses it or cannot be reached.
    pub async fn upload(
        &self,
        file: &Path,
        facts: impl Into<CaptureFacts>,
    ) -> Result<Capture, Error> {
        self.upload_with(file, facts, |_| ()).await
    }

    /// [`Captures::upload`] with progress; `sent` gets the number of bytes sent so far.
    ///
    /// # Errors
    /// Those of [`Captures::upload`].
    pub async fn upload_with(
        &self,
        file: &Path,
        facts: impl Into<CaptureFacts>,
        sent: impl Fn(u64) + Clone + Send + Sync + 'static,
    ) -> Result<Capture, Error> {
        let facts = facts.into();
        let mut url = Url::parse(&format!("{}/v1/captures", self.url)).map_err(Error::malformed)?;
        url.query_pairs_mut().extend_pairs(facts.pairs()?);
        let key = Uuid::new_v4().to_string();
        let to = Destination { method: Method::POST, url: url.as_str(), key: Some(&key) };
        self.send(file, "application/zip", to, sent).await
    }

    /// Uploads a capture archive (ZIP) over tus 1.0.0. A failure of the connection or the server
    /// costs at most the last 16 MiB. After two minutes without progress, or after the end of this
    /// process, the same call resumes. `sent` gets the number of bytes on the server, which may
    /// decrease a little.
    ///
    /// The same content with the same facts is one capture, even if it is uploaded repeatedly, and
    /// is not sent again.
    ///
    /// # Errors
    /// Those of [`Captures::upload`].
    pub async fn upload_resumable(
        &self,
        file: &Path,
        facts: impl Into<CaptureFacts>,
        sent: impl Fn(u64) + Clone + Send + Sync + 'static,
    ) -> Result<Capture, Error> {
        let digest = digest_of(file).await?;
        let sender = Sender::new(&self.http, &self.url, file, &digest, &facts.into()).await?;
        let name = sender.send(&sent).await?;
        let mut attempt = 1;
        loop {
            match self.get(name).await {
                // The server may have been restarted since; the connection notices by failing.
                Err(error) if error.is_transient() && attempt < ATTEMPTS => {
                    attempt += 1;
                    tokio::time::sleep(RETRY_INTERVAL).await;
                }
                got => return got,
            }
        }
    }

    /// Streams a file to an address that answers with a capture. A broken connection is retried.
    async fn send(
        &self,
        file: &Path,
        media_type: &'static str,
        to: Destination<'_>,
        sent: impl Fn(u64) + Clone + Send + Sync + 'static,
    ) -> Result<Capture, Error> {
        let digest = digest_of(file).await?;
        let mut attempt = 1;
        loop {
            match self.send_once(file, media_type, &digest, &to, sent.clone()).await {
                Ok(name) => return self.get(name).await,
                Err(error) if error.is_transient() && attempt < ATTEMPTS => {
                    attempt += 1;
                    tokio::time::sleep(RETRY_INTERVAL).await;
                }
                Err(error) => return Err(error),
            }
        }
    }

    async fn send_once(
        &self,
        path: &Path,
        media_type: &'static str,
        digest: &str,
        to: &Destination<'_>,
        sent: impl Fn(u64) + Send + Sync + 'static,
    ) -> Result<CaptureId, Error> {
        let unreadable = |e: std::io::Error| Error::file(path, &e);
        let file = tokio::fs::File::open(path).await.map_err(unreadable)?;
        let length = file.metadata().await.map_err(unreadable)?.len();
        let mut total = 0;
        let body = ReaderStream::with_capacity(file, 256 << 10).inspect_ok(move |chunk| {
            total += chunk.len() as u64;
            sent(total);
        });
        let request = self
            .http
            .request(to.method.clone(), to.url)
            .header("content-type", media_type)
            .header("x-content-blake3", digest)
            .header("content-length", length);
        let request = match to.key {
            Some(key) => request.header("idempotency-key", key),
            None => request,
        };
        let response = request.body(body).send().await?;
        let created: Created = problem::success(response).await?.json().await?;
        Ok(created.name)
    }

    /// The capture now and after every change of its ingest, until that has ended. Waits up to a
    /// minute for a server that cannot be reached.
    pub fn watch(&self, name: CaptureId) -> Watch<Capture> {
        let service = self.service.clone();
        watch::start(move |after_revision| {
            let mut service = service.clone();
            let request = WatchIngestRequest { name: name.to_string(), after_revision };
            Box::pin(async move { Ok(service.watch_ingest(request).await?.into_inner()) })
        })
    }

    /// Waits until a capture has been read, however that ends.
    ///
    /// # Errors
    /// Those of [`Captures::watch`].
    pub async fn wait(&self, name: CaptureId) -> Result<Capture, Error> {
        self.watch(name).last().await
    }

    /// Reads a capture again, for example with other settings or by another worker.
    ///
    /// # Errors
    /// If the settings are wrong, it is being read, a fit of it is queued or running, or the server
    /// cannot be asked.
    pub async fn ingest(
        &self,
        name: CaptureId,
        settings: &IngestSettings,
        requirements: &Requirements,
    ) -> Result<Capture, Error> {
        let settings_json = serde_json::to_string(settings)
            .map_err(|e| Error::invalid(format!("the settings cannot be written as JSON: {e}")))?;
        let request_id = Uuid::new_v4().to_string();
        let request = IngestCaptureRequest {
            name: name.to_string(),
            settings_json,
            request_id,
            requirements: if_any(requirements),
        };
        self.service.clone().ingest_capture(request).await?.into_inner().try_into()
    }

    /// Asks the ingest of a capture to stop; one that has ended is returned unchanged.
    ///
    /// # Errors
    /// If the capture does not exist, or the server cannot be asked.
    pub async fn cancel_ingest(&self, name: CaptureId) -> Result<Capture, Error> {
        let request = CancelIngestRequest { name: name.to_string() };
        self.service.clone().cancel_ingest(request).await?.into_inner().try_into()
    }

    /// The report of the ingest as JSON: verdict, findings and the measurements behind them.
    ///
    /// # Errors
    /// If there is no report yet, or the server cannot be asked.
    pub async fn report(&self, name: CaptureId) -> Result<serde_json::Value, Error> {
        let report = self.fetch_report(name, Format::Json).await?;
        serde_json::from_slice(&report).map_err(Error::malformed)
    }

    /// The report as an HTML page with pictures, in one file.
    ///
    /// # Errors
    /// Those of [`Captures::report`].
    pub async fn report_page(&self, name: CaptureId) -> Result<Vec<u8>, Error> {
        self.fetch_report(name, Format::Html).await
    }

    async fn fetch_report(&self, name: CaptureId, format: Format) -> Result<Vec<u8>, Error> {
        let request = GetCaptureReportRequest { name: name.to_string(), format: format.into() };
        let mut chunks = self.service.clone().get_capture_report(request).await?.into_inner();
        let mut report = Vec::new();
        while let Some(part) = chunks.message().await? {
            report.extend_from_slice(&part.chunk);
        }
        Ok(report)
    }

    /// Writes the observation of a capture to a file: tracked points as a bundle, the input of
    /// fits.
    ///
    /// # Errors
    /// If there is no observation yet, the file cannot be written, or the server cannot be asked.
    pub async fn export_observation(&self, name: CaptureId, file: &Path) -> Result<(), Error> {
        let request = ExportObservationRequest { name: name.to_string() };
        let chunks = self.service.clone().export_observation(request).await?.into_inner();
        save(chunks.map_ok(|part| part.chunk), file).await
    }

    /// Writes the masks that the last ingest of a capture made of strokes to a file (ZIP).
    ///
    /// # Errors
    /// If there are none, the file cannot be written, or the server cannot be asked.
    pub async fn export_masks(&self, name: CaptureId, file: &Path) -> Result<(), Error> {
        let request = ExportMasksRequest { name: name.to_string() };
        let chunks = self.service.clone().export_masks(request).await?.into_inner();
        save(chunks.map_ok(|part| part.chunk), file).await
    }

    /// Returns a capture.
    ///
    /// # Errors
    /// If the capture does not exist, or the server cannot be asked.
    pub async fn get(&self, name: CaptureId) -> Result<Capture, Error> {
        let request = GetCaptureRequest { name: name.to_string() };
        self.service.clone().get_capture(request).await?.into_inner().try_into()
    }

    /// A page of captures.
    ///
    /// # Errors
    /// If the query is not allowed, or the server cannot be asked.
    pub async fn list(&self, query: ListQuery) -> Result<Page<Capture>, Error> {
        let reply = self.service.clone().list_captures(capture_list(query)).await?.into_inner();
        Page::new(reply.captures, reply.next_page_token, Capture::try_from)
    }

    /// All captures of a query, page by page.
    ///
    /// # Errors
    /// Those of [`Captures::list`].
    pub async fn all(&self, query: &ListQuery) -> Result<Vec<Capture>, Error> {
        page::all(|page| self.list(ListQuery { page, ..query.clone() })).await
    }

    /// Changes what is stated about a capture.
    ///
    /// # Errors
    /// If a change is not allowed, the capture does not exist, or the server cannot be asked.
    pub async fn update(&self, name: CaptureId, update: &Update) -> Result<Capture, Error> {
        let request = capture_update(name, update);
        self.service.clone().update_capture(request).await?.into_inner().try_into()
    }

    /// Moves a capture to the trash; twins that were fitted to it stay.
    ///
    /// # Errors
    /// If a fit of it is queued or running, or the server cannot be asked.
    pub async fn delete(&self, name: CaptureId) -> Result<(), Error> {
        self.remove(name, false).await
    }

    /// Deletes a capture for good, in the trash or not.
    ///
    /// # Errors
    /// If a fit of it is queued or running, or the server cannot be asked.
    pub async fn purge(&self, name: CaptureId) -> Result<(), Error> {
        self.remove(name, true).await
    }

    async fn remove(&self, name: CaptureId, purge: bool) -> Result<(), Error> {
        let request = DeleteCaptureRequest { name: name.to_string(), purge };
        self.service.clone().delete_capture(request).await?;
        Ok(())
    }
}

/// Writes chunks to a file.
async fn save(
    mut chunks: impl Stream<Item = Result<Bytes, Status>> + Unpin,
    file: &Path,
) -> Result<(), Error> {
    let unwritable = |e: std::io::Error| Error::file(file, &e);
    let mut out = tokio::fs::File::create(file).await.map_err(unwritable)?;
    while let Some(chunk) = chunks.try_next().await? {
        out.write_all(&chunk).await.map_err(unwritable)?;
    }
    out.flush().await.map_err(unwritable)
}

/// BLAKE3 of a file, hex.
async fn digest_of(path: &Path) -> Result<String, Error> {
    let unreadable = |e: std::io::Error| Error::file(path, &e);
    let mut file = tokio::fs::File::open(path).await.map_err(unreadable)?;
    let mut hasher = blake3::Hasher::new();
    let mut buffer = vec![0; 256 << 10];
    loop {
        match file.read(&mut buffer).await.map_err(unreadable)? {
            0 => return Ok(hasher.finalize().to_hex().to_string()),
            read => hasher.update(&buffer[..read]),
        };
    }
}
