//! The text before a PLY file's numbers: how they are written, and in which order.

use super::damaged;
use crate::Error;

/// More than any header with sane comments.
const MAX_BYTES: usize = 64 << 10;

#[derive(Debug)]
pub(super) struct Header {
    pub(super) encoding: Encoding,
    pub(super) elements: Vec<Element>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Encoding {
    Ascii,
    Little,
    Big,
}

#[derive(Debug)]
pub(super) struct Element {
    pub(super) name: String,
    pub(super) count: usize,
    pub(super) properties: Vec<Property>,
}

#[derive(Debug)]
pub(super) struct Property {
    pub(super) name: String,
    pub(super) scalar: Scalar,
    /// The type of a list's length; `None` for a single value.
    pub(super) length: Option<Scalar>,
}

#[derive(Clone, Copy, Debug)]
pub(super) enum Scalar {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl Scalar {
    fn from_name(name: &str) -> Option<Self> {
        Some(match name {
            "char" | "int8" => Self::I8,
            "uchar" | "uint8" => Self::U8,
            "short" | "int16" => Self::I16,
            "ushort" | "uint16" => Self::U16,
            "int" | "int32" => Self::I32,
            "uint" | "uint32" => Self::U32,
            "float" | "float32" => Self::F32,
            "double" | "float64" => Self::F64,
            _ => return None,
        })
    }

    /// In bytes.
    pub(super) fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }

    /// The value in the first [`Scalar::size`] bytes, lowest first.
    pub(super) fn little(self, b: [u8; 8]) -> f64 {
        let four = [b[0], b[1], b[2], b[3]];
        match self {
            Self::I8 => f64::from(b[0] as i8),
            Self::U8 => f64::from(b[0]),
            Self::I16 => f64::from(i16::from_le_bytes([b[0], b[1]])),
            Self::U16 => f64::from(u16::from_le_bytes([b[0], b[1]])),
            Self::I32 => f64::from(i32::from_le_bytes(four)),
            Self::U32 => f64::from(u32::from_le_bytes(four)),
            Self::F32 => f64::from(f32::from_le_bytes(four)),
            Self::F64 => f64::from_le_bytes(b),
        }
    }

    /// The value in the first [`Scalar::size`] bytes, highest first.
    pub(super) fn big(self, mut bytes: [u8; 8]) -> f64 {
        bytes[..self.size()].reverse();
        self.little(bytes)
    }
}

/// The header, and the bytes behind it.
pub(super) fn read<'a>(at: &str, bytes: &'a [u8]) -> Result<(Header, &'a [u8]), Error> {
    let mut left = bytes;
    let mut next_line = || {
        let end = left.iter().take(MAX_BYTES).position(|b| *b == b'\n')?;
        let (line, rest) = left.split_at(end);
        left = &rest[1..];
        std::str::from_utf8(line).ok()
    };
    let mut line = || next_line().ok_or_else(|| damaged(at, "its header has no end"));
    if line()?.trim_end() != "ply" {
        return Err(damaged(at, "it does not start with `ply`"));
    }
    let mut encoding = None;
    let mut elements: Vec<Element> = Vec::new();
    let mut read_bytes = 0;
    loop {
        let text = line()?;
        read_bytes += text.len();
        if read_bytes > MAX_BYTES {
            return Err(damaged(at, "its header has no end"));
        }
        let words: Vec<&str> = text.split_ascii_whitespace().collect();
        match words[..] {
            ["end_header"] => break,
            ["format", name, "1.0"] => {
                encoding = match name {
                    "ascii" => Some(Encoding::Ascii),
                    "binary_little_endian" => Some(Encoding::Little),
                    "binary_big_endian" => Some(Encoding::Big),
                    _ => None,
                }
            }
            ["element", name, count] => {
                let count = count.parse().map_err(|_| damaged(at, "an element has no count"))?;
                elements.push(Element { name: name.to_owned(), count, properties: Vec::new() });
            }
            ["property", ref kind @ .., name] => {
                let scalar = |name: &str| {
                    Scalar::from_name(name)
                        .ok_or_else(|| damaged(at, format!("`{name}` is no type of a number")))
                };
                let (length, scalar) = match *kind {
                    [one] => (None, scalar(one)?),
                    ["list", length, each] => (Some(scalar(length)?), scalar(each)?),
                    _ => return Err(damaged(at, "a property of its header is misspelt")),
                };
                let element = elements
                    .last_mut()
                    .ok_or_else(|| damaged(at, "its header has a property without an element"))?;
                element.properties.push(Property { name: name.to_owned(), scalar, length });
            }
            ["comment" | "obj_info", ..] | [] => {}
            _ => return Err(damaged(at, "its header has an unknown line")),
        }
    }
    let encoding = encoding.ok_or_else(|| damaged(at, "its format is not known"))?;
    // Without properties an element takes no bytes, so that any count would do.
    if elements.iter().any(|e| e.properties.is_empty() && e.count > 0) {
        return Err(damaged(at, "an element of its header has no properties"));
    }
    Ok((Header { encoding, elements }, left))
}
