//! Statements that a connection has prepared, and that no longer fit their tables: another server, of
//! a newer version, has added a column. PostgreSQL refuses them from then on (`cached plan must not
//! change result type`), so connections from before are replaced.

use std::{
    sync::{Mutex, PoisonError},
    time::{Duration, Instant},
};

/// Last time at which a statement was refused.
static REFUSED: Mutex<Option<Instant>> = Mutex::new(None);

/// Notes that a statement was refused.
pub(crate) fn refused() {
    *REFUSED.lock().unwrap_or_else(PoisonError::into_inner) = Some(Instant::now());
}

/// True if a connection of this age may have statements that are refused.
pub(super) fn are_stale(age: Duration) -> bool {
    let refused = *REFUSED.lock().unwrap_or_else(PoisonError::into_inner);
    refused.is_some_and(|refused| age >= refused.elapsed())
}
