//! Calls that failed before they reached their worker. Others are not repeated elsewhere.

use std::error::Error;

use tonic::{ConnectError, Status};

/// True if the call ended before the worker took it: no connection came about, or the one that was
/// there had ended before the call was sent on it.
pub(super) fn was_not_taken(status: &Status) -> bool {
    let mut source = status.source();
    while let Some(error) = source {
        if error.is::<ConnectError>() {
            return true;
        }
        if let Some(error) = error.downcast_ref::<hyper::Error>()
            && (error.is_canceled() || error.is_closed())
        {
            return true;
        }
        source = error.source();
    }
    false
}
