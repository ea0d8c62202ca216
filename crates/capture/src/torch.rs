//! Archives of torch (`torch.save` since 1.6): a ZIP with a pickle and the bytes of each storage
//! beside it. Only tensors that are asked for are read.

use std::borrow::Cow;

use crate::{
    Error, Limits,
    array::{Array, byte_count},
    files::Files,
    pickle::{self, Dialect, Pickle, Tensor},
};

/// The pickle in an archive.
const PROGRAM: &str = "data.pkl";
/// Most bytes of it: tensors are not in it.
const MAX_PROGRAM: u64 = 64 << 20;

/// Opens an archive; returns its files and the bytes of its pickle. `at` is its name in messages.
///
/// # Errors
/// If it is no archive of torch, damaged, big-endian or beyond the limits.
pub(crate) fn open<'a>(
    at: &str,
    bytes: &'a [u8],
    limits: &Limits,
) -> Result<(Files<'a>, Vec<u8>), Error> {
    let damaged = |fault: &str| Error::Damaged { at: at.to_owned(), fault: fault.to_owned() };
    if !bytes.starts_with(b"PK") {
        return Err(damaged("it is no archive as torch writes them since version 1.6"));
    }
    let mut files = Files::from_bytes(at, bytes, limits)?;
    if !files.settle(|contents| contents.has(PROGRAM))? {
        return Err(damaged("it is an archive without a `data.pkl`, and so not of torch"));
    }
    if files.find("byteorder")?.is_some_and(|order| order != b"little") {
        return Err(damaged("its tensors are not little-endian"));
    }
    let program = files.find_within(PROGRAM, MAX_PROGRAM)?;
    let program = program.ok_or_else(|| damaged("its `data.pkl` is no file"))?;
    Ok((files, program))
}

/// Reads the pickle of an archive.
///
/// # Errors
/// If it asks for anything but tensors, containers and numbers, or is damaged.
pub(crate) fn read<'p>(
    at: &str,
    program: &'p [u8],
    files: &mut Files<'_>,
) -> Result<Pickle<'p>, Error> {
    pickle::read_dialect(at, program, Dialect::Torch, &files.limits, &mut files.budget)
}

/// The elements of a tensor of 32- or 64-bit floats; `at` is its name in messages.
///
/// # Errors
/// If its storage is missing or too short, or it is of another type, or not contiguous.
pub(crate) fn floats(
    at: &str,
    tensor: &Tensor<'_>,
    files: &mut Files<'_>,
) -> Result<Vec<f32>, Error> {
    let mut run = 1_usize;
    for (extent, stride) in tensor.shape.iter().zip(&tensor.stride).rev() {
        if *extent > 1 && *stride != run {
            let fault = "its elements do not follow one another: save it with `.contiguous()`";
            return Err(Error::Pickle { at: at.to_owned(), fault: fault.to_owned() });
        }
        run = run.saturating_mul(*extent);
    }
    let storage = files.read(&format!("data/{}", tensor.key))?;
    let size = tensor.dtype.size();
    let length = byte_count(&tensor.shape, tensor.dtype).and_then(|n| usize::try_from(n).ok());
    let bytes = tensor
        .offset
        .checked_mul(size)
        .zip(length)
        .and_then(|(start, length)| storage.get(start..start.checked_add(length)?));
    let Some(bytes) = bytes else {
        let claimed = length.map_or(u64::MAX, |n| n as u64);
        return Err(Error::Absurd { at: at.to_owned(), claimed, present: storage.len() as u64 });
    };
    let array = Array::new(at, tensor.dtype, tensor.shape.clone(), false, Cow::Borrowed(bytes))?;
    array.floats(&mut files.budget)
}
