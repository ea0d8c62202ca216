//! Masks that are no images: arrays of numpy, archives of them, and run lengths of COCO in JSON, for
//! one frame or for all.

mod arrays;
mod document;
mod runs;

pub(in crate::raw) use self::runs::Runs;
use super::{Size, damaged};
use crate::{Error, Limits, limits::Budget};

/// Masks of one frame: what pixels show, beside and over each other.
pub(in crate::raw) type Layers = Vec<Layer>;

/// Labels of pixels, or the pixels of one label.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::raw) struct Layer {
    /// The label of all pixels that are not 0; `None`: numbers are labels.
    pub(in crate::raw) label: Option<String>,
    pub(in crate::raw) runs: Runs,
}

impl Layer {
    /// Bytes that it takes in memory.
    pub(in crate::raw) fn bytes(&self) -> u64 {
        let label = self.label.as_ref().map_or(0, String::len);
        (size_of::<Self>() + label) as u64 + self.runs.bytes()
    }
}

/// What a file of masks is read as.
#[derive(Clone, Copy, Debug)]
pub(in crate::raw) struct Expected {
    pub(in crate::raw) size: Size,
    /// Frames of the file: 1, or those of the recording.
    pub(in crate::raw) frames: usize,
    /// The file has a frame for each of the recording.
    pub(in crate::raw) whole: bool,
}

/// Masks from an `.npy`, `.npz` or `.json` file, frame by frame; at most as many frames as expected.
///
/// # Errors
/// If it is damaged, of another size, or beyond the limits.
pub(in crate::raw) fn read(
    at: &str,
    bytes: &[u8],
    expected: Expected,
    limits: &Limits,
    budget: &mut Budget,
) -> Result<Vec<Layers>, Error> {
    if bytes.starts_with(b"\x93NUMPY") {
        arrays::of_npy(at, bytes, expected, budget)
    } else if bytes.starts_with(b"PK") {
        arrays::of_npz(at, bytes, expected, limits, budget)
    } else if bytes.iter().find(|b| !b.is_ascii_whitespace()).is_some_and(|b| b"{[".contains(b)) {
        document::read(at, bytes, expected, budget)
    } else {
        Err(damaged(at, "it is neither an array of numpy nor a JSON document"))
    }
}

#[cfg(test)]
mod tests;
