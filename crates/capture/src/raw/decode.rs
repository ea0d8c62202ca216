//! Images of files into images in memory. Sizes are compared with the camera's before a pixel is
//! decoded.

mod depth;
mod jpeg;
mod labels;
pub(super) mod masks;
pub(super) mod orientation;
mod png;

pub(super) use self::depth::{
    DepthUnit, alike, decode as depth, form as depth_form, from_png as depth_png, measured,
    settle as settle_depth, unit_fault,
};
pub(crate) use self::labels::number as label_number;
pub(super) use self::labels::{labels, word as label_word};
use self::orientation::Orientation;
use super::{ColorImage, Image, Mask};
use crate::Error;

/// Columns and rows.
pub(super) type Size = [usize; 2];

/// What counts of colour images that declare an orientation.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum Turn {
    /// No image is known to declare one: an image that does is refused.
    #[default]
    Undeclared,
    /// The pixels as stored.
    Stored,
    /// The picture after the declared turn.
    Shown,
}

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
    color_turned(at, bytes, size, Turn::Stored)
}

/// Colour from a PNG or JPEG file that may declare an orientation; `size` is that after the turn.
pub(super) fn color_turned(
    at: &str,
    bytes: &[u8],
    size: Size,
    turn: Turn,
) -> Result<ColorImage, Error> {
    let declared = match turn {
        Turn::Stored => Orientation::NONE,
        Turn::Undeclared | Turn::Shown => orientation::of(bytes),
    };
    if turn == Turn::Undeclared && declared != Orientation::NONE {
        return Err(Error::Turned {
            at: at.to_owned(),
            turn: declared.words(),
            number: declared.number(),
        });
    }
    let samples = declared.turn(samples(at, bytes, declared.turned_size(size))?);
    let pixels = match samples.channels {
        3 => samples.data.as_chunks().0.to_vec(),
        4 => samples.data.as_chunks().0.iter().map(|[r, g, b, _]| [*r, *g, *b]).collect(),
        n => samples.data.chunks_exact(n.max(1)).map(|p| [p[0]; 3]).collect(),
    };
    Ok(Image { width: size[0], height: size[1], pixels })
}

/// A mask from a PNG or JPEG file: true where there is any label.
pub(super) fn mask(at: &str, bytes: &[u8], size: Size) -> Result<Mask, Error> {
    let Image { width, height, pixels } = labels(at, bytes, size)?;
    Ok(Image { width, height, pixels: pixels.into_iter().map(|label| label != 0).collect() })
}

/// Samples of one byte.
fn samples(at: &str, bytes: &[u8], size: Size) -> Result<Samples, Error> {
    let check = |found: Size| same_size(at, found, size);
    if bytes.starts_with(png::MAGIC) {
        png::decode(at, bytes, false, check)
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
