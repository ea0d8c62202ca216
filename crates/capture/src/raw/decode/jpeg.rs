//! JPEG.

use zune_jpeg::{
    JpegDecoder,
    zune_core::{bytestream::ZCursor, colorspace::ColorSpace, options::DecoderOptions},
};

use super::{Samples, Size, damaged};
use crate::Error;

pub(super) const MAGIC: &[u8] = b"\xff\xd8\xff";

/// Decodes what `check` accepts by its size.
pub(super) fn decode(
    at: &str,
    bytes: &[u8],
    check: impl FnOnce(Size) -> Result<(), Error>,
) -> Result<Samples, Error> {
    let fail = |e: zune_jpeg::errors::DecodeErrors| damaged(at, format!("{e:?}"));
    // Strict: a picture that is cut off is refused, not filled up with gray.
    let options =
        DecoderOptions::default().set_strict_mode(true).jpeg_set_out_colorspace(ColorSpace::RGB);
    let mut decoder = JpegDecoder::new_with_options(ZCursor::new(bytes), options);
    decoder.decode_headers().map_err(fail)?;
    let info = decoder.info().ok_or_else(|| damaged(at, "it has no header"))?;
    let size = [usize::from(info.width), usize::from(info.height)];
    check(size)?;
    let data = decoder.decode().map_err(fail)?;
    if data.len() != size[0] * size[1] * 3 {
        return Err(damaged(at, "it holds another number of pixels than its header says"));
    }
    Ok(Samples { size, channels: 3, deep: false, data })
}
