//! Supplements: what is added to a recording after it was made, without touching its files.

use std::path::Path;

use crate::{Error, Limits, files::Files};

/// Files that are added to a recording.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Supplements<'a> {
    /// An archive or folder with masks, in any layout that a raw PhysTwin case may have them in.
    pub masks: Option<&'a Path>,
    /// A document with the calibration.
    pub calibration: Option<&'a Path>,
}

/// A file of an archive or folder by its name inside, if it is there and not longer than `cap` bytes.
///
/// # Errors
/// If the archive cannot be read, or the file is longer.
pub fn file_in(
    path: &Path,
    name: &str,
    cap: u64,
    limits: &Limits,
) -> Result<Option<Vec<u8>>, Error> {
    Files::open(path, limits)?.find_within(name, cap)
}
