//! Images as PNG, for writers.

use super::{ColorImage, DepthImage, Mask};
use crate::Error;

pub(super) fn color(image: &ColorImage) -> Result<Vec<u8>, Error> {
    encode(
        [image.width, image.height],
        png::ColorType::Rgb,
        png::BitDepth::Eight,
        image.pixels.as_flattened(),
    )
}

/// White where the mask shows something.
pub(super) fn mask(image: &Mask) -> Result<Vec<u8>, Error> {
    let bytes: Vec<u8> = image.pixels.iter().map(|shown| if *shown { 255 } else { 0 }).collect();
    encode([image.width, image.height], png::ColorType::Grayscale, png::BitDepth::Eight, &bytes)
}

/// Depth in steps of `unit_m`, rounded; 0 where nothing was measured and beyond 65,535 steps.
pub(super) fn steps(image: &DepthImage, unit_m: f64) -> impl Iterator<Item = u16> {
    image.pixels.iter().map(move |m| {
        let steps = (f64::from(*m) / unit_m).round();
        if steps > 0.0 && steps <= f64::from(u16::MAX) { steps as u16 } else { 0 }
    })
}

/// Depth as 16 bits in steps of `unit_m`.
pub(super) fn depth(image: &DepthImage, unit_m: f64) -> Result<Vec<u8>, Error> {
    let bytes: Vec<u8> = steps(image, unit_m).flat_map(u16::to_be_bytes).collect();
    encode([image.width, image.height], png::ColorType::Grayscale, png::BitDepth::Sixteen, &bytes)
}

/// Red, green, blue and opacity, row by row.
pub(super) fn transparent(size: [usize; 2], pixels: &[[u8; 4]]) -> Result<Vec<u8>, Error> {
    encode(size, png::ColorType::Rgba, png::BitDepth::Eight, pixels.as_flattened())
}

fn encode(
    [width, height]: [usize; 2],
    color: png::ColorType,
    depth: png::BitDepth,
    bytes: &[u8],
) -> Result<Vec<u8>, Error> {
    let fail = |e: png::EncodingError| Error::Io {
        at: "an image".to_owned(),
        source: std::io::Error::other(e),
    };
    let side = |n: usize| u32::try_from(n).unwrap_or(0);
    let mut out = Vec::new();
    let mut encoder = png::Encoder::new(&mut out, side(width), side(height));
    encoder.set_color(color);
    encoder.set_depth(depth);
    encoder.set_compression(png::Compression::Fast);
    let mut writer = encoder.write_header().map_err(fail)?;
    writer.write_image_data(bytes).map_err(fail)?;
    writer.finish().map_err(fail)?;
    Ok(out)
}
