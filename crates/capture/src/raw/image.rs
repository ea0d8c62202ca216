//! Images in memory: row by row from the upper left.

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
