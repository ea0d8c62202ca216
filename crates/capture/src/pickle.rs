//! Python pickles of numpy arrays and of torch tensors, protocols 0 to 5, read without recursion
//! through an allow-list. Nothing is ever imported or called: the few globals
//! that numpy needs are known by name, and those of torch where its archives are read; everything
//! else is refused.

mod input;
mod lines;
mod machine;
mod numpy;
mod torch;

use std::borrow::Cow;

pub(crate) use self::torch::Tensor;
use crate::{Error, Limits, array::Array, limits::Budget};

/// Index of a value in its [`Pickle`].
type Id = u32;

/// The globals that a pickle may name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Dialect {
    /// Classes of numpy's arrays.
    Numpy,
    /// Classes of torch's tensors as well.
    Torch,
}

/// A value on the pickle machine's stack or in its memo.
#[derive(Clone, Debug)]
enum Value<'a> {
    None,
    Bool(bool),
    Int(i64),
    Float(f64),
    Str(Cow<'a, str>),
    Bytes(Cow<'a, [u8]>),
    Tuple(Vec<Id>),
    List(Vec<Id>),
    Dict(Vec<(Id, Id)>),
    Global(numpy::Global),
    Dtype(numpy::Descr),
    /// Array as `_reconstruct` returns it, before its state is set.
    EmptyArray,
    Array(Array<'a>),
    TorchGlobal(torch::Global),
    /// Bytes beside the pickle.
    Storage(torch::Storage<'a>),
    Tensor(Tensor<'a>),
}

/// A finished pickle: values by index, so that nesting costs no stack.
#[derive(Debug)]
pub(crate) struct Pickle<'a> {
    at: String,
    values: Vec<Value<'a>>,
    root: Id,
}

/// Reads a pickle; `at` is the file's name in messages.
///
/// # Errors
/// If it is damaged, beyond the limits, or asks for anything but arrays,
/// containers and numbers.
pub(crate) fn read<'a>(
    at: &str,
    bytes: &'a [u8],
    limits: &Limits,
    budget: &mut Budget,
) -> Result<Pickle<'a>, Error> {
    read_dialect(at, bytes, Dialect::Numpy, limits, budget)
}

/// Reads a pickle of a dialect.
///
/// # Errors
/// Those of [`read`].
pub(crate) fn read_dialect<'a>(
    at: &str,
    bytes: &'a [u8],
    dialect: Dialect,
    limits: &Limits,
    budget: &mut Budget,
) -> Result<Pickle<'a>, Error> {
    let (values, root) = machine::Machine::new(at, bytes, dialect, limits, budget).run()?;
    Ok(Pickle { at: at.to_owned(), values, root })
}

