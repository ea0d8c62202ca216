//! Tensors of a request: type, shape and values, without copies.

use bendtwin_proto::v1::{Tensor, tensor::Dtype};

use super::Error;

/// A tensor that is given, or none if the field was left out.
pub(crate) fn given(tensor: Option<&Tensor>) -> Option<&Tensor> {
    tensor.filter(|t| !t.is_absent())
}

/// A tensor that must be given, of this type, and its shape, for which its bytes account.
pub(crate) fn required<'t>(
    tensor: Option<&'t Tensor>,
    field: &str,
    dtype: Dtype,
) -> Result<(&'t Tensor, Vec<u64>), Error> {
    let tensor = given(tensor).ok_or_else(|| Error::field(field, "is missing"))?;
    let shape = tensor.checked_shape(field)?;
    if tensor.dtype() != dtype {
        let (is, must) = (tensor.dtype().as_str_name(), dtype.as_str_name());
        return Err(Error::field(field, format!("has dtype {is}, not {must}")));
    }
    Ok((tensor, shape.into_iter().map(|d| d as u64).collect()))
}

/// Values of a checked FLOAT32 tensor.
pub(crate) fn floats(tensor: &Tensor) -> impl ExactSizeIterator<Item = f32> + '_ {
    tensor.data.as_chunks::<4>().0.iter().map(|b| f32::from_le_bytes(*b))
}

/// Values of a checked UINT32 tensor.
pub(crate) fn indices(tensor: &Tensor) -> impl ExactSizeIterator<Item = u32> + '_ {
    tensor.data.as_chunks::<4>().0.iter().map(|b| u32::from_le_bytes(*b))
}

/// Refuses the first value that is not finite.
pub(crate) fn finite(tensor: &Tensor, field: &str) -> Result<(), Error> {
    match floats(tensor).enumerate().find(|(_, v)| !v.is_finite()) {
        Some((i, value)) => {
            let fault = format!("value {i} (row-major) is {value}: all must be finite");
            Err(Error::field(field, fault))
        }
        None => Ok(()),
    }
}

/// A list of indices of points that is not empty.
pub(crate) fn index_list<'t>(tensor: Option<&'t Tensor>, field: &str) -> Result<&'t Tensor, Error> {
    let (tensor, shape) = required(tensor, field, Dtype::Uint32)?;
    match shape[..] {
        [count] if count > 0 => Ok(tensor),
        _ => Err(Error::field(field, format!("has shape {shape:?}, not [M] with M >= 1"))),
    }
}

/// Refuses the first index that is not a node of the twin.
pub(crate) fn known_nodes(tensor: &Tensor, field: &str, nodes: u64) -> Result<(), Error> {
    known(tensor, field, "node", nodes)
}

/// Refuses the first index that is not a point of the twin's skin. If their number is unknown, the
/// worker refuses it.
pub(crate) fn known_skin_points(
    tensor: &Tensor,
    field: &str,
    skin_points: Option<u64>,
) -> Result<(), Error> {
    skin_points.map_or(Ok(()), |count| known(tensor, field, "skin point", count))
}

fn known(tensor: &Tensor, field: &str, what: &str, count: u64) -> Result<(), Error> {
    match indices(tensor).find(|i| u64::from(*i) >= count) {
        Some(i) => {
            let fault = format!("names {what} {i}, the twin has {count} (counted from 0)");
            Err(Error::field(field, fault))
        }
        None => Ok(()),
    }
}
