//! Views in the archive of an observation: `views.json` and arrays for each camera, beside the bundle.
//! Readers of bundles pass them over. `docs/formats/capture.md` specifies them for other programs.

mod reader;
mod writer;

pub use reader::read_views;
pub use writer::write_observation;

use serde::{Deserialize, Serialize};

/// The document of the views.
const MARKER: &str = "views.json";
/// The word in `format`.
const FORMAT: &str = "bendtwin-views";
/// Version that this build reads and writes.
const VERSION: u64 = 1;

#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Document {
    format: String,
    version: u64,
    cameras: Vec<Camera>,
}

#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Camera {
    name: String,
    /// Columns and rows of whole images.
    size: [u32; 2],
    /// Focal lengths in columns and in rows.
    focal: [f64; 2],
    /// Column and row of the principal point.
    centre: [f64; 2],
}

/// The place of a camera's array in the archive.
fn place(camera: usize, array: &str) -> String {
    format!("views/{camera:02}/{array}.npy")
}

/// Names of a camera's arrays.
mod arrays {
    /// World to camera, float64 [1 or frames, 3, 4].
    pub(super) const POSES: &str = "world_to_camera";
    /// Frame, column, row, columns and rows of each view, uint32 [views, 5].
    pub(super) const VIEWS: &str = "views";
    /// Colours of the pixels of all views, one view after another, uint8 [pixels, 3].
    pub(super) const COLORS: &str = "colors";
    /// Labels of the same pixels, uint8 [pixels].
    pub(super) const LABELS: &str = "labels";
    /// Depths of the same pixels in millimetres, uint16 [pixels].
    pub(super) const DEPTHS: &str = "depths_mm";
}

#[cfg(test)]
mod tests;