impl<'a> Pickle<'a> {
    fn value(&self, id: Id) -> &Value<'a> {
        // Ids are only made by pushing values, so each has one.
        self.values.get(id as usize).unwrap_or(&Value::None)
    }

    /// The root as an array.
    pub(crate) fn array(&self) -> Result<Array<'a>, Error> {
        match self.value(self.root) {
            Value::Array(array) => Ok(array.clone().named(&self.at)),
            other => Err(self.not_as_needed("", other, "a numpy array")),
        }
    }

    /// The arrays of a list or tuple; one array by itself counts as one.
    pub(crate) fn arrays(&self) -> Result<Vec<Array<'a>>, Error> {
        let (Value::List(ids) | Value::Tuple(ids)) = self.value(self.root) else {
            return self.array().map(|array| vec![array]);
        };
        let of = |(index, id): (usize, &Id)| match self.value(*id) {
            Value::Array(array) => Ok(array.clone().named(&format!("{}: {index}", self.at))),
            other => Err(self.not_as_needed(&format!(": {index}"), other, "a numpy array")),
        };
        ids.iter().enumerate().map(of).collect()
    }

    /// The arrays of a dictionary whose keys are texts or whole numbers; `None` for another root.
    pub(crate) fn named_arrays(&self) -> Result<Option<Vec<(String, Array<'a>)>>, Error> {
        let Value::Dict(entries) = self.value(self.root) else { return Ok(None) };
        let of = |(key, value): &(Id, Id)| {
            let name = match self.value(*key) {
                Value::Str(name) => name.to_string(),
                Value::Int(number) => number.to_string(),
                other => return Err(self.not_as_needed(": a key", other, "a str or an int")),
            };
            match self.value(*value) {
                Value::Array(array) => {
                    let array = array.clone().named(&format!("{}: {name}", self.at));
                    Ok((name, array))
                }
                other => Err(self.not_as_needed(&format!(": {name}"), other, "a numpy array")),
            }
        };
        entries.iter().map(of).collect::<Result<_, _>>().map(Some)
    }

    /// The array under a key of the root dictionary, `None` where there is no such
    /// key or it holds Python's None.
    pub(crate) fn entry(&self, key: &str) -> Result<Option<Array<'a>>, Error> {
        match self.find(key, "a dictionary of numpy arrays")? {
            None | Some(Value::None) => Ok(None),
            Some(Value::Array(array)) => {
                Ok(Some(array.clone().named(&format!("{}: {key}", self.at))))
            }
            Some(other) => Err(self.not_as_needed(&format!(": {key}"), other, "a numpy array")),
        }
    }

    /// The number under a key of the root dictionary, `None` where there is no such key.
    pub(crate) fn number(&self, key: &str) -> Result<Option<f64>, Error> {
        match self.find(key, "a dictionary of numbers")? {
            None => Ok(None),
            Some(Value::Float(number)) => Ok(Some(*number)),
            Some(Value::Int(number)) => Ok(Some(*number as f64)),
            Some(other) => Err(self.not_as_needed(&format!(": {key}"), other, "a number")),
        }
    }

    /// The tensor under a key of the root dictionary, `None` where there is no such key.
    pub(crate) fn tensor(&self, key: &str) -> Result<Option<Tensor<'a>>, Error> {
        match self.find(key, "a dictionary of tensors")? {
            None => Ok(None),
            Some(Value::Tensor(tensor)) => Ok(Some(tensor.clone())),
            Some(other) => Err(self.not_as_needed(&format!(": {key}"), other, "a tensor")),
        }
    }

    /// The value under a key of the root dictionary.
    fn find(&self, key: &str, needed: &'static str) -> Result<Option<&Value<'a>>, Error> {
        let root = self.value(self.root);
        let Value::Dict(entries) = root else {
            return Err(self.not_as_needed("", root, needed));
        };
        // The last entry of a key counts, as in Python.
        let found =
            entries.iter().rev().find(|(k, _)| matches!(self.value(*k), Value::Str(s) if s == key));
        Ok(found.map(|(_, v)| self.value(*v)))
    }

    fn not_as_needed(&self, within: &str, value: &Value<'_>, needed: &'static str) -> Error {
        Error::Dtype { at: format!("{}{within}", self.at), found: value.kind().to_owned(), needed }
    }
}

impl Value<'_> {
    /// Name of its kind, for messages.
    fn kind(&self) -> &'static str {
        match self {
            Self::None => "None",
            Self::Bool(_) => "a bool",
            Self::Int(_) => "an int",
            Self::Float(_) => "a float",
            Self::Str(_) => "a str",
            Self::Bytes(_) => "bytes",
            Self::Tuple(_) => "a tuple",
            Self::List(_) => "a list",
            Self::Dict(_) => "a dict",
            Self::Global(_) | Self::TorchGlobal(_) => "a function",
            Self::Dtype(_) => "a dtype",
            Self::EmptyArray => "an unfinished array",
            Self::Array(_) => "an array",
            Self::Storage(_) => "a storage",
            Self::Tensor(_) => "a tensor",
        }
    }
}

#[cfg(test)]
mod tests;
