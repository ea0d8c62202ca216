//! Supplements: what is added to a recording after it was made, without touching its files.

use std::path::Path;

/// Files that are added to a recording.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Supplements<'a> {
    /// An archive or folder with masks, in any layout that a raw PhysTwin case may have them in.
    pub masks: Option<&'a Path>,
    /// A document with the calibration.
    pub calibration: Option<&'a Path>,
}
