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
    /// Bytes that all files of an archive may unpack to, regardless of the archive's size.
    pub unpacked_bytes: u64,
    /// Further such bytes for every byte of the archive.
    pub unpacked_per_byte: u64,
    /// Pixels that all images of a packed recording may have, regardless of its size. Decoding is
    /// the larger part of the work that a small file can cause.
    pub pixels: u64,
    /// Further pixels for every byte of the file. Images of real scenes have about ten.
    pub pixels_per_byte: u64,
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
            unpacked_bytes: 4 << 30,
            unpacked_per_byte: 64,
            pixels: 1 << 29,
            pixels_per_byte: 128,
        }
    }
}

impl Limits {
    /// Bytes that the files of an archive of `length` bytes may unpack to.
    pub(crate) fn unpacked_of(&self, length: u64) -> u64 {
        self.unpacked_bytes.saturating_add(self.unpacked_per_byte.saturating_mul(length))
    }

    /// Refuses a recording whose images have more pixels than its file may hold. `length` are the
    /// bytes of the file; none for a folder, whose owner may read what they like.
    pub(crate) fn check_pixels(
        &self,
        pixels: u64,
        frames: usize,
        length: Option<u64>,
    ) -> Result<(), Error> {
        let Some(length) = length else { return Ok(()) };
        let limit = self.pixels.saturating_add(self.pixels_per_byte.saturating_mul(length));
        if pixels <= limit {
            return Ok(());
        }
        let share = limit as f64 / pixels as f64;
        let fitting = (frames as f64 * share).floor() as u64;
        Err(Error::Pixels { pixels, limit, length, frames: frames as u64, fitting })
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
