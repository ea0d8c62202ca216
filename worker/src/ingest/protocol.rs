//! What worker and child say to each other: files in one folder, and lines of JSON on the child's standard
//! output. Both are the same program, so there are no versions.

use std::{io, path::Path};

use bendtwin_core::{Fault, Progress};
use bendtwin_inspect::Verdict;
use serde::{Deserialize, Serialize};

/// What the child is to do.
const REQUEST: &str = "request.json";
/// The capture, as it was uploaded.
pub(super) const ARCHIVE: &str = "capture.zip";
/// Where an earlier attempt stopped, then where this one is; replaced whole.
pub(super) const CHECKPOINT: &str = "checkpoint";
/// The bundle that fits read.
pub(super) const OBSERVATION: &str = "observation.zip";
/// The report as a document.
pub(super) const REPORT: &str = "report.json";
/// The report as a page.
pub(super) const PAGE: &str = "report.html";

/// What the child is to do with the archive.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Request {
    /// What people call the capture.
    pub(super) name: String,
    /// The settings of the ingest, as JSON.
    pub(super) settings: String,
    /// Memory that the child may take [bytes].
    pub(super) memory_bytes: u64,
}

/// A line of the child's.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum Message {
    /// How far it is.
    Progress(Progress),
    /// A checkpoint lies there.
    Checkpoint,
    /// Observation and report lie there. The last line.
    Observed {
        /// The report's.
        verdict: Verdict,
    },
    /// There is nothing to fit. The report lies there. The last line.
    Refused {
        /// The report's.
        verdict: Verdict,
        /// Why.
        fault: Fault,
    },
    /// The ingest could not be done; nothing is known about the capture. The last line.
    Failed(Fault),
}

impl Request {
    pub(super) fn write(&self, folder: &Path) -> io::Result<()> {
        std::fs::write(folder.join(REQUEST), serde_json::to_vec(self)?)
    }

    pub(super) fn read(folder: &Path) -> io::Result<Self> {
        Ok(serde_json::from_slice(&std::fs::read(folder.join(REQUEST))?)?)
    }
}
