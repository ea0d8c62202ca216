//! Depth from 16-bit PNG files and .npy arrays, onto the grid of the colour image.

use super::{Size, damaged, png};
use crate::{
    Error,
    array::Array,
    limits::Budget,
    npy,
    raw::{DepthImage, Image},
};

/// Depth [m] from a file whose numbers are `unit_m` metres each.
pub(in crate::raw) fn decode(
    at: &str,
    bytes: &[u8],
    unit_m: f64,
    size: Size,
    budget: &mut Budget,
) -> Result<DepthImage, Error> {
    if bytes.starts_with(png::MAGIC) {
        return from_png(at, bytes, size, |n| f64::from(n) * unit_m);
    }
    let array: Array<'_> = npy::read(at, bytes)?;
    let &[height, width] = array.shape.as_slice() else {
        return Err(array.wrong_shape("[height, width]"));
    };
    alike(at, [width, height], size)?;
    let mut metres = array.scaled(unit_m, budget)?;
    for x in &mut metres {
        *x = measured(f64::from(*x));
    }
    settle(at, [width, height], metres, size)
}

/// Depth from a 16-bit PNG image; `metres` tells what its numbers mean.
pub(in crate::raw) fn from_png(
    at: &str,
    bytes: &[u8],
    size: Size,
    metres: impl Fn(u16) -> f64,
) -> Result<DepthImage, Error> {
    let samples = png::decode(at, bytes, true, |found| alike(at, found, size))?;
    if samples.channels != 1 || !samples.deep {
        let bits = if samples.deep { 16 } else { 8 };
        return Err(Error::Dtype {
            at: at.to_owned(),
            found: format!("{} channels of {bits} bits", samples.channels),
            needed: "one channel of 16 bits: depth is no picture of colours",
        });
    }
    let numbers = samples.data.as_chunks().0.iter().map(|b| u16::from_be_bytes(*b));
    settle(at, samples.size, numbers.map(|n| measured(metres(n))).collect(), size)
}

/// The distances [m] of an image of size `found` on the camera's grid.
pub(in crate::raw) fn settle(
    at: &str,
    found: Size,
    metres: Vec<f32>,
    size: Size,
) -> Result<DepthImage, Error> {
    let [width, height] = found;
    if metres.len() != width * height {
        return Err(damaged(at, "it holds another number of pixels than its header says"));
    }
    Ok(onto_grid(Image { width, height, pixels: metres }, size))
}

/// 0 for what is no distance.
pub(in crate::raw) fn measured(m: f64) -> f32 {
    if m.is_finite() && m > 0.0 { m as f32 } else { 0.0 }
}

/// Checks that one image shows the same section as another: only its resolution may be lower or
/// higher, by at most 8.
pub(in crate::raw) fn alike(at: &str, found: Size, needed: Size) -> Result<(), Error> {
    let [w, h] = found.map(|n| n as f64);
    let [width, height] = needed.map(|n| n as f64);
    // Within half a pixel of the coarser image in each direction.
    let same_section = (w * height - h * width).abs() <= 0.5 * width.max(w).max(height).max(h);
    let near = (width / 8.0..=width * 8.0).contains(&w);
    // An array may have no rows, and still be within half a pixel of a very flat image.
    let any = w > 0.0 && h > 0.0;
    if same_section && near && any {
        return Ok(());
    }
    Err(Error::ImageSize { at: at.to_owned(), found, needed })
}

/// The image on another grid by its nearest neighbours. Depth is not interpolated: between an edge
/// and what lies behind it there is nothing.
fn onto_grid(image: DepthImage, [width, height]: Size) -> DepthImage {
    if [image.width, image.height] == [width, height] {
        return image;
    }
    let column = |c: usize| ((2 * c + 1) * image.width / (2 * width)).min(image.width - 1);
    let columns: Vec<usize> = (0..width).map(column).collect();
    let mut pixels = Vec::with_capacity(width * height);
    for r in 0..height {
        let row = image.row(((2 * r + 1) * image.height / (2 * height)).min(image.height - 1));
        pixels.extend(columns.iter().map(|c| row[*c]));
    }
    Image { width, height, pixels }
}
