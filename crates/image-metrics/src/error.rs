//! Images that cannot be compared.

/// Images that cannot be compared.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Error {
    /// No pixels.
    #[error("an image of {width} x {height} pixels has nothing to compare: crop it less")]
    Empty {
        /// Columns.
        width: u32,
        /// Rows.
        height: u32,
    },
    /// An array of another length than its image has pixels.
    #[error("{what}: {found} entries for an image of {width} x {height} pixels")]
    Length {
        /// The array.
        what: &'static str,
        /// Number of entries found.
        found: usize,
        /// Columns.
        width: u32,
        /// Rows.
        height: u32,
    },
    /// NaN or infinity.
    #[error("the colour of pixel {pixel} is not a finite number")]
    NotFinite {
        /// Index of the pixel, row by row.
        pixel: usize,
    },
    /// Images of two sizes.
    #[error(
        "images of {a:?} and {b:?} pixels (columns, rows) cannot be compared: render at the size of the recording"
    )]
    Sizes {
        /// Columns and rows of the first.
        a: [u32; 2],
        /// Columns and rows of the second.
        b: [u32; 2],
    },
    /// A crop that is larger than the image that it is said to be cut from.
    #[error("a crop of {crop} pixels is not part of an image of {whole}")]
    Whole {
        /// Pixels of the crop.
        crop: usize,
        /// Pixels of the image.
        whole: usize,
    },
}
