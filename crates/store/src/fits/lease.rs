//! What workers do to jobs. Every write is fenced by the lease's epoch.

use std::time::Duration;

use bendtwin_core::{
    Progress,
    ids::{FitId, TwinId, WorkerId},
};
use tokio::time::Instant;
use uuid::Uuid;

use super::{
    Fit, Fits,
    row::{self, Row, State},
};
use crate::{
    Content, Digest, Error, Result, Staged, TwinFacts, clock::micros_after, failpoint::Failpoint,
    twins,
};

/// The right of one worker to write to one job, until another claims it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Lease {
    /// The job.
    pub fit: FitId,
    /// The fencing number.
    pub epoch: u64,
}

/// What a worker learns when it reports.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Reported {
    /// Whether the job has been asked to stop.
    pub cancel_requested: bool,
}

impl Fits<'_> {
    /// Takes the next job, if there is one.
    ///
    /// # Errors
    /// Database errors.
    pub async fn claim(&self, worker: WorkerId, lease: Duration) -> Result<Option<Fit>> {
        let now = self.store.now();
        let mut tx = self.store.inner.database.write().await?;
        let row: Option<Row> = sqlx::query_as(
            "update jobs set state = 'running', worker = $1, lease_epoch = lease_epoch + 1,
                 lease_until = $3, attempts = attempts + 1, stalled = stalled + 1,
                 started_at = coalesce(started_at, $2), revision = revision + 1
             where id = (select id from jobs where state = 'queued' and kind = 'fit'
                         order by priority desc, created_at, id limit 1)
             returning *",
        )
        .bind(worker.uuid().to_string())
        .bind(self.store.now_micros())
        .bind(micros_after(now, lease))
        .fetch_optional(&mut *tx)
        .await?;
        let Some(row) = row else { return Ok(None) };
        self.store.pass(Failpoint::BeforeCommit)?;
        tx.commit().await?;
        let fit = Fit::try_from(row)?;
        self.changed(&fit);
        self.store.pass(Failpoint::AfterCommit)?;
        Ok(Some(fit))
    }

    /// Takes the next job, waiting up to `wait` for one.
    ///
    /// # Errors
    /// Database errors.
    pub async fn claim_within(
        &self,
        worker: WorkerId,
        lease: Duration,
        wait: Duration,
    ) -> Result<Option<Fit>> {
        let deadline = Instant::now() + wait;
        loop {
            // Listen first, look second: a job queued in between is not missed.
            let mut queued = std::pin::pin!(self.store.inner.queued.notified());
            queued.as_mut().enable();
            if let Some(fit) = self.claim(worker, lease).await? {
                return Ok(Some(fit));
            }
            if tokio::time::timeout_at(deadline, queued).await.is_err() {
                return Ok(None);
            }
        }
    }

    /// Renews the lease and stores progress, if there is any to store.
    ///
    /// # Errors
    /// [`Error::StaleLease`].
    pub async fn report(
        &self,
        lease: Lease,
        progress: Option<&Progress>,
        renew: Duration,
    ) -> Result<Reported> {
        let until = micros_after(self.store.now(), renew);
        let mut tx = self.store.inner.database.write().await?;
        let row = row::fetch_leased(&mut tx, lease.fit, lease.epoch).await?;
        let key = lease.fit.uuid().to_string();
        let Some(progress) = progress else {
            sqlx::query("update jobs set lease_until = $2 where id = $1")
                .bind(key)
                .bind(until)
                .execute(&mut *tx)
                .await?;
            tx.commit().await?;
            return Ok(Reported { cancel_requested: row.cancel_requested });
        };
        let further = progress.fraction > row.furthest;
        let json = serde_json::to_string(progress)
            .map_err(|e| Error::Io(std::io::Error::other(e.to_string())))?;
        let row: Row = sqlx::query_as(
            "update jobs set lease_until = $2, progress = $3, furthest = $4, stalled = $5,
                 revision = revision + 1
             where id = $1 returning *",
        )
        .bind(key)
        .bind(until)
        .bind(json)
        .bind(if further { progress.fraction } else { row.furthest })
        .bind(if further { 0 } else { row.stalled })
        .fetch_one(&mut *tx)
        .await?;
        tx.commit().await?;
        let fit = Fit::try_from(row)?;
        self.changed(&fit);
        Ok(Reported { cancel_requested: fit.cancel_requested })
    }

    /// Makes this content the job's checkpoint, and renews the lease.
    ///
    /// # Errors
    /// [`Error::StaleLease`], file errors.
    pub async fn save_checkpoint(
        &self,
        lease: Lease,
        content: Staged,
        renew: Duration,
    ) -> Result<()> {
        let digest = content.digest().to_hex();
        let guard = self.store.blobs().publish(content).await?;
        let stored: Result<Option<String>> = async {
            let mut tx = self.store.inner.database.write().await?;
            let row = row::fetch_leased(&mut tx, lease.fit, lease.epoch).await?;
            let newer = row.checkpoint.as_deref() != Some(digest.as_str());
            sqlx::query(
                "update jobs set checkpoint = $2, lease_until = $3, stalled = $4 where id = $1",
            )
            .bind(lease.fit.uuid().to_string())
            .bind(digest.as_str())
            .bind(micros_after(self.store.now(), renew))
            .bind(if newer { 0 } else { row.stalled })
            .execute(&mut *tx)
            .await?;
            self.store.pass(Failpoint::BeforeCommit)?;
            tx.commit().await?;
            Ok(row.checkpoint.filter(|_| newer))
        }
        .await;
        drop(guard);
        let obsolete = match &stored {
            Ok(before) => before.as_deref(),
            Err(Error::Failpoint(_)) => None,
            // Refused: nobody refers to the new content, unless by chance.
            Err(_) => Some(digest.as_str()),
        };
        self.store.pass(Failpoint::BeforeRelease)?;
        if let Some(obsolete) = obsolete {
            self.store.release(obsolete).await?;
        }
        stored.map(drop)
    }

    /// The newest checkpoint of a job.
    ///
    /// # Errors
    /// [`Error::NotFound`] if there is none, [`Error::ContentLost`].
    pub async fn checkpoint(&self, id: FitId) -> Result<Content> {
        let digest = self.get(id).await?.checkpoint;
        let digest =
            digest.ok_or_else(|| Error::NotFound { name: format!("checkpoint of {id}") })?;
        self.store.blobs().read(&digest, &id.to_string()).await
    }

    /// Stores the twin and ends the job, in one transaction. Asked again under
    /// the same lease with the same content, it answers the same.
    ///
    /// # Errors
    /// [`Error::StaleLease`], file errors.
    pub async fn complete(
        &self,
        lease: Lease,
        facts: &TwinFacts,
        content: Staged,
    ) -> Result<TwinId> {
        let (digest, size_bytes) = (content.digest(), content.size_bytes());
        let guard = self.store.blobs().publish(content).await?;
        let stored = self.complete_published(lease, facts, digest, size_bytes).await;
        drop(guard);
        let obsolete = match &stored {
            Ok((_, checkpoint)) => checkpoint.clone(),
            Err(Error::Failpoint(_)) => None,
            Err(_) => Some(digest.to_hex().to_string()),
        };
        if stored.is_ok() {
            self.store.pass(Failpoint::AfterCommit)?;
            self.store.pass(Failpoint::BeforeRelease)?;
        }
        if let Some(obsolete) = obsolete {
            self.store.release(&obsolete).await?;
        }
        stored.map(|(twin, _)| twin)
    }

    /// The transaction of [`Fits::complete`]; also says which checkpoint is obsolete.
    async fn complete_published(
        &self,
        lease: Lease,
        facts: &TwinFacts,
        digest: Digest,
        size_bytes: u64,
    ) -> Result<(TwinId, Option<String>)> {
        let mut tx = self.store.inner.database.write().await?;
        let before = row::fetch(&mut tx, lease.fit).await?;
        let same_lease = before.lease_epoch == i64::try_from(lease.epoch).unwrap_or(-1);
        if let (State::Succeeded, true, Some(twin)) = (before.state()?, same_lease, &before.twin) {
            let stored: Option<String> =
                sqlx::query_scalar("select digest from twins where id = $1")
                    .bind(twin)
                    .fetch_optional(&mut *tx)
                    .await?;
            if let (true, Ok(twin)) =
                (stored.as_deref() == Some(digest.to_hex().as_str()), Uuid::try_parse(twin))
            {
                return Ok((twin.into(), None));
            }
        }
        let before = row::fetch_leased(&mut tx, lease.fit, lease.epoch).await?;
        let display_name: Option<String> =
            sqlx::query_scalar("select display_name from captures where id = $1")
                .bind(&before.capture)
                .fetch_optional(&mut *tx)
                .await?;
        let new = twins::Insert {
            display_name: display_name.as_deref().unwrap_or_default(),
            origin: Some((&before.capture, &before.id)),
            size_bytes,
            digest,
            facts,
            request_id: None,
            now: self.store.now_micros(),
        };
        let twin = twins::insert(&mut tx, new).await?.id;
        let row: Row = sqlx::query_as(
            "update jobs set state = 'succeeded', twin = $2, ended_at = $3, lease_until = null,
                 worker = null, checkpoint = null, revision = revision + 1
             where id = $1 returning *",
        )
        .bind(&before.id)
        .bind(twin.uuid().to_string())
        .bind(self.store.now_micros())
        .fetch_one(&mut *tx)
        .await?;
        self.store.pass(Failpoint::BeforeCommit)?;
        tx.commit().await?;
        self.changed(&Fit::try_from(row)?);
        Ok((twin, before.checkpoint))
    }
}
