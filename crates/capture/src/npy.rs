//! The .npy format, versions 1 to 3, simple types only. Written here rather
//! than taken from a crate because every size must be checked before it is
//! believed and the header must not be parsed recursively.

use std::borrow::Cow;

use crate::{
    Error, Limits,
    array::{Array, Dtype},
    limits::Budget,
    pickle,
};

const MAGIC: &[u8] = b"\x93NUMPY";
/// numpy's own limit on headers that it reads without being forced.
const MAX_HEADER: usize = 10_000;
/// Data starts at a multiple of this.
const ALIGN: usize = 64;

/// A dense array of floats in row-major order.
#[derive(Clone, Debug, PartialEq)]
pub struct Floats {
    /// Extent of each dimension.
    pub shape: Vec<usize>,
    /// Values, one per element of the shape.
    pub values: Vec<f32>,
}

impl Floats {
    /// Decodes an .npy file of 32- or 64-bit floats in either order; `at` is its name in messages.
    ///
    /// # Errors
    /// If the file is damaged, of another type, or beyond the limits.
    pub fn decode(at: &str, bytes: &[u8], limits: &Limits) -> Result<Self, Error> {
        let array = read(at, bytes)?;
        let values = array.floats(&mut Budget::new(limits))?;
        Ok(Self { shape: array.shape, values })
    }

    /// Decodes a pickle of one array, or of a list of arrays, of 32- or 64-bit floats; `at` is its
    /// name in messages.
    ///
    /// # Errors
    /// If the pickle is damaged, asks for anything but arrays, or is beyond the limits.
    pub fn unpickle(at: &str, bytes: &[u8], limits: &Limits) -> Result<Vec<Self>, Error> {
        let mut budget = Budget::new(limits);
        let arrays = pickle::read(at, bytes, limits, &mut budget)?.arrays()?;
        let of =
            |array: Array<'_>| Ok(Self { values: array.floats(&mut budget)?, shape: array.shape });
        arrays.into_iter().map(of).collect()
    }

    /// Encodes as an .npy file of 32-bit floats.
    pub fn encode(&self) -> Vec<u8> {
        let bytes: Vec<u8> = self.values.iter().flat_map(|x| x.to_le_bytes()).collect();
        write("<f4", &self.shape, &bytes)
    }
}

/// Reads an array; `at` is its name in messages.
pub(crate) fn read<'a>(at: &str, bytes: &'a [u8]) -> Result<Array<'a>, Error> {
    let damaged = |fault: &str| Error::Damaged { at: at.to_owned(), fault: fault.to_owned() };
    let rest = bytes.strip_prefix(MAGIC).ok_or_else(|| damaged("it is no .npy file"))?;
    let (&[major, _minor], rest) =
        rest.split_first_chunk().ok_or_else(|| damaged("it ends within its header"))?;
    let cut = || damaged("it ends within its header");
    let (header_len, rest) = match major {
        1 => {
            let (len, rest) = rest.split_first_chunk().ok_or_else(cut)?;
            (usize::from(u16::from_le_bytes(*len)), rest)
        }
        2 | 3 => {
            let (len, rest) = rest.split_first_chunk().ok_or_else(cut)?;
            (u32::from_le_bytes(*len) as usize, rest)
        }
        _ => return Err(damaged(&format!("its .npy version is {major}, known are 1 to 3"))),
    };
    if header_len > MAX_HEADER {
        return Err(damaged(&format!("its header claims {header_len} bytes")));
    }
    let (header, data) = rest.split_at_checked(header_len).ok_or_else(cut)?;
    let header = std::str::from_utf8(header).map_err(|_| damaged("its header is no text"))?;
    let header = Header::parse(header).map_err(|fault| damaged(&fault))?;
    let dtype = dtype(at, header.descr)?;
    Array::new(at, dtype, header.shape, header.fortran, Cow::Borrowed(data))
}

/// The element type of a description such as `<f4`.
fn dtype(at: &str, descr: &str) -> Result<Dtype, Error> {
    let wrong = |found: String| Error::Dtype {
        at: at.to_owned(),
        found,
        needed: "little-endian bool, integers or floats",
    };
    let mut letters = descr.chars();
    let (order, kind) = (letters.next(), letters.next());
    let size = letters.as_str().parse::<usize>().ok();
    let (Some(order), Some(kind), Some(size)) = (order, kind, size) else {
        return Err(wrong(format!("`{descr}`")));
    };
    match (order, Dtype::from_numpy(kind, size)) {
        ('<' | '|' | '=', Some(dtype)) => Ok(dtype),
        ('>', Some(dtype)) if dtype.size() == 1 => Ok(dtype),
        ('>', Some(_)) => Err(wrong(format!("big-endian `{descr}`"))),
        (_, _) if kind == 'O' => Err(wrong("Python objects".to_owned())),
        _ => Err(wrong(format!("`{descr}`"))),
    }
}

