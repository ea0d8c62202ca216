//! Batches, handed to the device in slices: others who share it are served in between, and a
//! cancelled fit stops soon.

use bendtwin_core::CancelToken;
use bendtwin_engine::{
    Backend,
    backend::{Error, Instance, Loss},
};
pub(crate) use bendtwin_eval::slice_len;

pub(crate) fn losses(
    backend: &dyn Backend,
    batch: &[Instance],
    cancel: &CancelToken,
) -> Result<Vec<Loss>, Error> {
    sliced(batch, slice_len(backend), cancel, |slice| backend.losses(slice, cancel))
}

/// Results of a batch that is handed over in slices of `slice` instances, in order.
pub(crate) fn sliced<T, R>(
    batch: &[T],
    slice: usize,
    cancel: &CancelToken,
    mut submit: impl FnMut(&[T]) -> Result<Vec<R>, Error>,
) -> Result<Vec<R>, Error> {
    let mut results = Vec::with_capacity(batch.len());
    for slice in batch.chunks(slice.max(1)) {
        if cancel.is_cancelled() {
            return Err(Error::Cancelled);
        }
        results.extend(submit(slice)?);
    }
    Ok(results)
}
