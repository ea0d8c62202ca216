//! Pixels of messages into images.

use super::messages::{ImageData, Layout};
use crate::{
    Error,
    raw::{
        ColorImage, DepthImage, Image, Mask,
        decode::{self, Size},
    },
};

/// ROS's convention for 16-bit depth.
const MILLIMETRE: f64 = 0.001;

/// Content of a topic's images according to their encoding.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Shows {
    Color,
    Depth,
    /// Infrared or something else that is neither.
    Other,
}

/// Content of images of an encoding on a topic.
pub(super) fn shows(encoding: &str, topic: &str) -> Shows {
    let mut words = encoding.split([';', ' ']).filter(|word| !word.is_empty());
    let first = words.next().unwrap_or_default();
    match first {
        "16UC1" | "mono16" | "32FC1" => Shows::Depth,
        "mono8" | "8UC1" => Shows::Other,
        "rgb8" | "bgr8" | "rgba8" | "bgra8" | "8UC3" | "8UC4" | "jpeg" | "jpg" => Shows::Color,
        // A PNG image by itself may be either.
        "png" if topic.contains("depth") => Shows::Depth,
        "png" => Shows::Color,
        _ => Shows::Other,
    }
}

pub(super) fn color(at: &str, image: &ImageData<'_>, size: Size) -> Result<ColorImage, Error> {
    let Some(layout) = image.layout else { return decode::color(at, image.data, size) };
    let (channels, order) = match image.encoding.as_str() {
        "rgb8" => (3, [0, 1, 2]),
        "bgr8" | "8UC3" => (3, [2, 1, 0]),
        "rgba8" => (4, [0, 1, 2]),
        "bgra8" | "8UC4" => (4, [2, 1, 0]),
        "mono8" | "8UC1" => (1, [0, 0, 0]),
        other => {
            return Err(unknown(at, other, "rgb8, bgr8, rgba8, bgra8 or mono8, JPEG or PNG"));
        }
    };
    same_size(at, &layout, size)?;
    let mut pixels = Vec::with_capacity(size[0] * size[1]);
    for row in rows(at, &layout, image.data, channels)? {
        pixels.extend(row.chunks_exact(channels).map(|p| order.map(|channel| p[channel])));
    }
    Ok(Image { width: size[0], height: size[1], pixels })
}

pub(super) fn mask(at: &str, image: &ImageData<'_>, size: Size) -> Result<Mask, Error> {
    if image.layout.is_none() {
        return decode::mask(at, image.data, size);
    }
    let color = color(at, image, size)?;
    let pixels = color.pixels.iter().map(|p| *p != [0; 3]).collect();
    Ok(Image { width: size[0], height: size[1], pixels })
}

pub(super) fn depth(at: &str, image: &ImageData<'_>, size: Size) -> Result<DepthImage, Error> {
    let Some(layout) = image.layout else { return compressed_depth(at, image, size) };
    let found = [layout.width, layout.height];
    decode::alike(at, found, size)?;
    let metres: Vec<f32> = match image.encoding.as_str() {
        "16UC1" | "mono16" => {
            let number = if layout.big_endian { u16::from_be_bytes } else { u16::from_le_bytes };
            rows(at, &layout, image.data, 2)?
                .flat_map(|row| row.as_chunks().0)
                .map(|b| decode::measured(f64::from(number(*b)) * MILLIMETRE))
                .collect()
        }
        "32FC1" => {
            let number = if layout.big_endian { f32::from_be_bytes } else { f32::from_le_bytes };
            rows(at, &layout, image.data, 4)?
                .flat_map(|row| row.as_chunks().0)
                .map(|b| decode::measured(f64::from(number(*b))))
                .collect()
        }
        other => return Err(unknown(at, other, "16UC1 in millimetres or 32FC1 in metres")),
    };
    decode::settle_depth(at, found, metres, size)
}

/// A PNG of millimetres; or what ROS's `compressed_depth_image_transport` makes: twelve bytes, then
/// a PNG, of millimetres or of inverse depth.
fn compressed_depth(at: &str, image: &ImageData<'_>, size: Size) -> Result<DepthImage, Error> {
    const PNG: &[u8] = b"\x89PNG";
    if image.data.starts_with(PNG) {
        return decode::depth_png(at, image.data, size, |n| f64::from(n) * MILLIMETRE);
    }
    let transported = image.data.split_first_chunk::<12>().filter(|(_, png)| png.starts_with(PNG));
    let Some((head, png)) = transported else {
        return Err(unknown(at, &image.encoding, "PNG, by itself or as compressedDepth (not RVL)"));
    };
    if !image.encoding.starts_with("32FC1") {
        return decode::depth_png(at, png, size, |n| f64::from(n) * MILLIMETRE);
    }
    let number = |from: usize| -> f64 {
        let bytes = head.get(from..from + 4).and_then(|b| b.try_into().ok()).unwrap_or([0; 4]);
        f64::from(f32::from_le_bytes(bytes))
    };
    // Depth is a / (n - b); 0 stands for nothing.
    let (a, b) = (number(4), number(8));
    decode::depth_png(at, png, size, |n| if n == 0 { 0.0 } else { a / (f64::from(n) - b) })
}

fn rows<'a>(
    at: &str,
    layout: &Layout,
    data: &'a [u8],
    pixel: usize,
) -> Result<impl Iterator<Item = &'a [u8]>, Error> {
    let row = layout.width.checked_mul(pixel);
    let needed = layout
        .height
        .checked_sub(1)
        .and_then(|rows| rows.checked_mul(layout.step))
        .zip(row)
        .and_then(|(rows, row)| rows.checked_add(row));
    match (row, needed) {
        (Some(row), Some(needed)) if row > 0 && layout.step >= row && needed <= data.len() => {
            let step = layout.step;
            Ok((0..layout.height).filter_map(move |r| data.get(r * step..r * step + row)))
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
