//! Uploads over tus 1.0.0 that survive broken connections, restarts of the server and restarts of
//! the uploading process.
//!
//! There is no state file: the upload is found again by its request id, which is derived from the
//! content's digest and the facts. So the same file with the same facts is resumed from any process
//! or folder, and a file that the server already has is not sent again.

use std::{
    io::SeekFrom,
    path::Path,
    sync::{Arc, Mutex, PoisonError},
    time::Duration,
};

use base64::{Engine as _, prelude::BASE64_STANDARD};
use bendtwin_core::{Category, ids::CaptureId};
use bytes::Bytes;
use hyper::{HeaderMap, Method};
use tokio::{
    fs::File,
    io::{AsyncReadExt as _, AsyncSeekExt as _},
    time::Instant,
};

use crate::{
    CaptureFacts, Error,
    client::{
        http::{Http, Request, Response},
        problem,
    },
};

/// Bytes of one request: the most that a wrong checksum or a dead server costs.
const PART: u64 = 16 << 20;
/// Bytes between two reports of progress.
const SLICE: usize = 256 << 10;
/// Wait before trying again; it doubles up to the longest.
const FIRST_WAIT: Duration = Duration::from_millis(200);
const LONGEST_WAIT: Duration = Duration::from_secs(10);
/// Times that an upload may be gone after it was created.
const MOST_GONE: usize = 3;
/// Where a server has its uploads.
const UPLOADS: &str = "/v1/uploads";
/// Time without progress after which the upload fails. It can be resumed later.
const RETRY_TIMEOUT: Duration = Duration::from_secs(120);
/// Time without progress after which a request is abandoned; at the end the server hashes gigabytes
/// before it answers.
const STALL_TIMEOUT: Duration = Duration::from_secs(300);

/// Upload of one file.
pub(crate) struct Sender<'a> {
    http: &'a Http,
    /// Address of the server, without a slash at the end.
    server: &'a str,
    path: &'a Path,
    length: u64,
    metadata: String,
}

/// State of an upload as the server reports it.
struct UploadState {
    offset: u64,
    capture: Option<CaptureId>,
}

impl<'a> Sender<'a> {
    /// An upload of a file with that digest [BLAKE3, hex].
    pub(crate) async fn new(
        http: &'a Http,
        server: &'a str,
        path: &'a Path,
        digest: &str,
        facts: &CaptureFacts,
    ) -> Result<Self, Error> {
        let length = tokio::fs::metadata(path).await.map_err(|e| Error::file(path, &e))?.len();
        // The display name has no name before it: ids of uploads with a name alone stay.
        let mut key = blake3::Hasher::new();
        key.update(digest.as_bytes());
        key.update(facts.display_name.as_deref().unwrap_or_default().as_bytes());
        let facts = facts.pairs()?;
        for (name, text) in facts.iter().filter(|(name, _)| name != "display_name") {
            key.update(format!("\0{name}\0{text}").as_bytes());
        }
        let request_id = format!("tus-{}", &key.finalize().to_hex()[..32]);
        let own = [("request_id", &*request_id), ("digest", digest)];
        let own = own.map(|(key, value)| (key.to_owned(), value.to_owned()));
        let pairs = facts.into_iter().chain(own);
        let pairs = pairs.map(|(key, value)| format!("{key} {}", BASE64_STANDARD.encode(value)));
        let metadata = pairs.collect::<Vec<_>>().join(",");
        Ok(Self { http, server, path, length, metadata })
    }

