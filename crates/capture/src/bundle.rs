//! BendTwin's own bundle: `capture.json` and .npy arrays, in a folder or a ZIP
//! archive. `docs/formats/capture.md` specifies it for other programs.

mod manifest;
mod reader;
mod writer;

pub(crate) use manifest::{Ground, MARKER, Manifest};
pub(crate) use reader::{index_in, read};
pub(crate) use writer::{put, write_bundle_to};
pub use writer::{write_bundle, write_bundle_file};

/// Version that this build writes; it reads this and every earlier one.
pub const VERSION: u64 = 1;

/// Names of the arrays, in the bundle's root and in each sequence's folder.
mod arrays {
    pub(super) const COLORS: &str = "object_colors.npy";
    pub(super) const SURFACE: &str = "completed_surface.npy";
    pub(super) const INTERIOR: &str = "interior.npy";
    pub(super) const EDGES: &str = "edges.npy";
    pub(super) const REST: &str = "rest_points.npy";
    pub(super) const PINS: &str = "pins.npy";
    pub(super) const HANDS: &str = "hands.npy";
    pub(super) const POINTS: &str = "object_points.npy";
    pub(super) const VISIBLE: &str = "object_visible.npy";
    pub(super) const MOTION: &str = "object_motion_valid.npy";
    pub(super) const CONTROLS: &str = "control_points.npy";
    pub(super) const TRUTH: &str = "truth_tracks.npy";
}

#[cfg(test)]
mod tests;
