//! Bounds on what the owner of a key may have, compared within the transaction that makes more of
//! it, so that two calls at a time do not exceed them together.

use bendtwin_core::ids::UploadId;

use crate::{
    Error, Result,
    sql::{Transaction, query_scalar},
};

/// Bounds for one owner; `None` for no bound.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Quotas {
    /// Jobs that wait for a worker.
    pub queued_jobs: Option<u64>,
    /// Size of captures with their supplements, twin files and uploads under way [bytes].
    pub stored_bytes: Option<u64>,
    /// Rollouts, plans, registrations and evaluations under way at one server.
    pub rollouts: Option<u64>,
}

/// Maker of something: its owner from then on, and the bounds on what that owner may have.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Creator {
    /// Name of the owner; empty if it is not known.
    pub owner: String,
    /// Bounds of the key that is used.
    pub quotas: Quotas,
}

/// Things about to be made.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct More {
    pub(crate) jobs: u64,
    pub(crate) bytes: u64,
    /// The upload that it is made of, which is counted no more.
    pub(crate) upload: Option<UploadId>,
}

/// Refuses more than an owner may have.
pub(crate) async fn require(tx: &mut Transaction, creator: &Creator, more: More) -> Result<()> {
    let Creator { owner, quotas } = creator;
    if let Some(limit) = quotas.queued_jobs.filter(|_| more.jobs > 0) {
        let queued: i64 = query_scalar(
            "select count(*) from jobs
             where kind in ('fit', 'ingest') and state = 'queued' and owner = $1",
        )
        .bind(owner)
        .fetch_one(&mut *tx)
        .await?;
        let queued = queued.max(0) as u64;
        if queued.saturating_add(more.jobs) > limit {
            return Err(Error::QuotaJobs { owner: owner.clone(), queued, limit });
        }
    }
    if let Some(limit) = quotas.stored_bytes.filter(|_| more.bytes > 0) {
        let stored: i64 = query_scalar(
            "select cast(
                 coalesce((select sum(size_bytes) from captures where owner = $1), 0)
                 + coalesce((select sum(size_bytes) from supplements where owner = $1), 0)
                 + coalesce((select sum(size_bytes) from twins where owner = $1), 0)
                 + coalesce((select sum(offset_bytes) from uploads
                     where owner = $1 and state = 'receiving' and id <> $2), 0) as bigint)",
        )
        .bind(owner)
        .bind(more.upload.map(|id| id.uuid().to_string()).unwrap_or_default())
        .fetch_one(&mut *tx)
        .await?;
        let stored = stored.max(0) as u64;
        if stored.saturating_add(more.bytes) > limit {
            let owner = owner.clone();
            return Err(Error::QuotaBytes { owner, stored, more: more.bytes, limit });
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests;
