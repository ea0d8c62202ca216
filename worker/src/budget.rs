//! The memory of a worker process. Its parts:
//!
//! | part | share | held by |
//! |---|---|---|
//! | requests | 1/8 | rollout requests, from before they are read to their end |
//! | rollouts | 1/4 | what rollouts unpack and compute, and their replies until they are sent |
//! | twins | 3/32 | loaded twins, and what is kept of replayed captures |
//! | sessions | 1/32 | states and rest shapes of sessions |
//! | fits | 1/2 | the fit under way: [`Limits::fit_bytes`](crate::Limits), which may be set apart |
//!
//! A request that waits for a part holds no part that comes after it in this table, so there are no
//! deadlocks. The process that reads a capture has a separate limit.

use std::time::Duration;

use bendtwin_budget::{Budget, Share};

use crate::rollout::Error;

/// Longest wait for memory that others hold. Rollouts before may take a while.
const LONGEST_WAIT: Duration = Duration::from_secs(30);
/// Memory of the machine where it is not known [bytes].
const UNKNOWN_MACHINE: u64 = 4 << 30;

/// The memory of a worker. Clones share it.
#[derive(Clone, Debug)]
pub(crate) struct Memory {
    pub(crate) requests: Budget,
    pub(crate) rollouts: Budget,
    pub(crate) twins: Budget,
    pub(crate) sessions: Budget,
    /// Memory of the data kept of replayed captures, for each of the two kinds [bytes].
    pub(crate) kept_bytes: u64,
}

impl Memory {
    /// A memory of `bytes` in all.
    pub(crate) fn new(bytes: u64) -> Self {
        let eighth = bytes / 8;
        Self {
            requests: Budget::new(eighth),
            rollouts: Budget::new(2 * eighth),
            twins: Budget::new(eighth / 2),
            sessions: Budget::new(eighth / 4),
            kept_bytes: eighth / 8,
        }
    }
}

/// Half of the machine's memory, or of the control group's [bytes]: the rest is for the server, for
/// the process that reads captures, and for the files that the system keeps at hand.
pub(crate) fn default_bytes() -> u64 {
    bendtwin_budget::machine_bytes().unwrap_or(UNKNOWN_MACHINE) / 2
}

/// A share, after a wait of bounded time in the order of arrival.
pub(crate) async fn take(
    budget: &Budget,
    bytes: u64,
    purpose: &'static str,
) -> Result<Share, Error> {
    let taken = tokio::time::timeout(LONGEST_WAIT, budget.take(bytes)).await;
    // The wait may have ended just when there was room.
    let taken = taken.unwrap_or_else(|_| budget.try_take(bytes));
    taken.map_err(|exhausted| Error::Memory { purpose, exhausted })
}
