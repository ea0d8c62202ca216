//! Publishing and deleting content in a place that several servers share.
//!
//! Transactions that write exclude each other, requests to a bucket do not. So both sides say first
//! what they are about to do:
//!
//! * who publishes inserts an *arrival*, waits until no *deletion* of the same content is under way,
//!   puts the content in its place, and commits the row that refers to it;
//! * who deletes finds, in one transaction, neither a row nor an arrival and inserts the deletion; then
//!   it removes the content, and the deletion at last.
//!
//! Whichever of arrival and deletion commits first, the other sees: content is never removed between
//! its publication and its row. A server that dies leaves an arrival, which keeps the content for a
//! day, or a deletion, which another takes over once nothing of the dead one can be under way still.

use std::time::{Duration, Instant};

use tokio::sync::RwLockReadGuard;
use uuid::Uuid;

use super::references;
use crate::{
    Error, Result, Staged, Store,
    sql::{Builder, Transaction, query, query_scalar},
};

/// Time for which an arrival keeps content.
pub(crate) const KEPT: Duration = Duration::from_secs(86_400);
/// Longest time between an arrival and the row: well before the arrival ends.
const LONGEST: Duration = Duration::from_secs(43_200);
/// Age of a deletion up to which content is removed by it.
const LATEST: Duration = Duration::from_secs(20);
/// Age from which a deletion is that of a dead server: well after the last request of it.
pub(crate) const TAKEN_OVER: Duration = Duration::from_secs(60);
/// Longest wait for the end of a deletion, and the interval at which it is looked for.
const PATIENCE: Duration = Duration::from_secs(15);
const LOOK_AGAIN: Duration = Duration::from_millis(50);

/// Content that is in its place and stays there while this lives: until the row that refers to it is
/// committed.
#[derive(Debug)]
pub(crate) struct ContentGuard<'a> {
    _gate: RwLockReadGuard<'a, ()>,
    _arrival: Option<Arrival>,
}

/// The rows that keep content; dropped, they go.
#[derive(Debug)]
struct Arrival {
    store: Store,
    id: String,
}

/// A deletion that has begun.
#[derive(Debug)]
pub(crate) struct Deletion {
    digest: String,
    id: String,
    began: Instant,
}

