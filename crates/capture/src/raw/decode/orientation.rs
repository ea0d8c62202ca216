//! EXIF orientation of JPEG and PNG images: how a picture is to be turned before it is shown. The
//! pixels of a file are what the sensor saw; whether depth, masks and intrinsics belong to these or to
//! the turned picture depends on the program that made them.

use super::{Samples, Size, jpeg, png};

/// Number of EXIF's tag in the first directory of its TIFF data.
const TAG: u16 = 0x0112;

/// Bytes of a JPEG file in which its EXIF data are looked for.
const JPEG_HEAD: usize = 256 << 10;

/// The turn that a picture needs to be shown: EXIF's values 1 to 8.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(in crate::raw) struct Orientation(u8);

impl Orientation {
    /// No turn.
    pub(in crate::raw) const NONE: Self = Self(1);

    /// EXIF's number.
    pub(in crate::raw) fn number(self) -> u8 {
        self.0.max(1)
    }

    /// `true` if rows become columns.
    pub(in crate::raw) fn is_transposed(self) -> bool {
        self.0 >= 5
    }

    /// The turn in words.
    pub(in crate::raw) fn words(self) -> &'static str {
        match self.0 {
            2 => "mirrored left to right",
            3 => "turned by 180 degrees",
            4 => "mirrored top to bottom",
            5 => "transposed",
            6 => "turned by 90 degrees clockwise",
            7 => "transposed about the other diagonal",
            8 => "turned by 90 degrees anticlockwise",
            _ => "as stored",
        }
    }

    /// Columns and rows of a stored image after the turn.
    pub(in crate::raw) fn turned_size(self, [width, height]: Size) -> Size {
        if self.is_transposed() { [height, width] } else { [width, height] }
    }

    /// Column and row of the stored image, of size `stored`, that the turned picture shows at a pixel.
    fn source(self, [column, row]: [usize; 2], [width, height]: Size) -> [usize; 2] {
        let (right, bottom) = (width - 1, height - 1);
        match self.0 {
            2 => [right - column, row],
            3 => [right - column, bottom - row],
            4 => [column, bottom - row],
            5 => [row, column],
            6 => [row, bottom - column],
            7 => [right - row, bottom - column],
            8 => [right - row, column],
            _ => [column, row],
        }
    }

    /// The picture after the turn.
    pub(super) fn turn(self, samples: Samples) -> Samples {
        if self.number() == 1 {
            return samples;
        }
        let size = self.turned_size(samples.size);
        let bytes = samples.channels * if samples.deep { 2 } else { 1 };
        let mut data = Vec::with_capacity(samples.data.len());
        for row in 0..size[1] {
            for column in 0..size[0] {
                let [c, r] = self.source([column, row], samples.size);
                let at = (r * samples.size[0] + c) * bytes;
                data.extend_from_slice(samples.data.get(at..at + bytes).unwrap_or_default());
            }
        }
        Samples { size, data, ..samples }
    }
}

/// Columns, rows and orientation of an image file; `None` if it is neither PNG nor JPEG, or damaged
/// before its size.
pub(in crate::raw) fn peek(bytes: &[u8]) -> Option<(Size, Orientation)> {
    if bytes.starts_with(png::MAGIC) {
        let side = |at: usize| {
            let bytes = bytes.get(at..at + 4)?.try_into().ok()?;
            usize::try_from(u32::from_be_bytes(bytes)).ok()
        };
        return Some(([side(16)?, side(20)?], of(bytes)));
    }
    let segments = Segments(bytes.strip_prefix(&jpeg::MAGIC[..2])?);
    let is_frame =
        |marker: u8| (0xC0..=0xCF).contains(&marker) && ![0xC4, 0xC8, 0xCC].contains(&marker);
    let (_, frame) = segments.into_iter().find(|(marker, _)| is_frame(*marker))?;
    let side =
        |at: usize| Some(usize::from(u16::from_be_bytes(frame.get(at..at + 2)?.try_into().ok()?)));
    Some(([side(3)?, side(1)?], of(bytes)))
}

