//! Progress of an ingest.

/// Step of an ingest.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Step {
    /// Opening the capture.
    Read,
    /// Measuring the poses of cameras with a board.
    Calibrate,
    /// Making masks of strokes.
    Mask,
    /// Judging a raw recording.
    Inspect,
    /// Tracking points through the colour images, where the recording has no tracks.
    Track,
    /// Reading frames, cleaning masks, lifting tracks.
    Lift,
    /// Filtering motion, thinning, control points.
    Assemble,
    /// Aligning and sampling the mesh.
    Complete,
    /// Making the playback.
    Playback,
}

impl Step {
    /// Name in documents and lines, `inspect` say.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Read => "read",
            Self::Calibrate => "calibrate",
            Self::Mask => "mask",
            Self::Inspect => "inspect",
            Self::Track => "track",
            Self::Lift => "lift",
            Self::Assemble => "assemble",
            Self::Complete => "complete",
            Self::Playback => "playback",
        }
    }
}

impl From<bendtwin_lift::Step> for Step {
    fn from(step: bendtwin_lift::Step) -> Self {
        match step {
            bendtwin_lift::Step::Track => Self::Track,
            bendtwin_lift::Step::Lift => Self::Lift,
            bendtwin_lift::Step::Assemble => Self::Assemble,
            bendtwin_lift::Step::Complete => Self::Complete,
        }
    }
}

/// Progress of an ingest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Progress {
    /// The step under way.
    pub step: Step,
    /// Share of the whole ingest that is done, 0..=1.
    pub fraction: f64,
}