    /// Sends the missing bytes and returns the capture made of them. `sent` gets the number of
    /// bytes on the server.
    pub(crate) async fn send(
        &self,
        sent: &(impl Fn(u64) + Clone + Send + Sync + 'static),
    ) -> Result<CaptureId, Error> {
        let mut retries = RetryBudget::new();
        // None while it is to be begun, or found.
        let mut url: Option<String> = None;
        let mut offset = None;
        // Bytes that the server had at most, and the number of times that an upload was gone.
        let (mut most, mut gone) = (0, 0);
        loop {
            let step = match (&url, offset) {
                (None, _) => match self.begin().await {
                    Ok((location, state)) => {
                        url = Some(location);
                        Ok(state)
                    }
                    Err(error) => Err(error),
                },
                (Some(url), None) => self.fetch_state(url).await,
                (Some(url), Some(offset)) => self.send_part(url, offset, sent.clone()).await,
            };
            match step {
                Ok(UploadState { capture: Some(capture), .. }) => {
                    sent(self.length);
                    return Ok(capture);
                }
                Ok(state) => {
                    // Whole and no capture: ask again, the server is about to make it.
                    let stalled = state.offset >= self.length || offset == Some(state.offset);
                    offset = Some(state.offset).filter(|_| state.offset < self.length);
                    sent(state.offset);
                    if stalled {
                        retries.wait(&Error::not_stored(self.server)).await?;
                    } else if state.offset > most {
                        most = state.offset;
                        retries.reset();
                    }
                }
                Err(error) if is_gone(&error) && url.is_some() => {
                    // It expired, or was terminated: create another one.
                    gone += 1;
                    if gone > MOST_GONE {
                        return Err(Error::upload_gone(self.server));
                    }
                    retries.wait(&error).await?;
                    (url, offset, most) = (None, None, 0);
                }
                Err(error) if is_retryable(&error) => {
                    retries.wait(&error).await?;
                    offset = None;
                }
                Err(error) => return Err(error),
            }
        }
    }

    async fn begin(&self) -> Result<(String, UploadState), Error> {
        let request = self
            .request(Method::POST, &format!("{}{UPLOADS}", self.server))
            .header("upload-length", self.length)
            .header("upload-metadata", &self.metadata);
        let response = self.answer(request).await?;
        let url = address(self.server, text(&response.headers, "location")?)?;
        // The response to a creation need not have the offset.
        let state = if response.headers.contains_key("upload-offset") {
            state_of(&response)?
        } else {
            self.fetch_state(&url).await?
        };
        Ok((url, state))
    }

    async fn fetch_state(&self, url: &str) -> Result<UploadState, Error> {
        state_of(&self.answer(self.request(Method::HEAD, url)).await?)
    }

    async fn send_part(
        &self,
        url: &str,
        offset: u64,
        sent: impl Fn(u64) + Send + Sync + 'static,
    ) -> Result<UploadState, Error> {
        let part = self.read(offset).await?;
        let checksum = BASE64_STANDARD.encode(blake3::hash(&part).as_bytes());
        let size = part.len();
        let clock = ProgressClock::default();
        let progressed = clock.clone();
        let slices = (0..size.div_ceil(SLICE)).map(move |i| {
            let end = ((i + 1) * SLICE).min(size);
            progressed.touch();
            // Reported when the connection asks for the next slice, so a little early.
            sent(offset + (i * SLICE) as u64);
            Ok::<Bytes, std::io::Error>(part.slice(i * SLICE..end))
        });
        let request = self
            .request(Method::PATCH, url)
            .header("content-type", "application/offset+octet-stream")
            .header("content-length", size)
            .header("upload-offset", offset)
            .header("upload-checksum", format!("blake3 {checksum}"))
            .body(futures::stream::iter(slices));
        state_of(&self.answer_to(request, &clock).await?)
    }

    async fn read(&self, offset: u64) -> Result<Bytes, Error> {
        let unreadable = |e: std::io::Error| Error::file(self.path, &e);
        let mut file = File::open(self.path).await.map_err(unreadable)?;
        file.seek(SeekFrom::Start(offset)).await.map_err(unreadable)?;
        let size = PART.min(self.length.saturating_sub(offset));
        let mut part = Vec::with_capacity(size as usize);
        file.take(size).read_to_end(&mut part).await.map_err(unreadable)?;
        if part.len() as u64 != size {
            let message = format!("{} has become shorter: push it again", self.path.display());
            return Err(Error::invalid(message));
        }
        Ok(part.into())
    }

    fn request(&self, method: Method, url: &str) -> Request<'_> {
        self.http.request(method, url).header("tus-resumable", "1.0.0")
    }

    async fn answer(&self, request: Request<'_>) -> Result<Response, Error> {
        self.answer_to(request, &ProgressClock::default()).await
    }

