//! Limits on the cost of reading a capture. Every allocation whose size a file
//! decides is charged to a [`Budget`] before it is made.

use crate::Error;

/// Caps on what a reader accepts.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Limits {
    /// Bytes that may be held in memory in all: decompressed files and decoded arrays.
    pub total_bytes: u64,
    /// Decompressed bytes of one file.
    pub file_bytes: u64,
    /// Entries of an archive.
    pub archive_entries: usize,
    /// Length of an entry's name in bytes.
    pub name_bytes: usize,
    /// Decompressed over compressed bytes; asked only of files above [`Limits::ratio_from_bytes`],
    /// because masks that are true throughout deflate a thousandfold.
    pub compression_ratio: u64,
    /// Smallest decompressed size whose ratio is asked about.
    pub ratio_from_bytes: u64,
    /// Opcodes of one pickle.
    pub pickle_opcodes: usize,
    /// Nesting of lists, tuples and dictionaries in a pickle.
    pub pickle_depth: usize,
    /// Frames of one sequence.
    pub frames: usize,
    /// Tracked points of the object.
    pub points: usize,
    /// Control points of one sequence.
    pub controls: usize,
    /// Sequences of a capture.
    pub sequences: usize,
    /// Cameras of a raw recording.
    pub cameras: usize,
    /// Frames of a raw recording.
    pub recording_frames: usize,
    /// Pixels of one image of a raw recording.
    pub image_pixels: usize,
}

impl Default for Limits {
    fn default() -> Self {
        Self {
            total_bytes: 2 << 30,
            file_bytes: 1 << 30,
            archive_entries: 100_000,
            name_bytes: 512,
            compression_ratio: 200,
            ratio_from_bytes: 32 << 20,
            pickle_opcodes: 1_000_000,
            pickle_depth: 32,
            frames: 1_000_000,
            points: 1_000_000,
            controls: 10_000,
            sequences: 10_000,
            cameras: 64,
            recording_frames: 100_000,
            image_pixels: 1 << 25,
        }
    }
}

/// Remainder of [`Limits::total_bytes`].
#[derive(Debug)]
pub(crate) struct Budget {
    total: u64,
    left: u64,
}

impl Budget {
    pub(crate) fn new(limits: &Limits) -> Self {
        Self { total: limits.total_bytes, left: limits.total_bytes }
    }

    /// Takes `bytes` for `what`, or refuses before anything is allocated.
    pub(crate) fn take(&mut self, bytes: u64, what: &str) -> Result<(), Error> {
        match self.left.checked_sub(bytes) {
            Some(left) => {
                self.left = left;
                Ok(())
            }
            None => Err(Error::TooLarge { what: what.to_owned(), bytes, limit: self.total }),
        }
    }
}
