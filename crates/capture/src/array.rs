//! An array as files hold it: type, shape, order and bytes, not yet decoded.
//! Both .npy files and pickles end here.

mod labels;

use std::borrow::Cow;

use bendtwin_core::Point;

use crate::{Error, limits::Budget};

/// Element types that captures may hold, little-endian.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Dtype {
    Bool,
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    I64,
    U64,
    F16,
    F32,
    F64,
}

impl Dtype {
    /// From numpy's kind letter and item size, `f` and 8 say.
    pub(crate) fn from_numpy(kind: char, size: usize) -> Option<Self> {
        Some(match (kind, size) {
            ('b', 1) => Self::Bool,
            ('i', 1) => Self::I8,
            ('u', 1) => Self::U8,
            ('i', 2) => Self::I16,
            ('u', 2) => Self::U16,
            ('i', 4) => Self::I32,
            ('u', 4) => Self::U32,
            ('i', 8) => Self::I64,
            ('u', 8) => Self::U64,
            ('f', 2) => Self::F16,
            ('f', 4) => Self::F32,
            ('f', 8) => Self::F64,
            _ => return None,
        })
    }

    /// Bytes of one element.
    pub(crate) fn size(self) -> usize {
        match self {
            Self::Bool | Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 | Self::F16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::I64 | Self::U64 | Self::F64 => 8,
        }
    }

    fn is_float(self) -> bool {
        matches!(self, Self::F16 | Self::F32 | Self::F64)
    }

    /// An element of floats from its bytes.
    pub(crate) fn float(self, bytes: &[u8]) -> f64 {
        match self {
            Self::F16 => f64::from(half(bits(bytes) as u16)),
            Self::F32 => f64::from(f32::from_bits(bits(bytes) as u32)),
            _ => f64::from_bits(bits(bytes)),
        }
    }

    /// An element of integers or truth values from its bytes; the largest number stands for those
    /// beyond it.
    fn integer(self, bytes: &[u8]) -> i64 {
        let raw = bits(bytes);
        if matches!(self, Self::I8 | Self::I16 | Self::I32 | Self::I64) {
            let shift = 64 - 8 * self.size() as u32;
            ((raw << shift) as i64) >> shift
        } else {
            i64::try_from(raw).unwrap_or(i64::MAX)
        }
    }

    fn name(self) -> &'static str {
        match self {
            Self::Bool => "bool",
            Self::I8 => "int8",
            Self::U8 => "uint8",
            Self::I16 => "int16",
            Self::U16 => "uint16",
            Self::I32 => "int32",
            Self::U32 => "uint32",
            Self::I64 => "int64",
            Self::U64 => "uint64",
            Self::F16 => "float16",
            Self::F32 => "float32",
            Self::F64 => "float64",
        }
    }
}

/// An array whose byte count is known to fit its shape.
#[derive(Clone, Debug)]
pub(crate) struct Array<'a> {
    /// Origin, for messages.
    pub(crate) at: String,
    pub(crate) dtype: Dtype,
    pub(crate) shape: Vec<usize>,
    fortran: bool,
    data: Cow<'a, [u8]>,
}

/// Bytes that a shape needs; `None` where that overflows.
pub(crate) fn byte_count(shape: &[usize], dtype: Dtype) -> Option<u64> {
    // A zero anywhere makes the product zero, even beside an overflow.
    if shape.contains(&0) {
        return Some(0);
    }
    shape.iter().try_fold(dtype.size() as u64, |n, d| n.checked_mul(*d as u64))
}

impl<'a> Array<'a> {
    /// Largest number of dimensions, numpy's own.
    pub(crate) const MAX_DIMENSIONS: usize = 32;

    /// Joins shape and bytes.
    ///
    /// # Errors
    /// If there are not exactly the bytes that the shape needs.
    pub(crate) fn new(
        at: &str,
        dtype: Dtype,
        shape: Vec<usize>,
        fortran: bool,
        data: Cow<'a, [u8]>,
    ) -> Result<Self, Error> {
        let claimed = byte_count(&shape, dtype).unwrap_or(u64::MAX);
        if claimed != data.len() as u64 || shape.len() > Self::MAX_DIMENSIONS {
            return Err(Error::Absurd { at: at.to_owned(), claimed, present: data.len() as u64 });
        }
        Ok(Self { at: at.to_owned(), dtype, shape, fortran, data })
    }

    /// The array under another name.
    pub(crate) fn named(mut self, at: &str) -> Self {
        at.clone_into(&mut self.at);
        self
    }

    /// `true` if elements are floats.
    pub(crate) fn is_float(&self) -> bool {
        self.dtype.is_float()
    }

