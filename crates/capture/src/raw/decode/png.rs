//! PNG.

use std::io::Cursor;

use png::{BitDepth, ColorType, Decoder, DecodingError, Limits, Reader, Transformations};

use super::{Samples, Size, damaged};
use crate::Error;

pub(super) const MAGIC: &[u8] = b"\x89PNG\r\n\x1a\n";

/// Memory that the decoder may take beside the pixels: rows, palettes, text.
const OVERHEAD: usize = 1 << 20;

type PngReader<'b> = Reader<Cursor<&'b [u8]>>;

/// Samples as stored, rows at whole bytes.
pub(super) struct Stored {
    pub(super) size: Size,
    pub(super) color: ColorType,
    /// Bits of a sample: 1, 2, 4, 8 or 16.
    pub(super) bits: usize,
    /// Red, green and blue of each index; empty without a palette.
    pub(super) palette: Vec<u8>,
    pub(super) data: Vec<u8>,
}

/// Refuses an image that is no depth by its header.
pub(super) fn expect_depth(at: &str, bytes: &[u8]) -> Result<(), Error> {
    let (Some(bits), Some(kind)) = (bytes.get(24), bytes.get(25)) else {
        return Err(damaged(at, "it ends within its header"));
    };
    // Gray, and no colours or palette.
    if (*bits, *kind) == (16, 0) {
        return Ok(());
    }
    let colors = if matches!(kind, 0 | 4) { "gray" } else { "colours" };
    let found = format!("{colors} of {bits} bits");
    Err(Error::Dtype { at: at.to_owned(), found, needed: super::depth::NEEDED })
}

/// Decodes what `check` accepts by its size. `deep` keeps samples of 16 bits, otherwise all become
/// 8 bits.
pub(in crate::raw) fn decode(
    at: &str,
    bytes: &[u8],
    deep: bool,
    check: impl FnOnce(Size) -> Result<(), Error>,
) -> Result<Samples, Error> {
    let wanted = if deep {
        Transformations::EXPAND
    } else {
        Transformations::EXPAND | Transformations::STRIP_16
    };
    let (size, mut reader) = open(at, bytes, wanted, check)?;
    let (color, depth, data) = pixels(at, &mut reader)?;
    let channels = match color {
        ColorType::Grayscale | ColorType::Indexed => 1,
        ColorType::GrayscaleAlpha => 2,
        ColorType::Rgb => 3,
        ColorType::Rgba => 4,
    };
    let samples = Samples { size, channels, deep: depth == BitDepth::Sixteen, data };
    let width = if samples.deep { 2 } else { 1 };
    if samples.data.len() != size[0] * size[1] * channels * width {
        return Err(damaged(at, "it holds another number of pixels than its header says"));
    }
    Ok(samples)
}

/// Decodes what `check` accepts by its size, without the colours of a palette.
pub(super) fn stored(
    at: &str,
    bytes: &[u8],
    check: impl FnOnce(Size) -> Result<(), Error>,
) -> Result<Stored, Error> {
    let (size, mut reader) = open(at, bytes, Transformations::IDENTITY, check)?;
    let palette = reader.info().palette.as_deref().unwrap_or_default().to_vec();
    let (color, depth, data) = pixels(at, &mut reader)?;
    let bits = depth as usize;
    let row = (size[0] * color.samples() * bits).div_ceil(8);
    if data.len() != row * size[1] {
        return Err(damaged(at, "it holds another number of pixels than its header says"));
    }
    Ok(Stored { size, color, bits, palette, data })
}

/// Reads the header, and sets the memory by what it says.
fn open<'b>(
    at: &str,
    bytes: &'b [u8],
    wanted: Transformations,
    check: impl FnOnce(Size) -> Result<(), Error>,
) -> Result<(Size, PngReader<'b>), Error> {
    let fail = |e: DecodingError| damaged(at, e.to_string());
    let mut decoder = Decoder::new_with_limits(Cursor::new(bytes), Limits { bytes: OVERHEAD });
    decoder.set_transformations(wanted);
    let header = decoder.read_header_info().map_err(fail)?;
    let size = [header.width as usize, header.height as usize];
    check(size)?;
    // Up to eight bytes a pixel, which `check` has found to be few enough; and a row or two more.
    let row = size[0].saturating_mul(32);
    decoder.set_limits(Limits {
        bytes: size[0].saturating_mul(size[1]).saturating_mul(8).saturating_add(row + OVERHEAD),
    });
    Ok((size, decoder.read_info().map_err(fail)?))
}

fn pixels(at: &str, reader: &mut PngReader<'_>) -> Result<(ColorType, BitDepth, Vec<u8>), Error> {
    let needed = reader.output_buffer_size().ok_or_else(|| damaged(at, "it is too large"))?;
    let mut data = vec![0; needed];
    let frame = reader.next_frame(&mut data).map_err(|e| damaged(at, e.to_string()))?;
    data.truncate(frame.buffer_size());
    Ok((frame.color_type, frame.bit_depth, data))
}
