//! Tensors in JSON: nested lists of numbers where they are small and read by
//! people, base64 of the raw bytes where they are not.

use base64::{Engine, prelude::BASE64_STANDARD};
use bendtwin_proto::v1::{Tensor, tensor::Dtype};
use bytes::Bytes;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use utoipa::ToSchema;

use crate::app::{Error, Result};

/// Deepest nesting of a list.
const MOST_DIMENSIONS: usize = 8;

/// A dense array.
#[derive(Deserialize, Serialize, ToSchema)]
#[serde(untagged)]
pub(super) enum JsonTensor {
    /// Raw bytes.
    Packed(Packed),
    /// Nested lists of numbers; null stands for what is no finite number.
    #[schema(value_type = Vec<Object>)]
    Lists(Value),
}

/// A dense array as raw bytes.
#[derive(Deserialize, Serialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct Packed {
    /// FLOAT32, FLOAT64, UINT32, INT32, UINT8 or INT16_SCALED.
    dtype: String,
    shape: Vec<u64>,
    /// Base64 of the little-endian, row-major bytes.
    data: String,
    /// Of INT16_SCALED: value = int16 * scale + offset.
    #[serde(default, skip_serializing_if = "is_zero")]
    scale: f32,
    /// Of INT16_SCALED.
    #[serde(default, skip_serializing_if = "is_zero")]
    offset: f32,
}

fn is_zero(x: &f32) -> bool {
    *x == 0.0
}

/// How tensors of a reply are written.
#[derive(Clone, Copy, Debug, Default, Deserialize, PartialEq, Eq, ToSchema)]
#[serde(rename_all = "snake_case")]
pub(super) enum TensorFormat {
    /// Nested lists.
    #[default]
    Lists,
    /// Objects with base64 data.
    Base64,
}

impl JsonTensor {
    /// The tensor; lists become the type that the field has.
    pub(super) fn read(self, name: &'static str, list_type: Dtype) -> Result<Tensor> {
        match self {
            Self::Packed(packed) => packed.read(name),
            Self::Lists(lists) => read_lists(&lists, name, list_type),
        }
    }

    pub(super) fn write(tensor: &Tensor, format: TensorFormat) -> Self {
        match format {
            TensorFormat::Lists => Self::Lists(write_lists(tensor)),
            TensorFormat::Base64 => Self::Packed(Packed {
                dtype: tensor.dtype().as_str_name().to_owned(),
                shape: tensor.shape.clone(),
                data: BASE64_STANDARD.encode(&tensor.data),
                scale: tensor.scale,
                offset: tensor.offset,
            }),
        }
    }
}

impl Packed {
    fn read(self, name: &'static str) -> Result<Tensor> {
        let dtype = Dtype::from_str_name(&self.dtype)
            .ok_or_else(|| Error::invalid(name, "has an unknown dtype"))?;
        let data = BASE64_STANDARD
            .decode(self.data)
            .map_err(|e| Error::invalid(name, format!("has data that is no base64: {e}")))?;
        Ok(Tensor {
            dtype: dtype.into(),
            shape: self.shape,
            data: data.into(),
            scale: self.scale,
            offset: self.offset,
        })
    }
}

fn read_lists(lists: &Value, name: &'static str, dtype: Dtype) -> Result<Tensor> {
    let mut shape = Vec::new();
    let mut level = lists;
    while let Value::Array(items) = level {
        if shape.len() == MOST_DIMENSIONS {
            return Err(Error::invalid(name, "is nested too deeply"));
        }
        shape.push(items.len() as u64);
        let Some(first) = items.first() else { break };
        level = first;
    }
    if shape.is_empty() {
        return Err(Error::invalid(name, "is neither a list nor an object with dtype and data"));
    }
    let mut data = Vec::new();
    flatten(lists, &shape, name, dtype, &mut data)?;
    Ok(Tensor { dtype: dtype.into(), shape, data: Bytes::from(data), ..Tensor::default() })
}

/// Appends the numbers of a list of this shape.
fn flatten(
    value: &Value,
    shape: &[u64],
    name: &'static str,
    dtype: Dtype,
    data: &mut Vec<u8>,
) -> Result<()> {
    let Some((length, inner)) = shape.split_first() else {
        return number(value, name, dtype, data);
    };
    match value {
        Value::Array(items) if items.len() as u64 == *length => {
            items.iter().try_for_each(|item| flatten(item, inner, name, dtype, data))
        }
        _ => Err(Error::invalid(name, "has rows of different lengths")),
    }
}

fn number(value: &Value, name: &'static str, dtype: Dtype, data: &mut Vec<u8>) -> Result<()> {
    if dtype == Dtype::Uint32 {
        let n = value.as_u64().and_then(|n| u32::try_from(n).ok());
        let n = n.ok_or_else(|| Error::invalid(name, "has an entry that is no index"))?;
        data.extend(n.to_le_bytes());
    } else {
        let x = value.as_f64().map(|x| x as f32).filter(|x| x.is_finite());
        let x = x.ok_or_else(|| Error::invalid(name, "has an entry that is no finite number"))?;
        data.extend(x.to_le_bytes());
    }
    Ok(())
}

fn write_lists(tensor: &Tensor) -> Value {
    let numbers: Vec<Value> = match tensor.dtype() {
        Dtype::Float32 => each(tensor, |b| f64::from(f32::from_le_bytes(b)).into()),
        Dtype::Float64 => each(tensor, |b| f64::from_le_bytes(b).into()),
        Dtype::Uint32 => each(tensor, |b| u32::from_le_bytes(b).into()),
        Dtype::Int32 => each(tensor, |b| i32::from_le_bytes(b).into()),
        Dtype::Uint8 => each(tensor, |[b]| b.into()),
        Dtype::Int16Scaled => each(tensor, |b| {
            (f32::from(i16::from_le_bytes(b)) * tensor.scale + tensor.offset).into()
        }),
        Dtype::Unspecified => Vec::new(),
    };
    nest(numbers, &tensor.shape)
}

fn each<const N: usize>(tensor: &Tensor, value: impl Fn([u8; N]) -> Value) -> Vec<Value> {
    tensor.data.as_chunks::<N>().0.iter().map(|chunk| value(*chunk)).collect()
}

/// Groups a flat list by the dimensions, innermost first.
fn nest(mut values: Vec<Value>, shape: &[u64]) -> Value {
    for width in shape.iter().skip(1).rev() {
        let Ok(width @ 1..) = usize::try_from(*width) else { return Value::Array(Vec::new()) };
        let mut rows = Vec::with_capacity(values.len() / width);
        let mut rest = values.into_iter();
        loop {
            let row: Vec<Value> = rest.by_ref().take(width).collect();
            if row.is_empty() {
                break;
            }
            rows.push(Value::Array(row));
        }
        values = rows;
    }
    Value::Array(values)
}

#[cfg(test)]
mod tests;
