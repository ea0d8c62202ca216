//! Rows of a copy of a store, which no server has open: what is only true of running processes goes.

use crate::{Result, sql::query};

/// Statements after which nothing is under way. Workers and servers of the original must not be taken for
/// those of its copy; jobs go back to the queue as if their workers had handed them back, with their
/// checkpoints; uploads under way have left no content in the copy.
const STATEMENTS: [&str; 9] = [
    "delete from workers",
    "delete from servers",
    "delete from arrivals",
    "delete from deletions",
    "delete from upload_parts",
    "delete from reservations",
    "update uploads set state = 'gone', why = 'it was under way in a backup: begin a new one',
         digest = null, request_id = null, holder = null, lease_until = null, multipart = null,
         tail = null, reserved_bytes = 0 where state = 'receiving'",
    "update jobs set state = 'cancelled', ended_at = started_at, checkpoint = null, worker = null,
         lease_until = null, revision = revision + 1
     where state = 'running' and kind = 'fit' and cancel_requested",
    "update jobs set state = 'queued', attempts = case when attempts > 0 then attempts - 1 else 0 end,
         stalled = case when stalled > 0 then stalled - 1 else 0 end, cancel_requested = false,
         worker = null, lease_until = null, revision = revision + 1
     where state = 'running'",
];

/// Brings all rows to rest.
pub(super) async fn bring(connection: &mut sqlx::SqliteConnection) -> Result<()> {
    for statement in STATEMENTS {
        query(statement).execute(&mut *connection).await?;
    }
    Ok(())
}
