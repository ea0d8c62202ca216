//! Pixels of messages into images.

mod raw;
mod rvl;

use super::{
    encodings::{self, Pixels},
    messages::{ImageData, Layout},
};
use crate::{
    Error,
    files::at_most,
    raw::{
        ColorImage, DepthImage, Image, Mask,
        decode::{self, Size},
    },
};

/// Most pixels of a depth image of run lengths: a few bytes may announce any number.
const MAX_PIXELS: usize = 1 << 25;
/// ROS's convention for 16-bit depth.
const MILLIMETRE: f64 = 0.001;

pub(super) fn color(at: &str, image: &ImageData<'_>, size: Size) -> Result<ColorImage, Error> {
    let Some(layout) = image.layout else { return compressed_color(at, image, size) };
    let Some(kind) = encodings::pixels(&image.encoding) else {
        return Err(unknown(
            at,
            &image.encoding,
            "colour as docs/formats/capture.md, section 8, lists it",
        ));
    };
    same_size(at, &layout, size)?;
    let extent = raw::extent(kind, size)
        .ok_or_else(|| unknown(at, &image.encoding, "an even number of columns and rows"))?;
    let rows: Vec<&[u8]> = rows(at, &layout, image.data, extent)?.collect();
    let pixels = raw::colors(kind, size, &rows, layout.big_endian);
    Ok(Image { width: size[0], height: size[1], pixels })
}

/// A JPEG or PNG file; one that still has the pattern of its sensor is converted.
fn compressed_color(at: &str, image: &ImageData<'_>, size: Size) -> Result<ColorImage, Error> {
    let mut color = decode::color(at, image.data, size)?;
    if let Some(Pixels::Bayer { pattern, .. }) = encodings::compressed_bayer(&image.encoding) {
        let mut pixels = Vec::with_capacity(color.pixels.len());
        let sample = |c: usize, r: usize| color.pixels.get(r * size[0] + c).map(|p| &p[0]);
        raw::demosaic(pattern, size, sample, &mut pixels);
        color.pixels = pixels;
    }
    Ok(color)
}

/// Columns and rows of an image, without decoding it; `None` if it is damaged.
pub(super) fn size_of(image: &ImageData<'_>) -> Option<Size> {
    match image.layout {
        Some(layout) => Some([layout.width, layout.height]),
        None => decode::size_of(image.data),
    }
}

/// A mask: true where any sample but alpha is not zero.
pub(super) fn mask(at: &str, image: &ImageData<'_>, size: Size) -> Result<Mask, Error> {
    let Some(layout) = image.layout else { return decode::mask(at, image.data, size) };
    let kind = match image.encoding.as_str() {
        "16UC1" => encodings::pixels("mono16"),
        other => encodings::pixels(other),
    };
    let Some(kind @ Pixels::Samples { count, deep, .. }) = kind else {
        return Err(unknown(at, &image.encoding, "mono8, 8UC1, mono16, 16UC1 or a colour as rgb8"));
    };
    same_size(at, &layout, size)?;
    let extent = raw::extent(kind, size).unwrap_or_default();
    let width = if deep { 2 } else { 1 };
    let rows = rows(at, &layout, image.data, extent)?;
    let pixels = rows.flat_map(|row| row.chunks_exact(width * count));
    let shown = width * count.min(3);
    let pixels = pixels.map(|p| p.iter().take(shown).any(|x| *x != 0)).collect();
    Ok(Image { width: size[0], height: size[1], pixels })
}

/// Depth [m]; each 1 is `unit_m` metres or, if that is not given, a millimetre of integers and a
/// metre of floats.
pub(super) fn depth(
    at: &str,
    image: &ImageData<'_>,
    size: Size,
    unit_m: Option<f64>,
) -> Result<DepthImage, Error> {
    let Some(layout) = image.layout else { return compressed_depth(at, image, size, unit_m) };
    let found = [layout.width, layout.height];
    decode::alike(at, found, size)?;
    let metres: Vec<f32> = match image.encoding.as_str() {
        "16UC1" | "mono16" => {
            let unit_m = unit_m.unwrap_or(MILLIMETRE);
            let number = if layout.big_endian { u16::from_be_bytes } else { u16::from_le_bytes };
            rows(at, &layout, image.data, [layout.width.saturating_mul(2), layout.height])?
                .flat_map(|row| row.as_chunks().0)
                .map(|b| decode::measured(f64::from(number(*b)) * unit_m))
                .collect()
        }
        "32FC1" => {
            let unit_m = unit_m.unwrap_or(1.0);
            let number = if layout.big_endian { f32::from_be_bytes } else { f32::from_le_bytes };
            rows(at, &layout, image.data, [layout.width.saturating_mul(4), layout.height])?
                .flat_map(|row| row.as_chunks().0)
                .map(|b| decode::measured(f64::from(number(*b)) * unit_m))
                .collect()
        }
        other => return Err(unknown(at, other, "16UC1 in millimetres or 32FC1 in metres")),
    };
    decode::settle_depth(at, found, metres, size)
}

