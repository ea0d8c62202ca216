//! Tensors on the wire: little-endian, row-major bytes with a type and a shape.
//! Reading checks type, shape and length before anything is allocated.

use bytemuck::Pod;
use bytes::Bytes;

use crate::v1::{Tensor, tensor::Dtype};

/// Most dimensions of a tensor.
pub const MOST_DIMENSIONS: usize = 8;

/// A tensor that is not what was asked for.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("tensor `{name}` {fault}")]
pub struct TensorError {
    /// The field's name.
    pub name: String,
    /// The fault.
    pub fault: String,
}

/// Rust types that tensors can hold.
pub trait Element: Pod {
    /// The type on the wire.
    const DTYPE: Dtype;
}

impl Element for f32 {
    const DTYPE: Dtype = Dtype::Float32;
}
impl Element for f64 {
    const DTYPE: Dtype = Dtype::Float64;
}
impl Element for u32 {
    const DTYPE: Dtype = Dtype::Uint32;
}
impl Element for i32 {
    const DTYPE: Dtype = Dtype::Int32;
}
impl Element for u8 {
    const DTYPE: Dtype = Dtype::Uint8;
}

impl Tensor {
    /// Packs a flat slice. The shape's product must be the slice's length.
    ///
    /// # Panics
    /// If it is not: shapes are the caller's own arithmetic, never a client's.
    pub fn pack<T: Element>(shape: &[usize], values: &[T]) -> Self {
        assert_eq!(shape.iter().product::<usize>(), values.len(), "shape {shape:?}");
        Self {
            dtype: T::DTYPE.into(),
            shape: shape.iter().map(|d| *d as u64).collect(),
            data: Bytes::copy_from_slice(bytemuck::cast_slice(values)),
            ..Self::default()
        }
    }

    /// Packs points as [..., 3].
    pub fn pack_points(shape: &[usize], points: &[[f32; 3]]) -> Self {
        let shape: Vec<usize> = shape.iter().copied().chain([3]).collect();
        Self::pack(&shape, bytemuck::cast_slice::<_, f32>(points))
    }

    /// Packs points as scaled 16-bit integers: half the bytes, error below 1/65535 of the extent.
    pub fn pack_points_i16(shape: &[usize], points: &[[f32; 3]]) -> Self {
        let finite = points.iter().flatten().copied().filter(|x| x.is_finite());
        let (low, high) = finite.fold((f32::MAX, f32::MIN), |(l, h), x| (l.min(x), h.max(x)));
        let (low, high) = if low <= high { (low, high) } else { (0.0, 0.0) };
        let offset = f32::midpoint(low, high);
        let scale = ((high - low) / 65534.0).max(f32::MIN_POSITIVE);
        let codes: Vec<i16> =
            points.iter().flatten().map(|x| ((x - offset) / scale).round() as i16).collect();
        Self {
            dtype: Dtype::Int16Scaled.into(),
            shape: shape.iter().map(|d| *d as u64).chain([3]).collect(),
            data: Bytes::copy_from_slice(bytemuck::cast_slice(&codes)),
            scale,
            offset,
        }
    }

    /// True if the field was left out.
    pub fn is_absent(&self) -> bool {
        self.shape.is_empty() && self.data.is_empty()
    }

    /// The shape, after checking that it and the type account for exactly the bytes present.
    ///
    /// # Errors
    /// If they do not.
    pub fn checked_shape(&self, name: &str) -> Result<Vec<usize>, TensorError> {
        let size = match self.dtype() {
            Dtype::Unspecified => {
                return Err(refused(name, format!("has the unknown dtype {}", self.dtype)));
            }
            Dtype::Float32 | Dtype::Uint32 | Dtype::Int32 => 4usize,
            Dtype::Float64 => 8,
            Dtype::Uint8 => 1,
            Dtype::Int16Scaled => 2,
        };
        let claimed = self.shape.iter().try_fold(size, |product, d| {
            usize::try_from(*d).ok().and_then(|d| product.checked_mul(d))
        });
        if claimed != Some(self.data.len()) {
            let fault = format!("has shape {:?} but {} bytes", self.shape, self.data.len());
            return Err(refused(name, fault));
        }
        Ok(self.shape.iter().map(|d| *d as usize).collect())
    }

    /// Reads all values; the shape is returned beside them.
    ///
    /// # Errors
    /// If the type is another one or shape and bytes disagree.
    pub fn unpack<T: Element>(&self, name: &str) -> Result<(Vec<usize>, Vec<T>), TensorError> {
        let shape = self.checked_shape(name)?;
        if self.dtype() != T::DTYPE {
            let fault = format!("has dtype {:?}, not {:?}", self.dtype(), T::DTYPE);
            return Err(refused(name, fault));
        }
        let values =
            self.data.chunks_exact(size_of::<T>()).map(bytemuck::pod_read_unaligned).collect();
        Ok((shape, values))
    }

    /// Reads points of shape [..., 3] (FLOAT32 or INT16_SCALED); the returned shape leaves out the
    /// 3.
    ///
    /// # Errors
    /// As [`Tensor::unpack`], and if the last dimension is not 3.
    pub fn unpack_points(&self, name: &str) -> Result<(Vec<usize>, Vec<[f32; 3]>), TensorError> {
        let mut shape = self.checked_shape(name)?;
        if shape.pop() != Some(3) {
            return Err(refused(name, format!("has shape {:?}, not [..., 3]", self.shape)));
        }
        let points = match self.dtype() {
            Dtype::Float32 => {
                self.data.chunks_exact(12).map(bytemuck::pod_read_unaligned).collect()
            }
            Dtype::Int16Scaled => self
                .data
                .chunks_exact(6)
                .map(|c| {
                    let codes: [i16; 3] = bytemuck::pod_read_unaligned(c);
                    codes.map(|q| f32::from(q) * self.scale + self.offset)
                })
                .collect(),
            other => {
                return Err(refused(name, format!("has dtype {other:?}, not FLOAT32")));
            }
        };
        Ok((shape, points))
    }
}

fn refused(name: &str, fault: String) -> TensorError {
    TensorError { name: name.to_owned(), fault }
}

#[cfg(test)]
mod tests;
