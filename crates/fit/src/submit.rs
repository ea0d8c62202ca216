//! Batches, handed to the device in slices: others who share it are served in between, and a
//! cancelled fit stops soon.

use std::{
    sync::atomic::{AtomicUsize, Ordering},
    thread,
};

use bendtwin_core::CancelToken;
use bendtwin_engine::{
    Backend,
    backend::{Error, Instance, Loss},
};
pub(crate) use bendtwin_eval::slice_len;

use crate::memory;

/// Losses of a batch, in order.
///
/// On a CPU two slices are under way at a time. Candidates need substeps in numbers that differ by
/// an order of magnitude, and threads would wait for the last instance of each slice. A GPU has one
/// slice at a time: instances that run together share its blocks.
pub(crate) fn losses(
    backend: &dyn Backend,
    batch: &[Instance],
    cancel: &CancelToken,
) -> Result<Vec<Loss>, Error> {
    let slice = slice_len(backend);
    let submit = |slice: &[Instance]| backend.losses(slice, cancel);
    match memory::lanes(backend).on_host {
        true => in_pairs(batch, slice, cancel, submit),
        false => sliced(batch, slice, cancel, submit),
    }
}

/// Results of a batch as [`sliced`] gives them, from two threads that take slice by slice.
fn in_pairs<T: Sync, R: Send>(
    batch: &[T],
    slice: usize,
    cancel: &CancelToken,
    submit: impl Fn(&[T]) -> Result<Vec<R>, Error> + Sync,
) -> Result<Vec<R>, Error> {
    let slices: Vec<&[T]> = batch.chunks(slice.max(1)).collect();
    let next = AtomicUsize::new(0);
    let take = || {
        let mut own = Vec::new();
        while let Some((at, slice)) = {
            let at = next.fetch_add(1, Ordering::Relaxed);
            slices.get(at).map(|slice| (at, slice))
        } {
            let result = if cancel.is_cancelled() { Err(Error::Cancelled) } else { submit(slice) };
            let failed = result.is_err();
            own.push((at, result));
            if failed {
                next.fetch_max(slices.len(), Ordering::Relaxed);
            }
        }
        own
    };
    let mut done = thread::scope(|scope| {
        let several = slices.len() > 1;
        // Where the system has no thread left, the caller's own takes all slices.
        let other =
            several.then(|| thread::Builder::new().spawn_scoped(scope, take).ok()).flatten();
        let mut done = take();
        match other.map(thread::ScopedJoinHandle::join) {
            Some(Ok(more)) => done.extend(more),
            Some(Err(panic)) => std::panic::resume_unwind(panic),
            None => {}
        }
        done
    });
    done.sort_by_key(|(at, _)| *at);
    let parts: Vec<Vec<R>> = done.into_iter().map(|(_, part)| part).collect::<Result<_, _>>()?;
    Ok(parts.into_iter().flatten().collect())
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

#[cfg(test)]
mod tests;
