//! Captures, twins and checkpoints fetched from the server.

use std::{io::Write as _, path::Path};

use bendtwin_core::{Category, Problem};
use bytes::{Bytes, BytesMut};
use tempfile::NamedTempFile;

use crate::server_client::{CallError, ServerClient};

/// Reason for which content could not be fetched.
#[derive(Debug, thiserror::Error, Problem)]
pub(crate) enum FetchError {
    /// The server did not give it.
    #[error("cannot fetch {name}: {}", fault.message)]
    #[problem(fault.category, "CONTENT_UNAVAILABLE")]
    Server {
        /// Name of the content.
        name: String,
        /// The server's error.
        fault: bendtwin_core::Fault,
    },
    /// Another worker has the job.
    #[error("another worker has the job")]
    #[problem(Aborted, "STALE_LEASE")]
    Stale,
    /// Larger than this worker accepts.
    #[error(
        "{name} is larger than {limit} bytes, the most that this worker takes: raise its limit"
    )]
    #[problem(ResourceExhausted, "CONTENT_TOO_LARGE")]
    TooLarge {
        /// Name of the content.
        name: String,
        /// The limit.
        limit: u64,
    },
    /// The content has another digest than the stored one.
    #[error("{name} has digest {found} where {expected} was stored: the stored file is damaged")]
    #[problem(DataLoss, "CONTENT_DAMAGED")]
    Digest {
        /// Name of the content.
        name: String,
        /// Digest of what arrived.
        found: String,
        /// Digest that it should have.
        expected: String,
    },
    /// The temporary file cannot be written.
    #[error(
        "cannot keep {name} in a temporary file: {source}; free disk space or set --scratch-dir"
    )]
    #[problem(ResourceExhausted, "NO_DISK_SPACE")]
    Disk {
        /// Name of the content.
        name: String,
        /// The system's error.
        source: std::io::Error,
    },
}

fn server_error(name: &str, error: CallError) -> FetchError {
    match error {
        CallError::Stale => FetchError::Stale,
        other => {
            let mut fault = other.fault();
            if fault.reason == "WORKER_UNKNOWN" {
                // The server has restarted; this worker is about to register again.
                fault.category = Category::Unavailable;
            }
            FetchError::Server { name: name.to_owned(), fault }
        }
    }
}

/// Fetches content into memory, up to `limit` bytes.
pub(crate) async fn fetch(
    server: &ServerClient,
    name: &str,
    limit: u64,
) -> Result<Bytes, FetchError> {
    let mut download = server.download(name.to_owned()).await.map_err(|e| server_error(name, e))?;
    let mut content = BytesMut::new();
    while let Some(chunk) = download.next().await.map_err(|e| server_error(name, e))? {
        if (content.len() + chunk.len()) as u64 > limit {
            return Err(FetchError::TooLarge { name: name.to_owned(), limit });
        }
        content.extend_from_slice(&chunk);
    }
    Ok(content.freeze())
}

/// Fetches content into a temporary file in `dir` and checks its digest where one is known.
pub(crate) async fn fetch_file(
    server: &ServerClient,
    name: &str,
    digest: Option<&str>,
    dir: &Path,
) -> Result<NamedTempFile, FetchError> {
    let disk = |source| FetchError::Disk { name: name.to_owned(), source };
    let mut file = tempfile::Builder::new()
        .prefix("bendtwin-")
        .suffix(".zip")
        .tempfile_in(dir)
        .map_err(disk)?;
    let mut hasher = blake3::Hasher::new();
    let mut download = server.download(name.to_owned()).await.map_err(|e| server_error(name, e))?;
    // Chunks are small and go to the page cache, so writing in place blocks no one for long.
    while let Some(chunk) = download.next().await.map_err(|e| server_error(name, e))? {
        hasher.update(&chunk);
        file.write_all(&chunk).map_err(disk)?;
    }
    file.flush().map_err(disk)?;
    let found = hasher.finalize().to_hex().to_string();
    match digest.filter(|d| !d.is_empty() && !d.eq_ignore_ascii_case(&found)) {
        Some(expected) => {
            Err(FetchError::Digest { name: name.to_owned(), found, expected: expected.to_owned() })
        }
        None => Ok(file),
    }
}
