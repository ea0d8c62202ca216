//! Images of labels: a number for what each pixel shows.

use super::{Size, damaged, jpeg, png, same_size};
use crate::{Error, raw::Image};

/// Bit of labels that are colours.
const COLORED: u32 = 1 << 24;

/// Label of each pixel of a PNG or JPEG file; 0 is nothing. A label is a gray level, the index of a
/// palette that has colours, or a colour itself, and alpha is ignored. JPEG keeps no numbers: what
/// is brighter than half is one label.
pub(in crate::raw) fn labels(at: &str, bytes: &[u8], size: Size) -> Result<Image<u32>, Error> {
    let check = |found: Size| same_size(at, found, size);
    let pixels = if bytes.starts_with(png::MAGIC) {
        of_png(&png::stored(at, bytes, check)?)
    } else if bytes.starts_with(jpeg::MAGIC) {
        let samples = jpeg::decode(at, bytes, check)?;
        let is_bright = |p: &[u8]| p.iter().any(|level| *level >= 128);
        samples.data.chunks_exact(3).map(|p| if is_bright(p) { 255 } else { 0 }).collect()
    } else {
        return Err(damaged(at, "it is neither a PNG nor a JPEG image"));
    };
    Ok(Image { width: size[0], height: size[1], pixels })
}

/// The word for a label in documents: a number, or a colour as `#rrggbb`.
pub(in crate::raw) fn word(label: u32) -> String {
    if label & COLORED == 0 { label.to_string() } else { format!("#{:06x}", label & 0xff_ffff) }
}

/// The number of an integer as a label.
pub(crate) fn number(value: i64) -> u32 {
    value.clamp(0, i64::from(COLORED) - 1) as u32
}

fn of_png(stored: &png::Stored) -> Vec<u32> {
    let [width, height] = stored.size;
    let channels = stored.color.samples();
    let row_bytes = stored.data.len() / height.max(1);
    // A palette of grays only shortens their numbers.
    let (colors, _) = stored.palette.as_chunks::<3>();
    let is_gray = colors.iter().all(|[r, g, b]| r == g && g == b);
    let mut labels = Vec::with_capacity(width * height);
    for row in stored.data.chunks_exact(row_bytes.max(1)) {
        let sample = |index: usize| -> u32 {
            let at = |byte: usize| u32::from(row.get(byte).copied().unwrap_or(0));
            match stored.bits {
                16 => at(2 * index) << 8 | at(2 * index + 1),
                8 => at(index),
                bits => {
                    let first = index * bits;
                    at(first / 8) >> (8 - bits - first % 8) & ((1 << bits) - 1)
                }
            }
        };
        labels.extend((0..width).map(|column| match channels {
            1 => {
                let level = sample(column);
                let gray = colors.get(level as usize).filter(|_| is_gray);
                gray.map_or(level, |[gray, ..]| u32::from(*gray))
            }
            2 => sample(2 * column),
            _ => {
                let [r, g, b] = [0, 1, 2].map(|i| sample(channels * column + i));
                let byte = |level: u32| if stored.bits == 16 { level >> 8 } else { level };
                if r == g && g == b { r } else { COLORED | byte(r) << 16 | byte(g) << 8 | byte(b) }
            }
        }));
    }
    labels
}
