//! Protocol between worker and child: files in one folder, and lines of JSON on the child's
//! standard output. Both are the same program, so there are no versions.

use std::{
    fs::{File, OpenOptions},
    io::{self, Read as _},
    path::Path,
};

use bendtwin_core::{Fault, Progress};
use bendtwin_inspect::Verdict;
use serde::{Deserialize, Serialize};

use super::sandbox::{Enforced, Resources, Sandbox};

/// File with the request.
const REQUEST: &str = "request.json";
/// File with the uploaded capture.
pub(super) const ARCHIVE: &str = "capture.zip";
/// File with the checkpoint to resume from, replaced as a whole by the child's own.
pub(super) const CHECKPOINT: &str = "checkpoint";
/// File with the bundle that fits read.
pub(super) const OBSERVATION: &str = "observation.zip";
/// File with what a player shows.
pub(super) const PLAYBACK: &str = "playback";
/// File with the masks that were made of strokes.
pub(super) const MASKS: &str = "masks.zip";
/// File with the masks that an earlier ingest made of strokes.
pub(super) const EARLIER_MASKS: &str = "masks-before.zip";
/// Files that were added to the capture.
pub(super) const SUPPLEMENT_MASKS: &str = "supplement-masks";
pub(super) const SUPPLEMENT_CALIBRATION: &str = "supplement-calibration";
/// File with the report as JSON.
pub(super) const REPORT: &str = "report.json";
/// File with the report as HTML.
pub(super) const PAGE: &str = "report.html";

/// Opens a file that the child wrote. Anything but a regular file is refused: a link would lead the
/// worker to its own files, a pipe would block it.
pub(super) fn open_result(path: &Path) -> io::Result<File> {
    let mut options = OpenOptions::new();
    options.read(true);
    #[cfg(unix)]
    std::os::unix::fs::OpenOptionsExt::custom_flags(
        &mut options,
        libc::O_NOFOLLOW | libc::O_NONBLOCK,
    );
    let file = options.open(path)?;
    if file.metadata()?.is_file() {
        return Ok(file);
    }
    Err(io::Error::new(io::ErrorKind::InvalidData, "it is not a regular file"))
}

/// Reads a file that the child wrote, if it is not larger than `limit` bytes.
pub(super) fn read_result(path: &Path, limit: u64) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    open_result(path)?.take(limit.saturating_add(1)).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > limit {
        return Err(io::Error::new(io::ErrorKind::FileTooLarge, "it is too large"));
    }
    Ok(bytes)
}

/// The child's task.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Request {
    /// Display name of the capture.
    pub(super) name: String,
    /// The settings of the ingest, as JSON.
    pub(super) settings: String,
    /// Resources that the child may take.
    pub(super) resources: Resources,
    /// Demand on its confinement.
    pub(super) sandbox: Sandbox,
}

/// A message of the child, one line each.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum Message {
    /// The child has confined itself: these layers are in force.
    Confined(Enforced),
    /// Progress.
    Progress(Progress),
    /// A checkpoint has been written.
    Checkpoint,
    /// Observation, playback and report have been written, and masks if there are strokes. The final
    /// message.
    Observed {
        /// Verdict of the report.
        verdict: Verdict,
    },
    /// Masks, playback and report have been written, and the settings ask for no more. The final
    /// message.
    Masked {
        /// Verdict of the report.
        verdict: Verdict,
    },
    /// The capture cannot be fitted. The report has been written, and a playback if there are images,
    /// and masks if there are strokes. The final message.
    Refused {
        /// Verdict of the report.
        verdict: Verdict,
        /// The fault of the capture.
        fault: Fault,
    },
    /// The ingest could not be done; nothing is known about the capture. The final message.
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
