//! Values of tensors that are the same for all slots, or differ.

use bendtwin_proto::v1::Tensor;

use crate::error::Error;

/// A value for all slots, or one for each.
#[derive(Clone, Debug)]
pub(super) struct PerSlot<T>(Vec<T>);

impl<T: Copy> PerSlot<T> {
    /// The same value for all slots.
    pub(super) fn all(value: T) -> Self {
        Self(vec![value])
    }

    /// The value of a slot, by its place in the request.
    pub(super) fn of(&self, slot: usize) -> T {
        if self.0.len() == 1 { self.0[0] } else { self.0[slot] }
    }
}

impl<const N: usize> PerSlot<[f32; N]> {
    /// Reads a checked FLOAT32 tensor with N numbers for all slots or for each.
    ///
    /// # Errors
    /// If it is not what the check saw.
    pub(super) fn floats(tensor: &Tensor, field: &str) -> Result<Self, Error> {
        let (_, values) = tensor.unpack::<f32>(field)?;
        Self::some(values.as_chunks::<N>().0.to_vec(), field)
    }
}

impl PerSlot<[u8; 3]> {
    /// Reads colours of a checked UINT8 tensor.
    ///
    /// # Errors
    /// If it is not what the check saw.
    pub(super) fn colors(tensor: &Tensor, field: &str) -> Result<Self, Error> {
        let (_, values) = tensor.unpack::<u8>(field)?;
        Self::some(values.as_chunks::<3>().0.to_vec(), field)
    }
}

impl<T> PerSlot<T> {
    fn some(values: Vec<T>, field: &str) -> Result<Self, Error> {
        if values.is_empty() {
            return Err(Error::field(field, "is empty"));
        }
        Ok(Self(values))
    }
}
