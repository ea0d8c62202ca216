//! torch's part of the allow-list. A tensor in a pickle is a view of a storage, whose bytes lie in
//! the archive beside the pickle under the storage's key; a pickle names storages by persistent ids.

use std::borrow::Cow;

use super::{Id, Value, machine::Fault, numpy::Parts};
use crate::array::{Array, Dtype};

/// A global that may be named.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Global {
    /// `torch._utils._rebuild_tensor_v2`.
    RebuildTensor,
    /// `torch._utils._rebuild_parameter`, around a tensor.
    RebuildParameter,
    /// `collections.OrderedDict`.
    OrderedDict,
    /// `torch.FloatStorage` and its like; only named in persistent ids.
    Storage(Dtype),
}

/// Bytes beside the pickle.
#[derive(Clone, Debug)]
pub(super) struct Storage<'a> {
    dtype: Dtype,
    key: Cow<'a, str>,
}

/// A view of a storage.
#[derive(Clone, Debug)]
pub(crate) struct Tensor<'a> {
    /// Key of the storage in its archive.
    pub(crate) key: Cow<'a, str>,
    pub(crate) dtype: Dtype,
    /// Elements of the storage before the tensor's first.
    pub(crate) offset: usize,
    pub(crate) shape: Vec<usize>,
    /// Elements from one to the next in each dimension.
    pub(crate) stride: Vec<usize>,
}

impl Global {
    /// The global of a module and name, if it is allowed.
    pub(super) fn find(module: &str, name: &str) -> Option<Self> {
        let storage = |dtype| Some(Self::Storage(dtype));
        match (module, name) {
            ("torch._utils", "_rebuild_tensor_v2") => Some(Self::RebuildTensor),
            ("torch._utils", "_rebuild_parameter") => Some(Self::RebuildParameter),
            ("collections", "OrderedDict") => Some(Self::OrderedDict),
            ("torch", "FloatStorage") => storage(Dtype::F32),
            ("torch", "DoubleStorage") => storage(Dtype::F64),
            ("torch", "LongStorage") => storage(Dtype::I64),
            ("torch", "IntStorage") => storage(Dtype::I32),
            ("torch", "ShortStorage") => storage(Dtype::I16),
            ("torch", "CharStorage") => storage(Dtype::I8),
            ("torch", "ByteStorage") => storage(Dtype::U8),
            ("torch", "BoolStorage") => storage(Dtype::Bool),
            _ => None,
        }
    }

    /// The value that calling it gives.
    pub(super) fn call<'a>(self, parts: &Parts<'_, 'a>, args: &[Id]) -> Result<Value<'a>, Fault> {
        match self {
            Self::RebuildTensor => tensor(parts, args).map(Value::Tensor),
            Self::RebuildParameter => match parts.value(args, 0) {
                Some(Value::Tensor(tensor)) => Ok(Value::Tensor(tensor.clone())),
                _ => Err(Fault::damaged("a parameter without a tensor")),
            },
            // Its items follow one by one, as those of a dictionary.
            Self::OrderedDict if args.is_empty() => Ok(Value::Dict(Vec::new())),
            Self::OrderedDict | Self::Storage(_) => {
                Err(Fault::Refused("the archive builds an object in an unusual way".into()))
            }
        }
    }
}

/// The storage of a persistent id `("storage", type, key, location, length)`. The length is that of
/// the file beside the pickle; the value in the id is ignored.
pub(super) fn storage<'a>(parts: &Parts<'_, 'a>, id: &Value<'a>) -> Result<Storage<'a>, Fault> {
    const UNKNOWN: Fault = Fault::Damaged("it names something that is no storage");
    let Value::Tuple(id) = id else { return Err(UNKNOWN) };
    let (Some("storage"), Some(Value::TorchGlobal(Global::Storage(dtype))), Some(Value::Str(key))) =
        (parts.str(id, 0), parts.value(id, 1), parts.value(id, 2))
    else {
        return Err(UNKNOWN);
    };
    Ok(Storage { dtype: *dtype, key: key.clone() })
}

/// The tensor of a call `_rebuild_tensor_v2(storage, offset, size, stride, ...)`.
fn tensor<'a>(parts: &Parts<'_, 'a>, args: &[Id]) -> Result<Tensor<'a>, Fault> {
    let Some(Value::Storage(storage)) = parts.value(args, 0) else {
        return Err(Fault::damaged("a tensor without a storage"));
    };
    let offset = match parts.value(args, 1) {
        Some(Value::Int(offset)) => usize::try_from(*offset).ok(),
        _ => None,
    };
    let offset = offset.ok_or(Fault::damaged("a tensor without an offset"))?;
    let shape = parts.shape(args, 2).ok_or(Fault::damaged("a tensor without a size"))?;
    let stride = parts.shape(args, 3).ok_or(Fault::damaged("a tensor without a stride"))?;
    if stride.len() != shape.len() || shape.len() > Array::MAX_DIMENSIONS {
        return Err(Fault::damaged("a tensor whose stride is not that of its size"));
    }
    Ok(Tensor { key: storage.key.clone(), dtype: storage.dtype, offset, shape, stride })
}
