//! Work that takes a while, beside the tasks of the runtime.

use crate::failure::{Error, Result};

/// Bytes of data whose work is done at once.
const SMALL: u64 = 1 << 18;

/// Does work on so many bytes of data, on a thread of its own if they are many.
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
