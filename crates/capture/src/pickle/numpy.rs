//! The allow-list: what numpy's pickles refer to by name, and what calling it
//! or setting its state means.

use std::borrow::Cow;

use super::{Id, Value, machine::Fault};
use crate::array::{Array, Dtype};

/// A global that may be named.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Global {
    /// `numpy.core.multiarray._reconstruct`.
    Reconstruct,
    /// `numpy.core.numeric._frombuffer`, protocol 5.
    FromBuffer,
    /// `numpy.core.multiarray.scalar`.
    Scalar,
    /// `numpy.ndarray`.
    NdArray,
    /// `numpy.dtype`.
    Dtype,
    /// `_codecs.encode`, how protocol 2 keeps bytes.
    Encode,
    /// `bytes`, how protocol 2 keeps empty bytes.
    Bytes,
}

impl Global {
    /// The global of a module and name, if it is allowed.
    pub(super) fn find(module: &str, name: &str) -> Option<Self> {
        // numpy 2 renamed `numpy.core` to `numpy._core`; files of both are about.
        let module = module
            .strip_prefix("numpy._core")
            .map_or_else(|| Cow::Borrowed(module), |rest| Cow::Owned(format!("numpy.core{rest}")));
        Some(match (module.as_ref(), name) {
            ("numpy.core.multiarray", "_reconstruct") => Self::Reconstruct,
            ("numpy.core.multiarray", "scalar") => Self::Scalar,
            ("numpy.core.numeric", "_frombuffer") => Self::FromBuffer,
            ("numpy", "ndarray") => Self::NdArray,
            ("numpy", "dtype") => Self::Dtype,
            ("_codecs", "encode") => Self::Encode,
            ("builtins" | "__builtin__", "bytes") => Self::Bytes,
            _ => return None,
        })
    }
}

/// A dtype in the making: its byte order comes after its type.
#[derive(Clone, Debug)]
pub(super) struct Descr {
    word: String,
    big_endian: bool,
}

impl Descr {
    /// `numpy.dtype(word, align, copy)`.
    pub(super) fn new(word: &str) -> Self {
        Self { word: word.to_owned(), big_endian: word.starts_with('>') }
    }

    /// Takes the byte order of a dtype's state `(version, order, subdtype, names, fields, size,
    /// alignment, flags)`.
    pub(super) fn set_order(&mut self, order: &str) {
        self.big_endian = order == ">";
    }

    fn dtype(&self) -> Result<Dtype, Fault> {
        let word = self.word.trim_start_matches(['<', '>', '|', '=']);
        let mut letters = word.chars();
        let kind = letters.next().unwrap_or('?');
        let dtype = letters.as_str().parse().ok().and_then(|size| Dtype::from_numpy(kind, size));
        match dtype {
            Some(dtype) if !self.big_endian || dtype.size() == 1 => Ok(dtype),
            Some(_) => Err(Fault::Dtype(format!("big-endian `{word}`"))),
            None if kind == 'O' => Err(Fault::Dtype("Python objects".to_owned())),
            None => Err(Fault::Dtype(format!("`{word}`"))),
        }
    }
}

/// Reads an array's parts out of values.
pub(super) struct Parts<'m, 'a> {
    pub(super) values: &'m [Value<'a>],
}

impl<'m, 'a> Parts<'m, 'a> {
    pub(super) fn value(&self, ids: &[Id], at: usize) -> Option<&'m Value<'a>> {
        self.values.get(*ids.get(at)? as usize)
    }

    pub(super) fn str(&self, ids: &[Id], at: usize) -> Option<&'m str> {
        match self.value(ids, at)? {
            Value::Str(s) => Some(s),
            _ => None,
        }
    }

    pub(super) fn bytes(&self, ids: &[Id], at: usize) -> Option<&'m Cow<'a, [u8]>> {
        match self.value(ids, at)? {
            Value::Bytes(b) => Some(b),
            _ => None,
        }
    }

    pub(super) fn shape(&self, ids: &[Id], at: usize) -> Option<Vec<usize>> {
        let Value::Tuple(dims) = self.value(ids, at)? else { return None };
        if dims.len() > Array::MAX_DIMENSIONS {
            return None;
        }
        (0..dims.len())
            .map(|d| match self.value(dims, d)? {
                Value::Int(n) => usize::try_from(*n).ok(),
                _ => None,
            })
            .collect()
    }

    fn dtype(&self, ids: &[Id], at: usize) -> Result<Dtype, Fault> {
        match self.value(ids, at) {
            Some(Value::Dtype(descr)) => descr.dtype(),
            _ => Err(Fault::damaged("an array without a dtype")),
        }
    }

    /// The array of a state `(version, shape, dtype, is_fortran, bytes)`.
    pub(super) fn of_state(&self, state: &[Id]) -> Result<Parsed<'m, 'a>, Fault> {
        let shape = self.shape(state, 1).ok_or(Fault::damaged("an array without a shape"))?;
        let dtype = self.dtype(state, 2)?;
        let fortran = matches!(self.value(state, 3), Some(Value::Bool(true)));
        let data = self.bytes(state, 4).ok_or(Fault::damaged("an array without bytes"))?;
        Ok(Parsed { shape, dtype, fortran, data })
    }

    /// The array of a call `_frombuffer(bytes, dtype, shape, order)`.
    pub(super) fn of_buffer(&self, args: &[Id]) -> Result<Parsed<'m, 'a>, Fault> {
        let data = self.bytes(args, 0).ok_or(Fault::damaged("an array without bytes"))?;
        let dtype = self.dtype(args, 1)?;
        let shape = self.shape(args, 2).ok_or(Fault::damaged("an array without a shape"))?;
        Ok(Parsed { shape, dtype, fortran: self.str(args, 3) == Some("F"), data })
    }

    /// The number of a call `scalar(dtype, bytes)`.
    pub(super) fn scalar(&self, args: &[Id]) -> Result<Value<'a>, Fault> {
        let dtype = self.dtype(args, 0)?;
        let bytes = self.bytes(args, 1).ok_or(Fault::damaged("a number without bytes"))?;
        if bytes.len() != dtype.size() {
            return Err(Fault::damaged("a number of another size than its type"));
        }
        let raw = bytes.iter().rev().fold(0_u64, |n, b| (n << 8) | u64::from(*b));
        Ok(match dtype {
            Dtype::F16 | Dtype::F32 | Dtype::F64 => Value::Float(dtype.float(bytes)),
            Dtype::Bool => Value::Bool(raw != 0),
            _ => Value::Int(raw as i64),
        })
    }
}

/// An array's parts.
pub(super) struct Parsed<'m, 'a> {
    pub(super) shape: Vec<usize>,
    pub(super) dtype: Dtype,
    pub(super) fortran: bool,
    pub(super) data: &'m Cow<'a, [u8]>,
}
