//! The memory of this process, which requests take shares of before anything is allocated for them.
//!
//! Bodies, replies and uploads have separate budgets: a rollout that holds its body waits only for
//! a reply to end, and a reply waits for no other memory. So there are no deadlocks between them.

mod receive;

use std::{
    sync::{Arc, Mutex, MutexGuard, PoisonError},
    time::Duration,
};

use bendtwin_budget::{Budget, Share};
use bytes::Bytes;

use crate::error::{Error, Result};

pub(crate) use receive::{GRPC_PREFIX, Kind, ReceiveError};

/// Longest wait for memory that others hold.
const LONGEST_WAIT: Duration = Duration::from_secs(30);
/// Memory of a reply: as received from the worker, and as written to the client. The buffer
/// that it is written to may grow to twice its size.
const REPLY: u64 = 3;
/// Memory of a reply beside its message [bytes].
const REPLY_REST: u64 = 256 << 10;
/// Buffers of an upload [bytes].
const UPLOAD: u64 = 1 << 20;
/// Memory of a twin file: its bytes, and the arrays that are read from them.
const TWIN_FILE: u64 = 4;

/// The memory of a server. Clones share it.
#[derive(Clone, Debug)]
pub(crate) struct Memory {
    bodies: Budget,
    replies: Budget,
    uploads: Budget,
    longest_wait: Duration,
}

/// Shares of one request; dropping them gives them back.
#[derive(Debug, Default)]
pub(crate) struct Shares(Mutex<Vec<Share>>);

impl Shares {
    fn add(&self, share: Share) {
        self.lock().push(share);
    }

    /// Keeps the memory of a decoded message of `message_bytes`, and gives back the rest.
    pub(crate) fn decoded(&self, message_bytes: usize) {
        let mut left = (message_bytes as u64).saturating_mul(receive::PROTOBUF);
        for share in self.lock().iter_mut() {
            share.shrink(left);
            left = left.saturating_sub(share.bytes());
        }
    }

    fn lock(&self) -> MutexGuard<'_, Vec<Share>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Memory {
    /// A memory of `bytes` in all: three eighths for bodies, half for replies, an eighth for
    /// uploads.
    pub(crate) fn new(bytes: u64) -> Self {
        let part = |eighths: u64| Budget::new(bytes / 8 * eighths);
        let [bodies, replies, uploads] = [3, 4, 1].map(part);
        Self { bodies, replies, uploads, longest_wait: LONGEST_WAIT }
    }

    /// Bytes in use, and in all.
    pub(crate) fn state(&self) -> (u64, u64) {
        let all = [&self.bodies, &self.replies, &self.uploads];
        (all.map(Budget::used).iter().sum(), all.map(Budget::total).iter().sum())
    }

    /// Memory for a reply whose messages have at most `bytes`.
    pub(crate) async fn reply(&self, bytes: u64) -> Result<Share> {
        let bytes = bytes.saturating_mul(REPLY).saturating_add(REPLY_REST);
        self.take(&self.replies, bytes, "the reply: ask for fewer frames, nodes or instances").await
    }

    /// Memory for the plans simulated in a batch, of `bytes`: taken immediately or not at all,
    /// since the caller already holds a body.
    pub(crate) fn plan(&self, bytes: u64) -> Result<Share> {
        let purpose = "the plans of a batch: use fewer samples or knots";
        self.bodies.try_take(bytes).map_err(|exhausted| Error::Memory { purpose, exhausted })
    }

    /// Memory of an upload that streams to disk.
    pub(crate) async fn upload(&self) -> Result<Share> {
        self.take(&self.uploads, UPLOAD, "the upload: send fewer at a time").await
    }

    /// Memory of a resumable upload whose buffers are so large, or all that uploads have.
    pub(crate) async fn resumable_upload(&self, bytes: u64) -> Result<Share> {
        let bytes = bytes.clamp(UPLOAD, self.uploads.total().max(UPLOAD));
        self.take(&self.uploads, bytes, "the upload: send fewer at a time").await
    }

    /// Memory to read a twin file of `bytes`.
    pub(crate) async fn twin_file(&self, bytes: u64) -> Result<Share> {
        let advice = "reading the twin: raise memory_mib of the server";
        self.take(&self.bodies, bytes.saturating_mul(TWIN_FILE), advice).await
    }

    /// Memory to read the head of a report of `bytes`.
    pub(crate) async fn report(&self, bytes: u64) -> Result<Share> {
        self.take(&self.bodies, bytes, "reading the report: raise memory_mib of the server").await
    }

    /// A share, after a wait of bounded time in the order of arrival.
    async fn take(&self, budget: &Budget, bytes: u64, purpose: &'static str) -> Result<Share> {
        let taken = tokio::time::timeout(self.longest_wait, budget.take(bytes)).await;
        // The wait may have ended just when there was room.
        let taken = taken.unwrap_or_else(|_| budget.try_take(bytes));
        taken.map_err(|exhausted| Error::Memory { purpose, exhausted })
    }
}

/// A body and its memory.
#[derive(Clone, Debug)]
pub(crate) struct Received {
    pub(crate) bytes: Bytes,
    pub(crate) memory: Arc<Shares>,
}

#[cfg(test)]
mod tests;
