//! A row of `jobs` and its decoding.

use std::time::Duration;

use bendtwin_core::{Progress, quality::Measure};

use uuid::Uuid;

use super::{Job, JobId, Kind, Lease, Requirements};
use crate::{
    Digest, Error, Labels, Result, labels,
    owners::request_ids::{self, RequestId},
    sql::{Transaction, query, query_scalar, row::row},
    store::clock::from_micros,
    trash::{self, Remove},
};

/// State of a job.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum State {
    /// Waits for a worker.
    Queued,
    /// A worker holds its lease.
    Running,
    /// Ended with a twin.
    Succeeded,
    /// Ended with a fault.
    Failed,
    /// Ended by a cancellation.
    Cancelled,
}

impl State {
    /// Name of the state in the database and in metrics.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Queued => "queued",
            Self::Running => "running",
            Self::Succeeded => "succeeded",
            Self::Failed => "failed",
            Self::Cancelled => "cancelled",
        }
    }

    /// True if the state is final.
    pub fn has_ended(self) -> bool {
        matches!(self, Self::Succeeded | Self::Failed | Self::Cancelled)
    }

    pub(super) fn parse(word: &str) -> Option<Self> {
        [Self::Queued, Self::Running, Self::Succeeded, Self::Failed, Self::Cancelled]
            .into_iter()
            .find(|s| s.as_str() == word)
    }
}

row! {
    pub(super) struct Row {
        pub(super) id: String,
        kind: String,
        pub(super) capture: String,
        state: String,
        pub(super) priority: i64,
        settings: String,
        pub(super) attempts: i64,
        pub(super) stalled: i64,
        pub(super) interrupted: i64,
        pub(super) furthest: f64,
        pub(super) lease_epoch: i64,
        pub(super) lease_until: Option<i64>,
        pub(super) worker: Option<String>,
        pub(super) progress: Option<String>,
        pub(super) checkpoint: Option<String>,
        pub(super) cancel_requested: bool,
        pub(super) twin: Option<String>,
        fault: Option<String>,
        pub(super) attempt_faults: String,
        pub(super) masks_only: bool,
        trace_parent: Option<String>,
        pub(super) request_id: Option<String>,
        created_at: i64,
        started_at: Option<i64>,
        ended_at: Option<i64>,
        pub(super) revision: i64,
        pub(super) display_name: String,
        note: String,
        tags: String,
        first_name: Option<String>,
        error_m: f64,
        measure: Option<String>,
        pub(super) loss_stride: i64,
        pub(super) owner: String,
        pub(super) requirements: String,
        pub(super) run_us: i64,
        pub(super) slice_us: i64,
        pub(super) idle_us: i64,
        pub(super) yield_us: Option<i64>,
        pub(super) fruitless: i64,
        pub(super) max_run_s: Option<i64>,
        trashed_at: Option<i64>,
        purge_at: Option<i64>,
        pub(super) restored_state: Option<String>,
    }
}

impl Row {
    pub(super) fn state(&self) -> Result<State> {
        State::parse(&self.state).ok_or_else(|| self.corrupt("state"))
    }

    pub(super) fn kind(&self) -> Result<Kind> {
        Kind::parse(&self.kind).ok_or_else(|| self.corrupt("kind"))
    }

    /// The fencing number.
    pub(super) fn epoch(&self) -> u64 {
        self.lease_epoch.max(0) as u64
    }

    /// True if the job's last claim had the epoch of this lease, at whichever worker.
    pub(super) fn has_epoch_of(&self, lease: Lease) -> bool {
        self.lease_epoch == i64::try_from(lease.epoch).unwrap_or(-1)
    }

    /// True if the job runs under this very lease.
    fn runs_under(&self, lease: Lease) -> Result<bool> {
        let has_worker = self.worker == Some(lease.worker.uuid().to_string());
        Ok(self.state()? == State::Running && self.has_epoch_of(lease) && has_worker)
    }

    /// The name that was given when it was created; empty if none was.
    pub(super) fn first_name(&self) -> &str {
        self.first_name.as_deref().unwrap_or_default()
    }

    /// Id of the job.
    pub(super) fn job(&self) -> Result<JobId> {
        let kind = Kind::parse(&self.kind).ok_or_else(|| self.corrupt("kind"))?;
        let id = Uuid::try_parse(&self.id).map_err(|_| self.corrupt("an id"))?;
        Ok(JobId::new(kind, id))
    }

    /// True if a removal is of such jobs.
    pub(super) fn is_among(&self, which: Remove) -> bool {
        which.is_any() || self.purge_at.is_some_and(|at| at <= which.until())
    }

    /// Refuses a job in the trash.
    fn require_kept(&self) -> Result<()> {
        trash::refuse(self.job()?, self.trashed_at, self.purge_at)
    }

