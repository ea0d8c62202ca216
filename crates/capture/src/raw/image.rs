//! Images in memory: row by row from the upper left.

use super::{decode, encode};
use crate::{Error, Limits, limits::Budget};

/// Pixels on a grid.
#[derive(Clone, Debug, PartialEq)]
pub struct Image<P> {
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Pixels, shape [height, width].
    pub pixels: Vec<P>,
}

/// Red, green, blue, 0..=255.
pub type ColorImage = Image<[u8; 3]>;
/// Metres along the optical axis; 0 where nothing was measured.
pub type DepthImage = Image<f32>;
/// A pixel is `true` if it belongs to what the mask shows.
pub type Mask = Image<bool>;

impl<P: Copy> Image<P> {
    /// An image of one value.
    pub fn filled(width: usize, height: usize, pixel: P) -> Self {
        Self { width, height, pixels: vec![pixel; width * height] }
    }

    /// The pixel at a column and row, if it lies inside.
    pub fn get(&self, column: usize, row: usize) -> Option<P> {
        (column < self.width).then(|| self.pixels.get(row * self.width + column).copied())?
    }

    /// The pixels of a row.
    pub fn row(&self, row: usize) -> &[P] {
        &self.pixels[row * self.width..(row + 1) * self.width]
    }
}

impl ColorImage {
    /// Decodes a PNG or JPEG file of this size as columns and rows; `at` is its name in messages.
    ///
    /// # Errors
    /// If it is damaged or of another size.
    pub fn decode(at: &str, bytes: &[u8], size: [usize; 2]) -> Result<Self, Error> {
        decode::color(at, bytes, size)
    }

    /// Encodes as PNG.
    ///
    /// # Errors
    /// If it has no pixels, or more than a PNG file can have.
    pub fn encode(&self) -> Result<Vec<u8>, Error> {
        encode::color(self)
    }
}

impl DepthImage {
    /// Decodes a PNG or .npy file whose numbers are `unit_m` metres each, onto a grid of this size
    /// as columns and rows; `at` is its name in messages.
    ///
    /// # Errors
    /// If it is damaged, no depth, of another section, or beyond the limits.
    pub fn decode(
        at: &str,
        bytes: &[u8],
        unit_m: f64,
        size: [usize; 2],
        limits: &Limits,
    ) -> Result<Self, Error> {
        let unit = decode::DepthUnit::Declared(unit_m);
        decode::depth(at, bytes, unit, size, &mut Budget::new(limits))
    }
}

impl Mask {
    /// Decodes a PNG or JPEG file of this size as columns and rows; `at` is its name in messages.
    ///
    /// # Errors
    /// If it is damaged or of another size.
    pub fn decode(at: &str, bytes: &[u8], size: [usize; 2]) -> Result<Self, Error> {
        decode::mask(at, bytes, size)
    }

    /// Encodes as PNG.
    ///
    /// # Errors
    /// If it has no pixels, or more than a PNG file can have.
    pub fn encode(&self) -> Result<Vec<u8>, Error> {
        encode::mask(self)
    }
}
