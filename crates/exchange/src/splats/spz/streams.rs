//! Version 4: a plain header of 32 bytes, records of extensions, a table of the streams' lengths, and
//! the streams.

use ruzstd::decoding::StreamingDecoder;

use super::{Packed, USUAL_AXES, numbers, take, word};
use crate::splats::Error;

const VERSION: u32 = 4;
const HEADER: usize = 32;
/// Flag of files that have extensions.
const EXTENDED: u8 = 2;
/// Extension that names the axes of the file.
const AXES: u32 = 0xADBE_0003;
/// Bytes of a rotation.
const ROTATION_BYTES: usize = 4;
/// Bytes of a stream's entry in the table: its length, and that of what it unpacks to.
const ENTRY: usize = 16;
/// Window of Zstandard that every decoder has to support (RFC 8878).
const MOST_WINDOW: u64 = 8 << 20;

pub(super) fn read(content: &[u8]) -> Result<Packed, Error> {
    let damaged = |text: &str| Error::Damaged(text.to_owned());
    let version = word(content, 4);
    if version != VERSION {
        return Err(Error::Unsupported(format!(".spz version {version}")));
    }
    let header = content.get(..HEADER).ok_or_else(|| damaged("it ends within its header"))?;
    let (count, degree, fractional_bits) = numbers(header)?;
    let (flags, stream_count) = (header[14], usize::from(header[15]));
    let table = usize::try_from(word(header, 16)).unwrap_or(usize::MAX);
    let before = content.get(HEADER..table).ok_or_else(|| damaged("its table lies nowhere"))?;
    let axes = if flags & EXTENDED == 0 { USUAL_AXES } else { axes(before)? };
    let mut rest = content.get(table + ENTRY * stream_count..);
    let harmonics = (degree + 1).pow(2) - 1;
    // Streams of nothing are left out.
    let sizes = [9, 1, 3, 3, ROTATION_BYTES, 3 * harmonics].map(|bytes| bytes * count);
    if sizes.iter().filter(|size| **size > 0).count() != stream_count {
        return Err(Error::Damaged(format!("it has {stream_count} streams")));
    }
    let mut entries = content[table..].chunks_exact(ENTRY);
    let mut next = |size: usize| {
        if size == 0 {
            return Ok(&[][..]);
        }
        let entry = entries.next().unwrap_or_default();
        let long = |at: usize| u64::from(word(entry, at)) | u64::from(word(entry, at + 4)) << 32;
        let packed = usize::try_from(long(0)).unwrap_or(usize::MAX);
        let (stream, after) = rest
            .and_then(|bytes| bytes.split_at_checked(packed))
            .ok_or_else(|| damaged("a stream of it is cut off"))?;
        rest = Some(after);
        if long(8) != size as u64 {
            return Err(damaged("a stream of it has another length than its Gaussians"));
        }
        Ok(stream)
    };
    let [positions, opacities, colors, scales, rotations, harmonics] = sizes;
    let packed = Packed {
        fractional_bits,
        degree,
        axes,
        positions: unpacked(next(positions)?, positions)?,
        opacities: unpacked(next(opacities)?, opacities)?,
        colors: unpacked(next(colors)?, colors)?,
        scales: unpacked(next(scales)?, scales)?,
        rotations: unpacked(next(rotations)?, rotations)?,
        rotation_bytes: ROTATION_BYTES,
    };
    // They are not needed, but a file without their end was cut off.
    next(harmonics)?;
    Ok(packed)
}

/// The content of a stream that unpacks to `size` bytes.
fn unpacked(stream: &[u8], size: usize) -> Result<Vec<u8>, Error> {
    if size == 0 {
        return Ok(Vec::new());
    }
    let window = (size as u64).max(MOST_WINDOW);
    let mut decoder = StreamingDecoder::new_with_max_window_size(stream, window)
        .map_err(|e| Error::Damaged(e.to_string()))?;
    take(&mut decoder, size)
}

/// Directions of the axes by the extension that names them.
fn axes(mut records: &[u8]) -> Result<[f32; 3], Error> {
    while let Some((head, rest)) = records.split_first_chunk::<8>() {
        let length = usize::try_from(word(head, 4)).unwrap_or(usize::MAX);
        let Some((payload, after)) = rest.split_at_checked(length) else {
            return Err(Error::Damaged("an extension of it is cut off".to_owned()));
        };
        if word(head, 0) == AXES {
            // Left or right; down or up; back or forward: eight systems, counted from 1.
            let system = word(payload, 0).wrapping_sub(1);
            if payload.len() < 4 || system >= 8 {
                return Err(Error::Unsupported("axes that are exchanged".to_owned()));
            }
            let right = if system & 1 == 1 { 1.0 } else { -1.0 };
            let down = if system & 2 == 0 { 1.0 } else { -1.0 };
            let forward = if system & 4 == 4 { 1.0 } else { -1.0 };
            return Ok([right, down, forward]);
        }
        records = after;
    }
    Ok(USUAL_AXES)
}