impl Store {
    /// Puts staged content in its place. The guard is held until the row that refers to it is
    /// committed.
    pub(crate) async fn publish(&self, staged: Staged) -> Result<ContentGuard<'_>> {
        self.publish_all(vec![staged]).await
    }

    /// [`Store::publish`] for several contents that one transaction refers to.
    pub(crate) async fn publish_all(&self, staged: Vec<Staged>) -> Result<ContentGuard<'_>> {
        let began = Instant::now();
        let digests: Vec<String> = staged.iter().map(|s| s.digest().to_hex().to_string()).collect();
        let arrival = match self.blobs().place().is_shared() {
            true => Some(self.announce(&digests).await?),
            false => None,
        };
        let gate = self.blobs().publish(staged).await?;
        if arrival.is_some() && began.elapsed() > LONGEST {
            return Err(Error::ContentBusy);
        }
        Ok(ContentGuard { _gate: gate, _arrival: arrival })
    }

    async fn announce(&self, digests: &[String]) -> Result<Arrival> {
        let id = Uuid::new_v4().to_string();
        let mut tx = self.inner.database.write().await?;
        let until = self.lease_until(&tx, KEPT);
        let mut sql = Builder::new("insert into arrivals (id, digest, until_at) values ");
        let mut distinct = digests.to_vec();
        distinct.sort();
        distinct.dedup();
        for (nth, digest) in distinct.iter().enumerate() {
            sql.push(if nth == 0 { "(" } else { ", (" }).push_bind(&id).push(", ");
            sql.push_bind(digest).push(", ").push_bind(until).push(")");
        }
        sql.build().execute(&mut tx).await?;
        tx.commit().await?;
        let arrival = Arrival { store: self.clone(), id };
        self.await_deletions(&distinct).await?;
        Ok(arrival)
    }

    /// Waits until no server deletes any of these, which a row or an arrival keeps by now.
    pub(crate) async fn await_deletions(&self, digests: &[String]) -> Result<()> {
        let began = Instant::now();
        loop {
            let mut sql = Builder::new("select digest from deletions where digest in (");
            sql.push_list(digests).push(")");
            let deleted: Vec<(String,)> = sql.build().fetch_all(self.inner.database.read()).await?;
            if deleted.is_empty() {
                return Ok(());
            }
            if began.elapsed() > PATIENCE {
                return Err(Error::ContentBusy);
            }
            tokio::time::sleep(LOOK_AGAIN).await;
        }
    }

    /// Deletes content of a shared place unless something refers to it.
    pub(crate) async fn delete_shared(&self, digest: &str) -> Result<()> {
        match self.begin_deletion(digest).await? {
            Some(deletion) => self.finish_deletion(deletion).await,
            None => Ok(()),
        }
    }

    /// Says that content is being deleted. None if something refers to it, or if another deletes it.
    pub(crate) async fn begin_deletion(&self, digest: &str) -> Result<Option<Deletion>> {
        // Most are in use: do not bar others for those.
        if references::exist(self.inner.database.read(), digest).await? {
            return Ok(None);
        }
        let deletion = Deletion::of(digest.to_owned());
        let mut tx = self.inner.database.write().await?;
        let now = self.lease_until(&tx, Duration::ZERO);
        let is_deleted = "select exists (select 1 from deletions where digest = $1)";
        if self.has_arrival(&mut tx, digest).await?
            || query_scalar(is_deleted).bind(digest).fetch_one(&mut tx).await?
            || references::exist(&mut tx, digest).await?
        {
            return Ok(None);
        }
        query("insert into deletions (digest, id, begun_at) values ($1, $2, $3)")
            .bind(digest)
            .bind(&deletion.id)
            .bind(now)
            .execute(&mut tx)
            .await?;
        tx.commit().await?;
        Ok(Some(deletion))
    }

    /// True if content is about to be referred to, or to be copied by a backup.
    pub(crate) async fn has_arrival(&self, tx: &mut Transaction, digest: &str) -> Result<bool> {
        let now = self.lease_until(tx, Duration::ZERO);
        let kept = "select exists (select 1 from arrivals where digest = $1 and until_at > $2)";
        query_scalar(kept).bind(digest).bind(now).fetch_one(tx).await
    }

    /// Removes content whose deletion has begun. If that fails, or comes too late, the deletion stays
    /// until it is taken over.
    pub(crate) async fn finish_deletion(&self, deletion: Deletion) -> Result<()> {
        if deletion.began.elapsed() > LATEST {
            return Ok(());
        }
        self.blobs().delete(&deletion.digest).await?;
        self.forget_deletion(deletion).await
    }

    /// Ends a deletion, unless another has taken it over.
    pub(crate) async fn forget_deletion(&self, deletion: Deletion) -> Result<()> {
        let mut tx = self.inner.database.write().await?;
        query("delete from deletions where digest = $1 and id = $2")
            .bind(deletion.digest)
            .bind(deletion.id)
            .execute(&mut tx)
            .await?;
        tx.commit().await
    }

    /// Finishes deletions that are older than that, and forgets arrivals that have ended: they are of
    /// servers that died.
    pub(crate) async fn take_over_deletions(&self, age: Duration) -> Result<()> {
        let mut tx = self.inner.database.write().await?;
        let now = self.lease_until(&tx, Duration::ZERO);
        query("delete from arrivals where until_at < $1").bind(now).execute(&mut tx).await?;
        let since = now.saturating_sub(i64::try_from(age.as_micros()).unwrap_or(i64::MAX));
        let find = "select digest from deletions where begun_at <= $1";
        let old: Vec<String> = query_scalar(find).bind(since).fetch_all(&mut tx).await?;
        let old: Vec<Deletion> = old.into_iter().map(Deletion::of).collect();
        for deletion in &old {
            query("update deletions set id = $2, begun_at = $3 where digest = $1")
                .bind(&deletion.digest)
                .bind(&deletion.id)
                .bind(now)
                .execute(&mut tx)
                .await?;
        }
        tx.commit().await?;
        for deletion in old {
            self.finish_deletion(deletion).await?;
        }
        Ok(())
    }
}

impl Deletion {
    fn of(digest: String) -> Self {
        Self { digest, id: Uuid::new_v4().to_string(), began: Instant::now() }
    }
}

impl Drop for Arrival {
    fn drop(&mut self) {
        // Without a runtime it goes by itself, in a day.
        let Ok(runtime) = tokio::runtime::Handle::try_current() else { return };
        let (store, id) = (self.store.clone(), std::mem::take(&mut self.id));
        runtime.spawn(async move {
            let removed = async {
                let mut tx = store.inner.database.write().await?;
                query("delete from arrivals where id = $1").bind(id).execute(&mut tx).await?;
                tx.commit().await
            };
            if let Err(error) = removed.await {
                tracing::debug!(%error, "content without a row would stay for a day");
            }
        });
    }
}

#[cfg(test)]
mod tests;
