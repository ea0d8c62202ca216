//! Batches, handed to the device in slices: others who share it are served in between, and a
//! cancelled fit stops soon.

use bendtwin_engine::{
    Backend,
    backend::{CancelToken, Error, Gradient, GradientRequest, Instance, Loss},
};
use bendtwin_eval::slice_len;

pub(crate) fn losses(
    backend: &dyn Backend,
    batch: &[Instance],
    cancel: &CancelToken,
) -> Result<Vec<Loss>, Error> {
    sliced(backend, batch, cancel, |slice| backend.losses(slice, cancel))
}

pub(crate) fn gradients(
    backend: &dyn Backend,
    batch: &[Instance],
    request: &GradientRequest,
    cancel: &CancelToken,
) -> Result<Vec<Gradient>, Error> {
    sliced(backend, batch, cancel, |slice| backend.gradients(slice, request, cancel))
}

fn sliced<R>(
    backend: &dyn Backend,
    batch: &[Instance],
    cancel: &CancelToken,
    submit: impl Fn(&[Instance]) -> Result<Vec<R>, Error>,
) -> Result<Vec<R>, Error> {
    let mut results = Vec::with_capacity(batch.len());
    for slice in batch.chunks(slice_len(backend)) {
        if cancel.is_cancelled() {
            return Err(Error::Cancelled);
        }
        results.extend(submit(slice)?);
    }
    Ok(results)
}
