//! Recordings.

use std::{path::Path, time::Duration};

use bendtwin_core::ids::CaptureId;
use bendtwin_proto::v1::{
    DeleteCaptureRequest, GetCaptureRequest, ListCapturesRequest,
    capture_service_client::CaptureServiceClient,
};
use futures::TryStreamExt as _;
use serde::Deserialize;
use tokio::io::AsyncReadExt as _;
use tokio_util::io::ReaderStream;
use tonic::transport::Channel;
use uuid::Uuid;

use crate::{
    Capture, Error,
    page::{self, Page, PageRequest},
    problem,
    uploads::Sender,
};

/// How often an upload is tried.
const ATTEMPTS: u32 = 3;
/// Between two attempts.
const PAUSE: Duration = Duration::from_secs(1);

/// Calls about captures.
#[derive(Clone, Debug)]
pub struct Captures {
    service: CaptureServiceClient<Channel>,
    http: reqwest::Client,
    url: String,
}

/// The part of the HTTP reply that is needed: the rest is asked for by name.
#[derive(Deserialize)]
struct Created {
    name: CaptureId,
}

impl Captures {
    pub(crate) fn new(
        service: CaptureServiceClient<Channel>,
        http: reqwest::Client,
        url: String,
    ) -> Self {
        Self { service, http, url }
    }

    /// Uploads a capture archive (ZIP) over HTTP, streamed from disk, its digest checked by the
    /// server. A connection that breaks is tried again under the same idempotency key, so there
    /// is one capture whatever happens.
    ///
    /// # Errors
    /// If the file cannot be read, or the server refuses it or cannot be reached.
    pub async fn upload(&self, file: &Path, display_name: &str) -> Result<Capture, Error> {
        self.upload_with(file, display_name, |_| ()).await
    }

    /// As [`Captures::upload`]; `sent` is told the bytes sent so far.
    ///
    /// # Errors
    /// As [`Captures::upload`].
    pub async fn upload_with(
        &self,
        file: &Path,
        display_name: &str,
        sent: impl Fn(u64) + Clone + Send + Sync + 'static,
    ) -> Result<Capture, Error> {
        let digest = digest_of(file).await?;
        let key = Uuid::new_v4().to_string();
        let mut attempt = 1;
        loop {
            match self.send(file, display_name, &digest, &key, sent.clone()).await {
                Ok(name) => return self.get(name).await,
                Err(error) if error.is_transient() && attempt < ATTEMPTS => {
                    attempt += 1;
                    tokio::time::sleep(PAUSE).await;
                }
                Err(error) => return Err(error),
            }
        }
    }

    /// Uploads a capture archive (ZIP) over tus 1.0.0: a connection or a server that breaks down costs at most the
    /// last 16 MiB, and after two minutes without progress, or after the end of this process, the same call
    /// goes on where it stopped. `sent` is told how many bytes the server has, which may fall back a little.
    ///
    /// The same content under the same name is one capture, however often it is uploaded, and is not sent again.
    ///
    /// # Errors
    /// As [`Captures::upload`].
    pub async fn upload_resumable(
        &self,
        file: &Path,
        display_name: &str,
        sent: impl Fn(u64) + Clone + Send + Sync + 'static,
    ) -> Result<Capture, Error> {
        let digest = digest_of(file).await?;
        let sender = Sender::new(&self.http, &self.url, file, &digest, display_name).await?;
        let name = sender.send(&sent).await?;
        let mut attempt = 1;
        loop {
            match self.get(name).await {
                // The server may have been restarted since; the connection notices by failing.
                Err(error) if error.is_transient() && attempt < ATTEMPTS => {
                    attempt += 1;
                    tokio::time::sleep(PAUSE).await;
                }
                got => return got,
            }
        }
    }

    async fn send(
        &self,
        path: &Path,
        display_name: &str,
        digest: &str,
        key: &str,
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
        let response = self
            .http
            .post(format!("{}/v1/captures", self.url))
            .query(&[("display_name", display_name)])
            .header("content-type", "application/zip")
            .header("x-content-blake3", digest)
            .header("content-length", length)
            .header("idempotency-key", key)
            .body(reqwest::Body::wrap_stream(body))
            .send()
            .await
            .map_err(|e| Error::unreachable(&self.url, e))?;
        let created: Created =
            problem::success(response).await?.json().await.map_err(Error::malformed)?;
        Ok(created.name)
    }

    /// One capture.
    ///
    /// # Errors
    /// If there is none of that name, or the server cannot be asked.
    pub async fn get(&self, name: CaptureId) -> Result<Capture, Error> {
        let request = GetCaptureRequest { name: name.to_string() };
        self.service.clone().get_capture(request).await?.into_inner().try_into()
    }

    /// A page of the captures.
    ///
    /// # Errors
    /// If the server cannot be asked.
    pub async fn list(&self, page: PageRequest) -> Result<Page<Capture>, Error> {
        let request = ListCapturesRequest { page_size: page.size, page_token: page.token };
        let reply = self.service.clone().list_captures(request).await?.into_inner();
        Page::new(reply.captures, reply.next_page_token, Capture::try_from)
    }

    /// All captures.
    ///
    /// # Errors
    /// If the server cannot be asked.
    pub async fn all(&self) -> Result<Vec<Capture>, Error> {
        page::all(|page| self.list(page)).await
    }

    /// Deletes a capture; twins that were fitted to it stay.
    ///
    /// # Errors
    /// If a fit of it is queued or running, or the server cannot be asked.
    pub async fn delete(&self, name: CaptureId) -> Result<(), Error> {
        let request = DeleteCaptureRequest { name: name.to_string() };
        self.service.clone().delete_capture(request).await?;
        Ok(())
    }
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
