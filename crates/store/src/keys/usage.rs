//! Usage by owner: what is stored for whom, and the jobs of each. All of it is computed from the rows
//! themselves, by indexes that have owner and size, so there is no second account that could differ.
//!
//! What quotas compare is the same sum (`keys::quotas`). Equal content is one blob, and counts for
//! each resource that has it.

pub(crate) mod settle;

use std::collections::BTreeMap;

use crate::{
    Page, PageRequest, Quotas, Result, Store,
    keys::quotas::UPLOAD_BYTES,
    sql::{Builder, row::row},
};

/// Sizes by kind [bytes].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct StoredBytes {
    /// Archives of captures, and files that were added to captures.
    pub captures: u64,
    /// What ingests made of captures: observations, playbacks, masks and reports.
    pub derived: u64,
    /// Twin files.
    pub twins: u64,
    /// Checkpoints of jobs that have not ended.
    pub checkpoints: u64,
    /// Uploads under way: their declared sizes, else what has arrived or is set aside.
    pub uploads: u64,
}

impl StoredBytes {
    /// All of it.
    pub fn total(&self) -> u64 {
        let Self { captures, derived, twins, checkpoints, uploads } = *self;
        [captures, derived, twins, checkpoints, uploads].into_iter().fold(0, u64::saturating_add)
    }
}

/// Usage of one owner.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct OwnerUsage {
    /// Name of the owner; empty for what was made where no key is required.
    pub owner: String,
    /// Number of captures.
    pub captures: u64,
    /// Number of fits, ended ones included.
    pub fits: u64,
    /// Number of twins.
    pub twins: u64,
    /// Sizes of what is stored.
    pub stored: StoredBytes,
    /// Fits and ingests that wait for a worker.
    pub queued_jobs: u64,
    /// Fits and ingests that run.
    pub running_jobs: u64,
    /// Bounds on the owner: where several keys of it are valid, the widest.
    pub quotas: Quotas,
}

/// The usage of a store.
#[derive(Clone, Copy, Debug)]
pub struct Usage<'a> {
    pub(crate) store: &'a Store,
}

/// Sums by owner: a word, the bytes to sum up, the table, and a condition on its rows.
const SUMS: [(&str, &str, &str, &str); 10] = [
    ("captures", "size_bytes", "captures", "1 = 1"),
    ("derived", "derived_bytes", "captures", "1 = 1"),
    ("supplements", "size_bytes", "supplements", "1 = 1"),
    ("twins", "size_bytes", "twins", "1 = 1"),
    ("checkpoints", "checkpoint_bytes", "jobs", "checkpoint is not null"),
    ("fits", "0", "jobs", "kind = 'fit'"),
    ("queued", "0", "jobs", "kind in ('fit', 'ingest') and state = 'queued'"),
    ("running", "0", "jobs", "kind in ('fit', 'ingest') and state = 'running'"),
    ("uploads", UPLOAD_BYTES, "uploads", "state = 'receiving'"),
    ("reservations", "size_bytes", "reservations", "1 = 1"),
];

row! {
    struct Sum {
        owner: String,
        word: String,
        count: i64,
        bytes: i64,
    }
}

row! {
    struct Bounds {
        owner: String,
        max_queued_jobs: Option<i64>,
        max_stored_bytes: Option<i64>,
        max_rollouts: Option<i64>,
        max_running_jobs: Option<i64>,
        max_fit_run_s: Option<i64>,
        max_priority: Option<i64>,
    }
}

impl OwnerUsage {
    fn of(owner: &str) -> Self {
        Self { owner: owner.to_owned(), ..Self::default() }
    }

    fn add(&mut self, sum: &Sum) {
        let (count, bytes) = (sum.count.max(0) as u64, sum.bytes.max(0) as u64);
        let stored = &mut self.stored;
        match sum.word.as_str() {
            "captures" => (self.captures, stored.captures) = (count, stored.captures + bytes),
            "supplements" => stored.captures += bytes,
            "derived" => stored.derived = bytes,
            "twins" => (self.twins, stored.twins) = (count, bytes),
            "checkpoints" => stored.checkpoints = bytes,
            "fits" => self.fits = count,
            "queued" => self.queued_jobs = count,
            "running" => self.running_jobs = count,
            _ => stored.uploads += bytes,
        }
    }
}

