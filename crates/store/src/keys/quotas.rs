//! Bounds on what the owner of a key may have, compared within the transaction that makes more of
//! it or sets bytes aside for it, so that two calls at a time do not exceed them together.
//!
//! Bytes are compared before they are received. Content of a declared size has all of it set aside
//! before its first byte, other content in steps that are ahead of its bytes: those of a resumable
//! upload in its row, those of content that comes in one request in a [reservation].
//! What has been set aside is not compared again when the content is complete.

pub(crate) mod reservation;

use crate::{
    Error, Result,
    sql::{Transaction, query_scalar},
};

/// Bounds for one owner; `None` for no bound.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Quotas {
    /// Jobs that wait for a worker.
    pub queued_jobs: Option<u64>,
    /// Size of everything that is stored for the owner ([`StoredBytes`](crate::StoredBytes))
    /// [bytes].
    pub stored_bytes: Option<u64>,
    /// Rollouts, plans, registrations and evaluations under way at one server.
    pub rollouts: Option<u64>,
    /// Jobs that run at workers: claims pass over the owner's others.
    pub running_jobs: Option<u64>,
    /// Time for which one fit may run, over all attempts [s].
    pub fit_run_s: Option<u64>,
    /// Highest priority of a fit. The meaning of `None` is for others to decide.
    pub priority: Option<u32>,
}

impl Quotas {
    /// These bounds, and those of `defaults` where these have none.
    #[must_use]
    pub fn or(self, defaults: &Self) -> Self {
        Self {
            queued_jobs: self.queued_jobs.or(defaults.queued_jobs),
            stored_bytes: self.stored_bytes.or(defaults.stored_bytes),
            rollouts: self.rollouts.or(defaults.rollouts),
            running_jobs: self.running_jobs.or(defaults.running_jobs),
            fit_run_s: self.fit_run_s.or(defaults.fit_run_s),
            priority: self.priority.or(defaults.priority),
        }
    }

    /// The wider of both bounds each.
    #[must_use]
    pub(crate) fn widest(self, other: &Self) -> Self {
        let widest = |a: Option<u64>, b: Option<u64>| a.zip(b).map(|(a, b)| a.max(b));
        Self {
            queued_jobs: widest(self.queued_jobs, other.queued_jobs),
            stored_bytes: widest(self.stored_bytes, other.stored_bytes),
            rollouts: widest(self.rollouts, other.rollouts),
            running_jobs: widest(self.running_jobs, other.running_jobs),
            fit_run_s: widest(self.fit_run_s, other.fit_run_s),
            // Without a bound it is that of the scopes, which differs.
            priority: self.priority.max(other.priority),
        }
    }
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
#[derive(Clone, Debug, Default)]
pub(crate) struct More {
    pub(crate) jobs: u64,
    pub(crate) bytes: u64,
    /// Id of the resumable upload or the reservation that has set bytes aside for it.
    pub(crate) held: Option<String>,
}

impl More {
    /// A job that needs no content of its owner. It is going to store results, so there must be
    /// room for a byte.
    pub(crate) fn job() -> Self {
        Self { jobs: 1, bytes: 1, held: None }
    }
}

/// Bytes that a resumable upload under way counts for, in SQL.
pub(crate) const UPLOAD_BYTES: &str = "case when length_bytes is not null then length_bytes
     when reserved_bytes > offset_bytes then reserved_bytes else offset_bytes end";

/// A bound as the database has it.
pub(crate) fn as_integer(bound: u64) -> i64 {
    i64::try_from(bound).unwrap_or(i64::MAX)
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
    let held = more.held.as_deref();
    if more.bytes > 0 && more.bytes > held_bytes(tx, held).await? {
        grant(tx, creator, held, more.bytes..=more.bytes).await?;
    }
    Ok(())
}

/// Bytes that an owner may have set aside in all for content, as many of these as there is room for
/// beside what else is stored; `held` is the id of the upload or the reservation of the content.
///
/// # Errors
/// [`Error::QuotaBytes`] if that is less than the first.
pub(crate) async fn grant(
    tx: &mut Transaction,
    creator: &Creator,
    held: Option<&str>,
    bytes: std::ops::RangeInclusive<u64>,
) -> Result<u64> {
    let (needed, wanted) = bytes.into_inner();
    let Some(limit) = creator.quotas.stored_bytes else { return Ok(wanted) };
    let stored = stored_beside(tx, &creator.owner, held).await?;
    let room = limit.saturating_sub(stored);
    if needed > room {
        let owner = creator.owner.clone();
        return Err(Error::QuotaBytes { owner, stored, more: needed, limit });
    }
    Ok(wanted.min(room))
}

/// Bytes that are stored or set aside for an owner, but for those of one upload or reservation.
async fn stored_beside(tx: &mut Transaction, owner: &str, held: Option<&str>) -> Result<u64> {
    let sum = format!(
        "select cast(
             coalesce((select sum(size_bytes) + sum(derived_bytes) from captures
                 where owner = $1), 0)
             + coalesce((select sum(size_bytes) from supplements where owner = $1), 0)
             + coalesce((select sum(size_bytes) from twins where owner = $1), 0)
             + coalesce((select sum(checkpoint_bytes) from jobs
                 where owner = $1 and checkpoint is not null), 0)
             + coalesce((select sum({UPLOAD_BYTES}) from uploads
                 where owner = $1 and state = 'receiving' and id <> $2), 0)
             + coalesce((select sum(size_bytes) from reservations
                 where owner = $1 and id <> $2), 0) as bigint)"
    );
    let sum = query_scalar(sqlx::AssertSqlSafe(sum)).bind(owner).bind(held.unwrap_or_default());
    let stored: i64 = sum.fetch_one(tx).await?;
    Ok(stored.max(0) as u64)
}

/// Bytes that an upload or a reservation has set aside.
async fn held_bytes(tx: &mut Transaction, held: Option<&str>) -> Result<u64> {
    let Some(id) = held else { return Ok(0) };
    let found = format!(
        "select cast(coalesce(
             (select {UPLOAD_BYTES} from uploads where id = $1 and state = 'receiving'),
             (select size_bytes from reservations where id = $1), 0) as bigint)"
    );
    let bytes: i64 = query_scalar(sqlx::AssertSqlSafe(found)).bind(id).fetch_one(tx).await?;
    Ok(bytes.max(0) as u64)
}

#[cfg(test)]
mod tests;
