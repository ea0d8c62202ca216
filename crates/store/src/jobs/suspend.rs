//! Jobs that go to the trash and come back. In the trash a job is in no queue and has no worker; its
//! checkpoint stays.

use bendtwin_core::ids::{CaptureId, FitId};

use super::{
    AttemptEnd, Job, JobId, Jobs, fits,
    row::{self, Row, State},
};
use crate::{
    Creator, Error, Result,
    keys::quotas::{self, More},
    sql::{Transaction, query},
};

impl Jobs<'_> {
    /// Takes the ingest of a capture that goes to the trash out of the queue, or from its worker.
    pub(crate) async fn suspend_ingest(
        &self,
        tx: &mut Transaction,
        capture: CaptureId,
    ) -> Result<Option<JobId>> {
        let key = capture.uuid().to_string();
        let Some(mut row) = row::ingest_of(tx, &key).await? else { return Ok(None) };
        let job = row.job()?;
        if row.state()? == State::Running {
            self.apply(tx, row, AttemptEnd::Released).await?;
            row = row::fetch(tx, job).await?;
        }
        self.suspend(tx, &row).await?;
        // An ingest goes and comes back with its capture.
        query(
            "update jobs set trashed_at = c.trashed_at, purge_at = c.purge_at
             from captures as c
             where jobs.id = $1 and c.id = jobs.capture",
        )
        .bind(&row.id)
        .execute(tx)
        .await?;
        Ok(Some(job))
    }

    /// Takes a fit that has gone to the trash out of the queue.
    ///
    /// # Errors
    /// [`Error::FitRunning`].
    pub(crate) async fn suspend_fit(&self, tx: &mut Transaction, fit: FitId) -> Result<JobId> {
        let row = row::fetch_any(tx, fit.into()).await?;
        if row.state()? == State::Running {
            return Err(Error::FitRunning { fit });
        }
        self.suspend(tx, &row).await?;
        Ok(fit.into())
    }

    async fn suspend(&self, tx: &mut Transaction, row: &Row) -> Result<()> {
        // Only the state `queued` is in the queue.
        query(
            "update jobs set revision = revision + 1,
                 restored_state = case when state = 'queued' then state end,
                 state = case when state = 'queued' then 'cancelled' else state end
             where id = $1",
        )
        .bind(&row.id)
        .execute(tx)
        .await?;
        Ok(())
    }

    /// Brings the ingest of a restored capture back.
    pub(crate) async fn resume_ingest(
        &self,
        tx: &mut Transaction,
        capture: CaptureId,
        creator: &Creator,
    ) -> Result<Option<Job>> {
        let key = capture.uuid().to_string();
        let Some(row) = row::ingest_of(tx, &key).await? else { return Ok(None) };
        let state = if row.restored_state.is_some() { State::Queued } else { row.state()? };
        self.resume(tx, row, state, creator).await.map(Some)
    }

    /// Brings a restored fit back. One that was queued waits again if its capture is there; like a new
    /// one it fails if the capture cannot be fitted.
    pub(crate) async fn resume_fit(
        &self,
        tx: &mut Transaction,
        fit: FitId,
        creator: &Creator,
    ) -> Result<Job> {
        let row = row::fetch_any(tx, fit.into()).await?;
        if row.restored_state.is_none() {
            let state = row.state()?;
            return self.resume(tx, row, state, creator).await;
        }
        let ingest = match row::ingest_of(tx, &row.capture).await?.map(Job::try_from) {
            None | Some(Err(Error::InTrash { .. })) => None,
            Some(ingest) => Some(ingest?),
        };
        let Some(ingest) = ingest else {
            return self.resume(tx, row, State::Cancelled, creator).await;
        };
        match fits::why_not(&ingest) {
            None => self.resume(tx, row, State::Queued, creator).await,
            Some(fault) => {
                query("update jobs set fault = $2 where id = $1")
                    .bind(&row.id)
                    .bind(row::to_json(&fault))
                    .execute(&mut *tx)
                    .await?;
                self.resume(tx, row, State::Failed, creator).await
            }
        }
    }

    async fn resume(
        &self,
        tx: &mut Transaction,
        row: Row,
        state: State,
        creator: &Creator,
    ) -> Result<Job> {
        if state == State::Queued {
            quotas::require(tx, creator, More::job()).await?;
        }
        let ends = state.has_ended() && row.restored_state.is_some();
        let now = ends.then(|| self.store.now_micros());
        let row: Row = query(
            "update jobs set state = $2, ended_at = coalesce($3, ended_at), trashed_at = null,
                 purge_at = null, trashed_by = null, restored_state = null,
                 revision = revision + 1
             where id = $1 returning *",
        )
        .bind(&row.id)
        .bind(state.as_str())
        .bind(now)
        .fetch_one(tx)
        .await?;
        row.try_into()
    }
}