/// Orientation that an image file declares; none if it declares none, or a value that does not exist.
pub(in crate::raw) fn of(bytes: &[u8]) -> Orientation {
    let tiff = if bytes.starts_with(png::MAGIC) {
        exif_of_png(bytes)
    } else {
        let body = bytes.get(..JPEG_HEAD.min(bytes.len())).unwrap_or_default();
        let segments = body.strip_prefix(&jpeg::MAGIC[..2]).map(Segments);
        let mut segments = segments.into_iter().flatten();
        segments.find_map(|(marker, data)| {
            (marker == 0xE1).then(|| data.strip_prefix(b"Exif\0\0")).flatten()
        })
    };
    tiff.and_then(of_tiff).unwrap_or(Orientation::NONE)
}

/// The `eXIf` chunk, which stands before or after the pixels.
fn exif_of_png(bytes: &[u8]) -> Option<&[u8]> {
    let mut rest = bytes.get(png::MAGIC.len()..)?;
    while let Some((head, after)) = rest.split_first_chunk::<8>() {
        let [a, b, c, d, kind @ ..] = *head;
        let length = usize::try_from(u32::from_be_bytes([a, b, c, d])).ok()?;
        let (data, after) = after.split_at_checked(length)?;
        match &kind {
            b"eXIf" => return Some(data.strip_prefix(b"Exif\0\0").unwrap_or(data)),
            b"IEND" => return None,
            _ => rest = after.get(4..)?,
        }
    }
    None
}

/// Orientation in TIFF data.
fn of_tiff(tiff: &[u8]) -> Option<Orientation> {
    let little = match tiff.get(..4)? {
        b"II\x2a\0" => true,
        b"MM\0\x2a" => false,
        _ => return None,
    };
    let short = |at: usize| {
        let bytes = tiff.get(at..at.checked_add(2)?)?.try_into().ok()?;
        Some(if little { u16::from_le_bytes(bytes) } else { u16::from_be_bytes(bytes) })
    };
    let long = |at: usize| {
        let bytes = tiff.get(at..at.checked_add(4)?)?.try_into().ok()?;
        usize::try_from(if little { u32::from_le_bytes(bytes) } else { u32::from_be_bytes(bytes) })
            .ok()
    };
    let directory = long(4)?;
    let entries = usize::from(short(directory)?);
    let entry = |index: usize| directory.checked_add(2 + 12 * index);
    let at = (0..entries).map_while(entry).find(|at| short(*at) == Some(TAG))?;
    // A SHORT, or as some programs write it a LONG.
    let value = match short(at.checked_add(2)?)? {
        3 => usize::from(short(at.checked_add(8)?)?),
        4 => long(at.checked_add(8)?)?,
        _ => return None,
    };
    u8::try_from(value).ok().filter(|v| (1..=8).contains(v)).map(Orientation)
}

/// Segments of a JPEG file after its first two bytes, up to its pixels: markers and contents.
struct Segments<'a>(&'a [u8]);

impl<'a> Iterator for Segments<'a> {
    type Item = (u8, &'a [u8]);

    fn next(&mut self) -> Option<Self::Item> {
        let mut rest = self.0.strip_prefix(b"\xff")?;
        // Bytes of 255 may fill up before a marker.
        while let Some(after) = rest.strip_prefix(b"\xff") {
            rest = after;
        }
        let (&marker, rest) = rest.split_first()?;
        // The pixels begin.
        if marker == 0xDA || marker == 0xD9 {
            return None;
        }
        let length = usize::from(u16::from_be_bytes(*rest.first_chunk()?));
        let (segment, rest) = rest.split_at_checked(length.max(2))?;
        self.0 = rest;
        Some((marker, segment.get(2..)?))
    }
}

#[cfg(test)]
mod tests;