    /// Waits for the response as long as the request makes progress. A deadline for the whole
    /// request would fail slow connections and notice dead ones late.
    async fn answer_to(
        &self,
        request: Request<'_>,
        clock: &ProgressClock,
    ) -> Result<Response, Error> {
        let response = tokio::select! {
            response = request.send() => response?,
            () = clock.stalled() => return Err(Error::unreachable(self.server, "it stopped responding")),
        };
        problem::success(response).await
    }
}

/// Address of an upload. A server behind a proxy does not know the path or the host by which it is
/// reached, so only the upload's own name is taken from the `Location` that it gives.
fn address(server: &str, location: &str) -> Result<String, Error> {
    let path = location.split(['?', '#']).next().unwrap_or(location);
    match path.rsplit_once(UPLOADS).and_then(|(_, rest)| rest.strip_prefix('/')) {
        Some(id) if !id.is_empty() && !id.contains('/') => Ok(format!("{server}{UPLOADS}/{id}")),
        _ => Err(Error::malformed(format!("`{location}` is no address of an upload"))),
    }
}

fn state_of(response: &Response) -> Result<UploadState, Error> {
    let headers = &response.headers;
    let offset = text(headers, "upload-offset")?.parse().map_err(Error::malformed)?;
    let capture = if headers.contains_key("bendtwin-capture") {
        Some(text(headers, "bendtwin-capture")?.parse().map_err(Error::malformed)?)
    } else {
        None
    };
    Ok(UploadState { offset, capture })
}

fn text<'h>(headers: &'h HeaderMap, name: &str) -> Result<&'h str, Error> {
    let value = headers.get(name).and_then(|v| v.to_str().ok());
    value.ok_or_else(|| Error::malformed(format!("there is no header {name}")))
}

/// True if the upload does not exist any more. A response to HEAD has no body with a reason, so the
/// status decides.
fn is_gone(error: &Error) -> bool {
    error.category() == Category::NotFound
}

fn is_retryable(error: &Error) -> bool {
    // This connection is alive, so another process sends the same content, and the two would take
    // the upload from each other forever.
    if error.reason() == "UPLOAD_TAKEN_OVER" {
        return false;
    }
    let transient = matches!(
        error.category(),
        Category::Unavailable | Category::Aborted | Category::ResourceExhausted
    );
    transient
        || ["CHECKSUM_MISMATCH", "UPLOAD_IDLE", "BODY_TOO_SLOW", "UPLOAD_BROKEN"]
            .contains(&error.reason())
}

/// Time of a request's last progress.
#[derive(Clone)]
struct ProgressClock(Arc<Mutex<Instant>>);

impl Default for ProgressClock {
    fn default() -> Self {
        Self(Arc::new(Mutex::new(Instant::now())))
    }
}

impl ProgressClock {
    fn touch(&self) {
        *self.0.lock().unwrap_or_else(PoisonError::into_inner) = Instant::now();
    }

    /// Returns when there has been no progress for too long.
    async fn stalled(&self) {
        loop {
            let last = *self.0.lock().unwrap_or_else(PoisonError::into_inner);
            if last.elapsed() >= STALL_TIMEOUT {
                return;
            }
            tokio::time::sleep_until(last + STALL_TIMEOUT).await;
        }
    }
}

/// Time left for retries without progress.
struct RetryBudget {
    ends: Instant,
    pause: Duration,
}

impl RetryBudget {
    fn new() -> Self {
        Self { ends: Instant::now() + RETRY_TIMEOUT, pause: FIRST_WAIT }
    }

    /// Restarts the backoff after progress.
    fn reset(&mut self) {
        *self = Self::new();
    }

    /// Waits before the next attempt, unless the time for retries is over.
    async fn wait(&mut self, error: &Error) -> Result<(), Error> {
        if Instant::now() + self.pause >= self.ends {
            return Err(error.clone());
        }
        // Clients that lost the same server should not all come back at the same time.
        let jitter = f64::from(uuid::Uuid::new_v4().as_bytes()[0]) / 255.0;
        tokio::time::sleep(self.pause.mul_f64(0.5 + 0.5 * jitter)).await;
        self.pause = (2 * self.pause).min(LONGEST_WAIT);
        Ok(())
    }
}

#[cfg(test)]
mod tests;
