//! Images of files into images in memory. Sizes are compared with the camera's before a pixel is
//! decoded.

mod depth;
mod jpeg;
mod png;

pub(super) use self::depth::{
    DepthUnit, alike, decode as depth, from_png as depth_png, measured, settle as settle_depth,
};
use super::{ColorImage, Image, Mask};
use crate::Error;

/// Columns and rows.
pub(super) type Size = [usize; 2];

/// Samples of an image of any number of channels.
pub(super) struct Samples {
    pub(super) size: Size,
    /// 1 gray, 2 gray and alpha, 3 colour, 4 colour and alpha.
    pub(super) channels: usize,
    /// Two bytes a sample, the higher one first, instead of one.
    pub(super) deep: bool,
    pub(super) data: Vec<u8>,
}

/// Colour from a PNG or JPEG file, recognized by its content.
pub(super) fn color(at: &str, bytes: &[u8], size: Size) -> Result<ColorImage, Error> {
    let samples = samples(at, bytes, false, size)?;
    let pixels = match samples.channels {
        3 => samples.data.as_chunks().0.to_vec(),
        4 => samples.data.as_chunks().0.iter().map(|[r, g, b, _]| [*r, *g, *b]).collect(),
        n => samples.data.chunks_exact(n.max(1)).map(|p| [p[0]; 3]).collect(),
    };
    Ok(Image { width: size[0], height: size[1], pixels })
}

/// A mask from a PNG file: true where any channel but alpha is not zero.
pub(super) fn mask(at: &str, bytes: &[u8], size: Size) -> Result<Mask, Error> {
    // In 16 bits a mask may have values whose higher byte is 0.
    let samples = samples(at, bytes, true, size)?;
    let channels = samples.channels.max(1);
    let width = if samples.deep { 2 } else { 1 };
    let shown = width * if channels > 2 { 3 } else { 1 };
    let pixels = samples.data.chunks_exact(width * channels);
    let pixels = pixels.map(|p| p.iter().take(shown).any(|x| *x != 0));
    Ok(Image { width: size[0], height: size[1], pixels: pixels.collect() })
}

/// Samples of one byte, or unchanged ones if `deep`.
fn samples(at: &str, bytes: &[u8], deep: bool, size: Size) -> Result<Samples, Error> {
    let check = |found: Size| same_size(at, found, size);
    if bytes.starts_with(png::MAGIC) {
        png::decode(at, bytes, deep, check)
    } else if bytes.starts_with(jpeg::MAGIC) {
        jpeg::decode(at, bytes, check)
    } else {
        Err(damaged(at, "it is neither a PNG nor a JPEG image"))
    }
}

/// Columns and rows of a PNG or JPEG file, without decoding it; `None` if it is damaged.
pub(super) fn size_of(bytes: &[u8]) -> Option<Size> {
    let mut size = None;
    let stop = |found| {
        size = Some(found);
        Err(damaged("", ""))
    };
    if bytes.starts_with(png::MAGIC) {
        let _stopped = png::decode("", bytes, false, stop);
    } else if bytes.starts_with(jpeg::MAGIC) {
        let _stopped = jpeg::decode("", bytes, stop);
    }
    size
}

fn same_size(at: &str, found: Size, needed: Size) -> Result<(), Error> {
    if found == needed {
        return Ok(());
    }
    Err(Error::ImageSize { at: at.to_owned(), found, needed })
}

fn damaged(at: &str, fault: impl Into<String>) -> Error {
    Error::Damaged { at: at.to_owned(), fault: fault.into() }
}

#[cfg(test)]
mod tests;
