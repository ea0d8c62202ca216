//! Tensors, and those of a file.

use super::{
    Error,
    onnx::{FLOAT, INT64, TensorMessage},
};

/// Most numbers of a tensor; VGG's first features of an image of 4 million pixels.
const MOST_VALUES: usize = 1 << 28;

/// Numbers in rows.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Tensor {
    pub(super) shape: Vec<usize>,
    pub(super) values: Vec<f32>,
}

impl Tensor {
    /// Numbers of a file, integers converted: those that networks have are axes.
    pub(super) fn of(message: &TensorMessage) -> Result<Self, Error> {
        let broken = |why: &str| Error::Format(format!("tensor `{}` {why}", message.name));
        if message.data_location != 0 {
            return Err(broken("is kept in another file"));
        }
        let shape: Option<Vec<usize>> =
            message.dims.iter().map(|d| usize::try_from(*d).ok()).collect();
        let shape = shape.ok_or_else(|| broken("has a negative size"))?;
        let raw = &message.raw_data;
        let values: Vec<f32> = match message.data_type {
            FLOAT if raw.is_empty() => message.float_data.clone(),
            FLOAT => raw
                .chunks_exact(4)
                .filter_map(|b| b.try_into().ok())
                .map(f32::from_le_bytes)
                .collect(),
            INT64 if raw.is_empty() => message.int64_data.iter().map(|v| *v as f32).collect(),
            INT64 => {
                let numbers = raw.chunks_exact(8).filter_map(|b| b.try_into().ok());
                numbers.map(|b| i64::from_le_bytes(b) as f32).collect()
            }
            other => return Err(broken(&format!("has the type {other}, not float32 or int64"))),
        };
        if size(&shape)? != values.len() {
            return Err(broken("has another number of values than its shape"));
        }
        if !values.iter().all(|v| v.is_finite()) {
            return Err(broken("has a number that is not finite"));
        }
        Ok(Self { shape, values })
    }

    /// Batch, channels, rows, columns of a tensor of images.
    pub(super) fn image_shape(&self, operator: &str) -> Result<[usize; 4], Error> {
        match self.shape[..] {
            [1, c, h, w] => Ok([1, c, h, w]),
            _ => Err(Error::Network(format!("{operator} of the shape {:?}", self.shape))),
        }
    }
}

/// Number of values of a shape.
pub(super) fn size(shape: &[usize]) -> Result<usize, Error> {
    let count = shape.iter().try_fold(1usize, |n, d| n.checked_mul(*d));
    count
        .filter(|n| *n <= MOST_VALUES)
        .ok_or_else(|| Error::Network(format!("a tensor of the shape {shape:?} is too large")))
}
