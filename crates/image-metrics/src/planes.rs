//! Channels of an image as separate arrays, which filters run over.

use rayon::prelude::*;

use crate::{Image, Pair};

/// Pixels that a thread takes at a time.
pub(crate) const PIECE: usize = 1 << 12;

/// A channel, row by row.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Plane {
    pub(crate) width: usize,
    pub(crate) height: usize,
    /// Shape [height, width].
    pub(crate) values: Vec<f32>,
}

impl Plane {
    /// Plane of the values of a function of each pixel's index.
    pub(crate) fn from_fn(
        width: usize,
        height: usize,
        value: impl Fn(usize) -> f32 + Send + Sync,
    ) -> Self {
        let pixels = (0..width * height).into_par_iter().with_min_len(PIECE);
        Self { width, height, values: pixels.map(value).collect() }
    }

    /// Plane of the values of a function of the same pixel in two planes.
    pub(crate) fn zip(&self, other: &Self, value: impl Fn(f32, f32) -> f32 + Sync) -> Self {
        let pairs = self.values.par_iter().zip(&other.values).with_min_len(PIECE);
        let values = pairs.map(|(a, b)| value(*a, *b)).collect();
        Self { width: self.width, height: self.height, values }
    }
}

/// The three channels of an image of a pair, black where pixels do not count.
pub(crate) fn channels(pair: &Pair<'_>, image: Image<'_>) -> [Plane; 3] {
    let pixels = image.pixels();
    std::array::from_fn(|c| {
        Plane::from_fn(image.width(), image.height(), |p| {
            if pair.is_valid(p) { pixels[p][c] } else { 0.0 }
        })
    })
}
