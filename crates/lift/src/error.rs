//! Reasons why a recording cannot become a capture, with what its owner should do.

use bendtwin_core::{CancelToken, ObserverError, Problem, checkpoint::Refusal};

/// Why an ingest fails.
#[derive(Debug, thiserror::Error, Problem)]
pub enum Error {
    /// Settings out of range.
    #[error("the ingest's settings are wrong: {}", .0.join("; "))]
    #[problem(InvalidArgument, "INVALID_INGEST_SETTINGS")]
    Settings(Vec<String>),
    /// Frames cannot be read.
    #[error(transparent)]
    Recording(#[from] bendtwin_capture::Error),
    /// A recording that contradicts itself.
    #[error("the recording is inconsistent: {0}")]
    #[problem(InvalidArgument, "RECORDING_INCONSISTENT")]
    Inconsistent(String),
    /// More tracks than fit into memory.
    #[error(
        "the cameras have {tracks} tracks over {frames} frames, beyond the limits of 100000 tracks and of 12 million tracks \
         times frames: track fewer points, or split the recording"
    )]
    #[problem(ResourceExhausted, "TOO_MANY_TRACKS")]
    TooManyTracks {
        /// Tracks of all cameras.
        tracks: usize,
        /// Frames.
        frames: usize,
    },
    /// No object in any mask.
    #[error(
        "no camera's mask shows the object with depth behind it: check that the object's masks are not empty, belong to these \
         images, and that depth was recorded there ({0})"
    )]
    #[problem(InvalidArgument, "OBJECT_NOT_SEEN")]
    NoObject(String),
    /// No track on the object.
    #[error(
        "none of {tracks} tracks lies on the object in the first frame ({detail}): check that the tracks' columns and \
         rows are in order, and that the first frame shows the object"
    )]
    #[problem(InvalidArgument, "OBJECT_NOT_TRACKED")]
    NoTracks {
        /// Tracks of all cameras.
        tracks: usize,
        /// The counts by which they were lost.
        detail: String,
    },
    /// Every track is gone after the first frames.
    #[error(
        "only {seen} of {tracks} tracks on the object are still seen in frame {frame}: a fit needs some; check for cameras \
         that moved, masks that jump, or cut the recording there"
    )]
    #[problem(InvalidArgument, "TRACKS_LOST")]
    TracksLost {
        /// Tracks on the object in the first frame.
        tracks: usize,
        /// Number of them that are seen.
        seen: usize,
        /// In which frame.
        frame: usize,
    },
    /// The object is gone from all masks.
    #[error(
        "no mask shows the object from frame {from} on, and {train} frames are for fitting: segment these frames again, or \
         cut the recording there"
    )]
    #[problem(InvalidArgument, "OBJECT_MASK_EMPTY")]
    ObjectGone {
        /// First frame without it.
        from: usize,
        /// Frames for fitting.
        train: usize,
    },
    /// Masks show a hand, but not from the first frame on.
    #[error(
        "the hand's masks are empty up to frame {to}: let the recording begin when the hand is in view, and mask it from the \
         first frame on"
    )]
    #[problem(InvalidArgument, "HAND_NOT_TRACKED")]
    HandLate {
        /// Last frame without it.
        to: usize,
    },
    /// Masks show a hand, but too little of it where it starts.
    #[error(
        "the masks show a hand or gripper, but hardly in the first frame, where {tracks} tracks lie on it and {needed} are \
         needed: let the recording begin when the hand is in view"
    )]
    #[problem(InvalidArgument, "HAND_NOT_TRACKED")]
    NoHandTracks {
        /// Tracks on the hand.
        tracks: usize,
        /// Tracks needed.
        needed: usize,
    },
    /// A hand that is hidden for long.
    #[error(
        "no mask shows the hand from frame {from} to {to}, and gaps are filled up to {limit} frames: segment it there, cut \
         the recording, or raise controls.max_gap_frames"
    )]
    #[problem(InvalidArgument, "HAND_LOST")]
    HandLost {
        /// First frame without it.
        from: usize,
        /// Last frame without it.
        to: usize,
        /// Longest gap that is filled.
        limit: usize,
    },
    /// The mesh cannot be read or aligned.
    #[error("the mesh `{name}` cannot be used: {why}; repair it, or set completion.mesh to false")]
    #[problem(InvalidArgument, "MESH_UNUSABLE")]
    Mesh {
        /// File name.
        name: String,
        /// The fault.
        why: String,
    },
    /// The built-in tracker failed.
    #[error(transparent)]
    Tracker(bendtwin_flow::Error),
    /// The checkpoint is damaged or of another version.
    #[error("the checkpoint cannot be read ({0}): start the ingest again without it")]
    #[problem(FailedPrecondition, "CHECKPOINT_UNREADABLE")]
    Checkpoint(String),
    /// The checkpoint belongs to another ingest.
    #[error(
        "the checkpoint belongs to another recording or other settings: start the ingest again without it"
    )]
    #[problem(FailedPrecondition, "CHECKPOINT_OF_ANOTHER_INGEST")]
    OtherCheckpoint,
    /// The observer could not keep a checkpoint (a lost lease, say).
    #[error("the ingest's checkpoint could not be kept: {0}")]
    #[problem(Aborted, "CHECKPOINT_NOT_KEPT")]
    Observer(#[source] ObserverError),
    /// Cancelled on request.
    #[error("the ingest was cancelled")]
    #[problem(Cancelled, "CANCELLED")]
    Cancelled,
}

/// Ends the ingest if cancellation was requested.
pub(crate) fn check(cancel: &CancelToken) -> Result<(), Error> {
    if cancel.is_cancelled() { Err(Error::Cancelled) } else { Ok(()) }
}

impl From<bendtwin_flow::Error> for Error {
    fn from(error: bendtwin_flow::Error) -> Self {
        match error {
            bendtwin_flow::Error::Cancelled => Self::Cancelled,
            bendtwin_flow::Error::Recording(error) => Self::Recording(error),
            other => Self::Tracker(other),
        }
    }
}

impl From<Refusal> for Error {
    fn from(refusal: Refusal) -> Self {
        match refusal {
            Refusal::OtherWork => Self::OtherCheckpoint,
            other => Self::Checkpoint(other.to_string()),
        }
    }
}