impl Usage<'_> {
    /// Usage of one owner, without bounds: they are those of the key that is used.
    ///
    /// # Errors
    /// Database errors.
    pub async fn of(&self, owner: &str) -> Result<OwnerUsage> {
        let mut usage = OwnerUsage::of(owner);
        self.sums(Some(owner)).await?.iter().for_each(|sum| usage.add(sum));
        Ok(usage)
    }

    /// Usage of all owners, by name: of those who have something, and of those who have a valid key.
    /// Keys without a bound have that of `defaults`.
    ///
    /// # Errors
    /// Database errors.
    pub async fn all(&self, defaults: &Quotas) -> Result<Vec<OwnerUsage>> {
        let mut owners: BTreeMap<String, OwnerUsage> = BTreeMap::new();
        for sum in self.sums(None).await? {
            let usage = owners.entry(sum.owner.clone());
            usage.or_insert_with(|| OwnerUsage::of(&sum.owner)).add(&sum);
        }
        let mut bounds: BTreeMap<String, Quotas> = BTreeMap::new();
        for (owner, quotas) in self.bounds().await? {
            let quotas = quotas.or(defaults);
            bounds.entry(owner).and_modify(|all| *all = all.widest(&quotas)).or_insert(quotas);
        }
        for (owner, quotas) in bounds {
            let usage = owners.entry(owner.clone()).or_insert_with(|| OwnerUsage::of(&owner));
            usage.quotas = quotas;
        }
        Ok(owners.into_values().collect())
    }

    /// A page of [`Usage::all`].
    ///
    /// # Errors
    /// [`Error::InvalidPageToken`](crate::Error::InvalidPageToken), database errors.
    pub async fn list(&self, defaults: &Quotas, page: &PageRequest) -> Result<Page<OwnerUsage>> {
        Page::of_sorted(self.all(defaults).await?, page, "usage", |usage| usage.owner.clone())
    }

    async fn sums(&self, owner: Option<&str>) -> Result<Vec<Sum>> {
        let mut sql = Builder::new("");
        for (nth, (word, bytes, table, condition)) in SUMS.into_iter().enumerate() {
            sql.push(if nth == 0 { "" } else { " union all " });
            sql.push(format_args!(
                "select owner, '{word}' as word, count(*) as count,
                     cast(coalesce(sum({bytes}), 0) as bigint) as bytes
                 from {table} where {condition}"
            ));
            if let Some(owner) = owner {
                sql.push(" and owner = ").push_bind(owner);
            }
            sql.push(" group by owner");
        }
        sql.build().fetch_all(self.store.inner.database.read()).await
    }

    /// Owners of valid keys, with the bounds of each. Shares have no bounds.
    async fn bounds(&self) -> Result<Vec<(String, Quotas)>> {
        let mut sql = Builder::new(
            "select owner, max_queued_jobs, max_stored_bytes, max_rollouts, max_running_jobs,
                 max_fit_run_s, max_priority from keys
             where twin is null and revoked_at is null and (expires_at is null or expires_at > ",
        );
        sql.push_bind(self.store.now_micros()).push(")");
        let rows: Vec<Bounds> = sql.build().fetch_all(self.store.inner.database.read()).await?;
        let bound = |n: Option<i64>| n.map(|n| n.max(0) as u64);
        let quotas = |row: Bounds| {
            let quotas = Quotas {
                queued_jobs: bound(row.max_queued_jobs),
                stored_bytes: bound(row.max_stored_bytes),
                rollouts: bound(row.max_rollouts),
                running_jobs: bound(row.max_running_jobs),
                fit_run_s: bound(row.max_fit_run_s),
                priority: row.max_priority.and_then(|n| u32::try_from(n).ok()),
            };
            (row.owner, quotas)
        };
        Ok(rows.into_iter().map(quotas).collect())
    }
}

#[cfg(test)]
mod tests;