    /// Name of its elements' type: `uint16`, for example.
    pub(crate) fn dtype_name(&self) -> &'static str {
        self.dtype.name()
    }

    /// `true` if elements are unsigned bytes.
    pub(crate) fn is_u8(&self) -> bool {
        self.dtype == Dtype::U8
    }

    /// Number of elements.
    pub(crate) fn len(&self) -> usize {
        self.data.len() / self.dtype.size()
    }

    pub(crate) fn wrong_shape(&self, needed: &str) -> Error {
        Error::Shape { at: self.at.clone(), found: self.shape.clone(), needed: needed.to_owned() }
    }

    fn wrong_dtype(&self, needed: &'static str) -> Error {
        Error::Dtype { at: self.at.clone(), found: self.dtype.name().to_owned(), needed }
    }

    /// Elements in row-major order through `decode`, which gets an element's bytes.
    fn decode<T>(&self, budget: &mut Budget, decode: impl Fn(&[u8]) -> T) -> Result<Vec<T>, Error> {
        budget.take((self.len() as u64).saturating_mul(size_of::<T>() as u64), &self.at)?;
        let size = self.dtype.size();
        if !self.fortran || self.shape.len() < 2 {
            return Ok(self.data.chunks_exact(size).map(decode).collect());
        }
        let mut out = Vec::with_capacity(self.len());
        let mut index = vec![0_usize; self.shape.len()];
        for _ in 0..self.len() {
            let mut stride = 1;
            let mut element = 0;
            for (i, extent) in index.iter().zip(&self.shape) {
                element += i * stride;
                stride *= extent;
            }
            out.push(decode(&self.data[element * size..(element + 1) * size]));
            for (i, extent) in index.iter_mut().zip(&self.shape).rev() {
                *i += 1;
                if *i < *extent {
                    break;
                }
                *i = 0;
            }
        }
        Ok(out)
    }

    /// Floats; integers are refused, because they are a sign of millimetres or indices.
    pub(crate) fn floats(&self, budget: &mut Budget) -> Result<Vec<f32>, Error> {
        match self.dtype {
            Dtype::F16 => self.decode(budget, |b| half(bits(b) as u16)),
            Dtype::F32 => self.decode(budget, |b| f32::from_bits(bits(b) as u32)),
            Dtype::F64 => self.decode(budget, |b| f64::from_bits(bits(b)) as f32),
            _ => Err(self.wrong_dtype("float32 or float64")),
        }
    }

    /// Floats in double precision.
    pub(crate) fn doubles(&self, budget: &mut Budget) -> Result<Vec<f64>, Error> {
        match self.dtype {
            Dtype::F16 | Dtype::F32 | Dtype::F64 => self.decode(budget, |b| self.dtype.float(b)),
            _ => Err(self.wrong_dtype("float32 or float64")),
        }
    }

    /// Numbers of any type but truth values, times a factor.
    pub(crate) fn scaled(&self, factor: f64, budget: &mut Budget) -> Result<Vec<f32>, Error> {
        match self.dtype {
            Dtype::U8 | Dtype::U16 | Dtype::U32 | Dtype::U64 => {
                self.decode(budget, |b| (bits(b) as f64 * factor) as f32)
            }
            Dtype::I8 | Dtype::I16 | Dtype::I32 | Dtype::I64 => {
                self.decode(budget, |b| (self.dtype.integer(b) as f64 * factor) as f32)
            }
            Dtype::F16 | Dtype::F32 | Dtype::F64 => {
                self.decode(budget, |b| (self.dtype.float(b) * factor) as f32)
            }
            Dtype::Bool => Err(self.wrong_dtype("uint16, uint32, float32 or float64")),
        }
    }

    /// Points: floats whose last dimension is 3.
    pub(crate) fn points(&self, budget: &mut Budget) -> Result<Vec<Point>, Error> {
        if self.shape.last() != Some(&3) {
            return Err(self.wrong_shape("[.., 3]"));
        }
        let floats = self.floats(budget)?;
        Ok(triples(&floats))
    }

    /// Colours 0..=1 from floats or from bytes 0..=255.
    pub(crate) fn colors(&self, budget: &mut Budget) -> Result<Vec<Point>, Error> {
        if self.dtype != Dtype::U8 {
            return self.points(budget);
        }
        if self.shape.last() != Some(&3) {
            return Err(self.wrong_shape("[.., 3]"));
        }
        let channels =
            self.decode(budget, |b| f32::from(b.first().copied().unwrap_or(0)) / 255.0)?;
        Ok(triples(&channels))
    }

    /// Truth values; bytes count as true where they are not zero.
    pub(crate) fn bools(&self, budget: &mut Budget) -> Result<Vec<bool>, Error> {
        match self.dtype {
            Dtype::Bool | Dtype::U8 | Dtype::I8 => {
                self.decode(budget, |b| b.iter().any(|x| *x != 0))
            }
            _ => Err(self.wrong_dtype("bool or uint8")),
        }
    }

    /// Bytes.
    pub(crate) fn bytes(&self, budget: &mut Budget) -> Result<Vec<u8>, Error> {
        match self.dtype {
            Dtype::U8 => self.decode(budget, |b| b.first().copied().unwrap_or_default()),
            _ => Err(self.wrong_dtype("uint8")),
        }
    }

    /// Integers of any width.
    pub(crate) fn integers(&self, budget: &mut Budget) -> Result<Vec<i64>, Error> {
        if self.dtype.is_float() || self.dtype == Dtype::Bool {
            return Err(self.wrong_dtype("integers"));
        }
        self.decode(budget, |b| self.dtype.integer(b))
    }
}

fn triples(flat: &[f32]) -> Vec<Point> {
    flat.as_chunks().0.to_vec()
}

/// Little-endian bytes as a number.
fn bits(bytes: &[u8]) -> u64 {
    bytes.iter().rev().fold(0, |n, b| (n << 8) | u64::from(*b))
}

/// A number in half precision (IEEE 754 binary16).
fn half(bits: u16) -> f32 {
    let sign = if bits >> 15 == 1 { -1.0 } else { 1.0 };
    let (exponent, fraction) = (i32::from(bits >> 10 & 31), f32::from(bits & 1023));
    sign * match exponent {
        0 => fraction * 2.0_f32.powi(-24),
        31 if fraction == 0.0 => f32::INFINITY,
        31 => f32::NAN,
        _ => (1024.0 + fraction) * 2.0_f32.powi(exponent - 25),
    }
}

#[cfg(test)]
mod tests;