    fn corrupt(&self, fault: &str) -> Error {
        Error::CorruptRow { name: format!("{}s/{}", self.kind, self.id), fault: fault.to_owned() }
    }

    fn json<T: serde::de::DeserializeOwned>(&self, text: &Option<String>) -> Result<Option<T>> {
        let Some(text) = text else { return Ok(None) };
        serde_json::from_str(text).map(Some).map_err(|e| self.corrupt(&e.to_string()))
    }
}

impl TryFrom<Row> for Job {
    type Error = Error;
    fn try_from(row: Row) -> Result<Self> {
        row.require_kept()?;
        let uuid = |text: &String| Uuid::try_parse(text).map_err(|_| row.corrupt("an id"));
        let state = row.state()?;
        let mut progress: Option<Progress> = row.json(&row.progress)?;
        if state == State::Succeeded {
            // The worker's last report came before the end of its attempt.
            progress.iter_mut().for_each(|p| (p.fraction, p.eta_s) = (1.0, Some(0.0)));
        }
        Ok(Self {
            id: row.job()?,
            capture: uuid(&row.capture)?.into(),
            state,
            priority: i32::try_from(row.priority).unwrap_or_default(),
            attempts: u32::try_from(row.attempts).unwrap_or_default(),
            lease_epoch: row.epoch(),
            lease_until: row.lease_until.map(from_micros),
            worker: row.worker.as_ref().map(uuid).transpose()?.map(Into::into),
            progress,
            checkpoint: match &row.checkpoint {
                Some(hex) => Some(Digest::from_hex(hex).map_err(|_| row.corrupt("checkpoint"))?),
                None => None,
            },
            cancel_requested: row.cancel_requested,
            masks_only: row.masks_only,
            twin: row.twin.as_ref().map(uuid).transpose()?.map(Into::into),
            fault: row.json(&row.fault)?,
            attempt_faults: serde_json::from_str(&row.attempt_faults)
                .map_err(|e| row.corrupt(&e.to_string()))?,
            requirements: Requirements::from_text(&row.requirements)
                .map_err(|e| row.corrupt(&e.to_string()))?,
            created: from_micros(row.created_at),
            started: row.started_at.map(from_micros),
            ended: row.ended_at.map(from_micros),
            revision: row.revision.max(0) as u64,
            labels: Labels::of_row(row.display_name, row.note, &row.tags),
            error_m: labels::error_of(row.error_m),
            measure: row.measure.as_deref().and_then(Measure::parse),
            owner: row.owner,
            run: Duration::from_micros(row.run_us.max(0) as u64),
            settings: row.settings,
            trace_parent: row.trace_parent,
            request_id: row.request_id.as_deref().map(request_ids::given).map(str::to_owned),
        })
    }
}

/// The row of a job that is not in the trash, within a transaction.
pub(super) async fn fetch(tx: &mut Transaction, id: JobId) -> Result<Row> {
    let row = fetch_any(tx, id).await?;
    row.require_kept()?;
    Ok(row)
}

/// The row of a job, also of one in the trash.
pub(super) async fn fetch_any(tx: &mut Transaction, id: JobId) -> Result<Row> {
    let row: Option<Row> = query("select * from jobs where id = $1 and kind = $2")
        .bind(id.uuid().to_string())
        .bind(id.kind().as_str())
        .fetch_optional(&mut *tx)
        .await?;
    row.ok_or_else(|| Error::NotFound { name: id.to_string() })
}

/// The row of a job, if it runs under this very lease.
pub(super) async fn fetch_leased(tx: &mut Transaction, lease: Lease) -> Result<Row> {
    let row = fetch(tx, lease.job).await?;
    if row.runs_under(lease)? { Ok(row) } else { Err(lease.stale()) }
}

/// The job that a request made.
pub(super) async fn requested(tx: &mut Transaction, request: RequestId<'_>) -> Result<Option<Row>> {
    request.find(tx, "*", "jobs").await
}

/// The ingest of a capture.
pub(super) async fn ingest_of(tx: &mut Transaction, capture: &str) -> Result<Option<Row>> {
    let row = query("select * from jobs where capture = $1 and kind = 'ingest'")
        .bind(capture)
        .fetch_optional(&mut *tx)
        .await?;
    Ok(row)
}

/// Number of fits of a capture that are queued or running.
pub(crate) async fn fits_under_way(tx: &mut Transaction, capture: &str) -> Result<u64> {
    let fits: i64 = query_scalar(
        "select count(*) from jobs
         where capture = $1 and kind = 'fit' and state in ('queued', 'running')",
    )
    .bind(capture)
    .fetch_one(&mut *tx)
    .await?;
    Ok(fits.max(0) as u64)
}

pub(super) fn to_json(value: &impl serde::Serialize) -> String {
    // Faults are strings: they always serialise.
    serde_json::to_string(value).unwrap_or_default()
}