struct Header<'a> {
    descr: &'a str,
    fortran: bool,
    shape: Vec<usize>,
}

impl<'a> Header<'a> {
    /// Parses `{'descr': '<f4', 'fortran_order': False, 'shape': (3, 4), }`.
    fn parse(text: &'a str) -> Result<Self, String> {
        let mut words = Tokens(text);
        let (mut descr, mut fortran, mut shape) = (None, None, None);
        words.expect('{')?;
        while !words.accept('}') {
            let key = words.quoted()?;
            words.expect(':')?;
            match key {
                "descr" => descr = Some(words.quoted()?),
                "fortran_order" => fortran = Some(words.truth()?),
                "shape" => shape = Some(words.tuple()?),
                _ => return Err(format!("its header has an unknown key `{key}`")),
            }
            words.accept(',');
        }
        let missing = |key| format!("its header has no `{key}`");
        Ok(Self {
            descr: descr.ok_or_else(|| missing("descr"))?,
            fortran: fortran.ok_or_else(|| missing("fortran_order"))?,
            shape: shape.ok_or_else(|| missing("shape"))?,
        })
    }
}

/// Remainder of a header's text.
struct Tokens<'a>(&'a str);

impl<'a> Tokens<'a> {
    fn accept(&mut self, c: char) -> bool {
        match self.0.trim_start().strip_prefix(c) {
            Some(rest) => {
                self.0 = rest;
                true
            }
            None => false,
        }
    }

    fn expect(&mut self, c: char) -> Result<(), String> {
        if self.accept(c) { Ok(()) } else { Err(format!("its header lacks a `{c}`")) }
    }

    fn quoted(&mut self) -> Result<&'a str, String> {
        let quote = if self.accept('\'') {
            '\''
        } else if self.accept('"') {
            '"'
        } else {
            // Structured types are lists of tuples; captures have none.
            return Err("its header has something else where a quoted word belongs".to_owned());
        };
        let (word, rest) =
            self.0.split_once(quote).ok_or("a quoted word of its header has no end")?;
        self.0 = rest;
        Ok(word)
    }

    fn truth(&mut self) -> Result<bool, String> {
        let text = self.0.trim_start();
        for (word, value) in [("True", true), ("False", false)] {
            if let Some(rest) = text.strip_prefix(word) {
                self.0 = rest;
                return Ok(value);
            }
        }
        Err("`fortran_order` is neither True nor False".to_owned())
    }

    fn tuple(&mut self) -> Result<Vec<usize>, String> {
        self.expect('(')?;
        let (inside, rest) = self.0.split_once(')').ok_or("its shape has no end")?;
        self.0 = rest;
        let numbers = inside.split(',').map(str::trim).filter(|n| !n.is_empty());
        let shape: Vec<usize> = numbers
            .map(|n| n.trim_end_matches('L').parse().map_err(|_| format!("its shape has `{n}`")))
            .collect::<Result<_, _>>()?;
        if shape.len() > Array::MAX_DIMENSIONS {
            return Err(format!("its shape has {} dimensions", shape.len()));
        }
        Ok(shape)
    }
}

/// An .npy file, version 1, of elements such as `<f4`; `data` is row-major and little-endian, and
/// has the elements of `shape`.
pub fn write(descr: &str, shape: &[usize], data: &[u8]) -> Vec<u8> {
    let dims: String = shape.iter().map(|d| format!("{d}, ")).collect();
    let mut header = format!(
        "{{'descr': '{descr}', 'fortran_order': False, 'shape': ({}), }}",
        if shape.len() == 1 { dims.trim_end() } else { dims.trim_end_matches(", ") }
    );
    let unpadded = MAGIC.len() + 4 + header.len() + 1;
    header.push_str(&" ".repeat(unpadded.next_multiple_of(ALIGN) - unpadded));
    header.push('\n');
    let mut file = Vec::with_capacity(MAGIC.len() + 4 + header.len() + data.len());
    file.extend_from_slice(MAGIC);
    file.extend_from_slice(&[1, 0]);
    // At most 32 dimensions of 20 digits: far below 64 KiB.
    file.extend_from_slice(&(header.len() as u16).to_le_bytes());
    file.extend_from_slice(header.as_bytes());
    file.extend_from_slice(data);
    file
}

#[cfg(test)]
mod tests;
