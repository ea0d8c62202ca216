//! Work that takes a while, beside the tasks of the runtime.

use crate::error::{Error, Result};

/// Bytes of data up to which work is done in place.
const SMALL: u64 = 1 << 18;

/// Does work on `bytes` of data, on a separate thread if they are many.
pub(super) async fn beside<T: Send + 'static>(
    bytes: u64,
    work: impl FnOnce() -> T + Send + 'static,
) -> Result<T> {
    if bytes <= SMALL {
        return Ok(work());
    }
    let done = tokio::task::spawn_blocking(work).await;
    done.map_err(|e| Error::Internal(format!("the work of a plan: {e}")))
}
