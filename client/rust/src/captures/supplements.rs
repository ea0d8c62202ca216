//! Files that are added to captures after their upload.

use std::{fmt, path::Path};

use bendtwin_core::ids::CaptureId;
use bendtwin_proto::v1::{DeleteSupplementRequest, ExportSupplementRequest};
use futures::TryStreamExt as _;
use hyper::Method;

use super::{Captures, Destination, save};
use crate::{Capture, Error};

/// Kind of a file that is added to a capture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SupplementKind {
    /// An archive of masks (ZIP or tar), in place of those of the recording.
    Masks,
    /// A calibration document (JSON), in place of the recording's own calibration.
    Calibration,
}

impl SupplementKind {
    /// The word of the kind in the API.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Masks => "masks",
            Self::Calibration => "calibration",
        }
    }
}

impl fmt::Display for SupplementKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.as_str())
    }
}

impl Captures {
    /// Adds a file to a capture, or replaces the one of its kind, streamed from disk, its digest
    /// checked by the server. The next ingest reads it. `sent` gets the number of bytes sent so far.
    ///
    /// # Errors
    /// If the file cannot be read, an ingest or a fit of the capture is queued or running, or the
    /// server refuses it or cannot be reached.
    pub async fn add_supplement(
        &self,
        name: CaptureId,
        kind: SupplementKind,
        file: &Path,
        sent: impl Fn(u64) + Clone + Send + Sync + 'static,
    ) -> Result<Capture, Error> {
        let url = format!("{}/v1/{name}/supplements/{kind}", self.url);
        // The same content again changes nothing.
        let to = Destination { method: Method::PUT, url: &url, key: None };
        self.send(file, "application/octet-stream", to, sent).await
    }

    /// Writes a file that was added to a capture to a file.
    ///
    /// # Errors
    /// If the capture lacks the kind, the file cannot be written, or the server cannot be asked.
    pub async fn export_supplement(
        &self,
        name: CaptureId,
        kind: SupplementKind,
        file: &Path,
    ) -> Result<(), Error> {
        let request = ExportSupplementRequest { name: name.to_string(), kind: kind.to_string() };
        let chunks = self.service.clone().export_supplement(request).await?.into_inner();
        save(chunks.map_ok(|part| part.chunk), file).await
    }

    /// Removes a file that was added to a capture.
    ///
    /// # Errors
    /// If the capture lacks the kind, an ingest or a fit of the capture is queued or running, or the
    /// server cannot be asked.
    pub async fn delete_supplement(
        &self,
        name: CaptureId,
        kind: SupplementKind,
    ) -> Result<(), Error> {
        let request = DeleteSupplementRequest { name: name.to_string(), kind: kind.to_string() };
        self.service.clone().delete_supplement(request).await?;
        Ok(())
    }
}
