//! Masks of object and hands from a few strokes.
//!
//! [`segment`] takes a raw recording without masks and strokes that mark the object, the hands and, if
//! need be, the background in some images, and makes the masks of all cameras and frames:
//!
//! 1. *scene*: each camera's backdrop and the table are measured from frames of the whole recording
//!    (`backdrop`, `table`);
//! 2. *cells*: pixels in front of the backdrop or above the table become points in space, in cells of
//!    6 mm that all cameras share, so that a click in one camera is known to all (`scene`, `cells`);
//! 3. *labels*: in the first frame with strokes, cells are labelled by the way to the strokes and by the
//!    colours of the parts, which become known meanwhile; in all others by colours and by what cells
//!    that lie near and look alike were in the frame before, forwards and backwards in time (`label`,
//!    `follow`);
//! 4. *masks*: pixels take the labels of their cells, sharpened by their colours, and filled where no
//!    depth was measured (`paint`).

mod backdrop;
mod cells;
mod colors;
mod error;
mod findings;
mod follow;
mod label;
mod looks;
mod marks;
mod paint;
mod part;
mod scene;
mod table;
mod view;

#[cfg(test)]
mod tests;

use bendtwin_capture::raw::{MaskSet, Recording};
use bendtwin_core::{CancelToken, Finding, settings::ingest::Stroke};
use serde_json::{Value, json};

pub use self::error::Error;

/// Name of the document beside masks in their archive or folder.
pub const FOLLOWING_FILE: &str = "mask/following.json";

/// Masks that were made from strokes.
#[derive(Clone, Debug)]
pub struct Segmented {
    /// Masks of all cameras and frames.
    pub masks: MaskSet,
    /// Share of object and hand in an image whose label is doubtful, 0..=1; `None` for a frame that the
    /// camera lacks. Shape [camera][T].
    pub doubt: Vec<Vec<Option<f32>>>,
    /// Strokes that could not be used, parts that look alike, and doubtful masks.
    pub findings: Vec<Finding>,
}

impl Segmented {
    /// The document that goes with the masks as [`FOLLOWING_FILE`]: the strokes, and the doubt of each
    /// camera's frames.
    pub fn document(&self, strokes: &[Stroke]) -> Value {
        let cameras = self.doubt.iter().map(|doubt| json!({ "doubt": doubt }));
        json!({ "strokes": strokes, "cameras": cameras.collect::<Vec<_>>() })
    }
}

/// Makes masks from strokes. `progress` is called after each frame with the share of the work that is
/// done, 0..=1. Damaged images count as not recorded; masks that the recording has are not looked at.
///
/// # Errors
/// If nothing marks the object where depth was measured, the cameras are not calibrated, an image has
/// another size than its camera, or `cancel` was called, which ends the work within a frame.
pub fn segment(
    recording: &Recording,
    strokes: &[Stroke],
    progress: &mut dyn FnMut(f64),
    cancel: &CancelToken,
) -> Result<Segmented, Error> {
    follow::run(&recording.usable(), strokes, progress, cancel)
}