/// A PNG of millimetres; or what ROS's `compressed_depth_image_transport` makes: twelve bytes, then
/// a PNG or an image in RVL, of millimetres or of inverse depth.
fn compressed_depth(
    at: &str,
    image: &ImageData<'_>,
    size: Size,
    unit_m: Option<f64>,
) -> Result<DepthImage, Error> {
    const PNG: &[u8] = b"\x89PNG";
    let integer_m = unit_m.unwrap_or(MILLIMETRE);
    if image.data.starts_with(PNG) {
        return decode::depth_png(at, image.data, size, |n| f64::from(n) * integer_m);
    }
    let Some((head, file)) = image
        .data
        .split_first_chunk::<12>()
        .filter(|_| encodings::is_compressed_depth(&image.encoding))
    else {
        return Err(unknown(at, &image.encoding, "PNG, by itself or as compressedDepth, or RVL"));
    };
    let number = |from: usize| -> f64 {
        let bytes = head.get(from..from + 4).and_then(|b| b.try_into().ok()).unwrap_or([0; 4]);
        f64::from(f32::from_le_bytes(bytes))
    };
    // Depth is a / (n - b); 0 stands for nothing.
    let (a, b) = (number(4), number(8));
    let is_float = image.encoding.starts_with("32FC1");
    let metres = |n: u16| match (is_float, n) {
        (_, 0) => 0.0,
        (true, n) => a / (f64::from(n) - b) * unit_m.unwrap_or(1.0),
        (false, n) => f64::from(n) * integer_m,
    };
    if file.starts_with(PNG) {
        return decode::depth_png(at, file, size, metres);
    }
    let damaged = |fault: &str| Error::Damaged { at: at.to_owned(), fault: fault.to_owned() };
    let Some((found, data)) = file.split_first_chunk::<8>() else {
        return Err(damaged("its compressed depth has no size"));
    };
    let side = |from: usize| {
        let bytes = found.get(from..from + 4).and_then(|b| b.try_into().ok()).unwrap_or([0; 4]);
        u32::from_le_bytes(bytes) as usize
    };
    let found = [side(0), side(4)];
    decode::alike(at, found, size)?;
    let count = found[0].saturating_mul(found[1]);
    at_most("pixels of a depth image", count, MAX_PIXELS)?;
    let numbers = rvl::decode(data, count).ok_or_else(|| {
        damaged("its compressed depth (RVL) does not have as many pixels as it says")
    })?;
    let metres = numbers.into_iter().map(|n| decode::measured(metres(n))).collect();
    decode::settle_depth(at, found, metres, size)
}

/// Rows of an image that has `row` bytes in each of `count` rows.
fn rows<'a>(
    at: &str,
    layout: &Layout,
    data: &'a [u8],
    [row, count]: [usize; 2],
) -> Result<impl Iterator<Item = &'a [u8]>, Error> {
    let step = layout.step;
    let before = count.checked_sub(1).and_then(|rows| rows.checked_mul(step));
    let needed = before.and_then(|rows| rows.checked_add(row));
    match needed {
        Some(needed) if row > 0 && step >= row && needed <= data.len() => {
            Ok((0..count).filter_map(move |r| data.get(r * step..r * step + row)))
        }
        _ => Err(Error::Absurd {
            at: at.to_owned(),
            claimed: needed.map_or(u64::MAX, |n| n as u64),
            present: data.len() as u64,
        }),
    }
}

fn same_size(at: &str, layout: &Layout, needed: Size) -> Result<(), Error> {
    let found = [layout.width, layout.height];
    if found == needed {
        return Ok(());
    }
    Err(Error::ImageSize { at: at.to_owned(), found, needed })
}

fn unknown(at: &str, encoding: &str, needed: &'static str) -> Error {
    let found = format!("`{}`", encoding.chars().take(40).collect::<String>());
    Error::Dtype { at: at.to_owned(), found, needed }
}
