//! Content that no row refers to: what a deleted row leaves, and what crashes leave. With it go the
//! request ids of deleted resources.

use std::time::Duration;

use futures::TryStreamExt as _;
use jiff::Timestamp;
use tokio::sync::RwLockWriteGuard;

use super::{Bucket, Folder, Place, arrivals, references};
use crate::{Result, Store, store::identity};

/// Age up to which content of a bucket is left alone.
const LEFT_ALONE: Duration = Duration::from_secs(86_400);
/// The turn to search for garbage: `garbage` in ASCII.
const TURN: i64 = 0x0067_6172_6261_6765;

impl Store {
    /// Moves blobs that no row refers to into the trash, and removes blobs that have been there for
    /// a day; in a bucket, removes them once they are a day old. Callers that disconnect in the
    /// middle of a call leave such blobs behind. Safe at any time, also beside other servers, of
    /// which one at a time does it. Also forgets the request ids of resources that were deleted
    /// long ago.
    ///
    /// # Errors
    /// [`crate::Error::StoreMismatch`] if the database or the blobs have been replaced; database
    /// and file errors.
    pub async fn collect_garbage(&self) -> Result<()> {
        let Some(turn) = self.inner.database.turn(TURN).await? else { return Ok(()) };
        let collected = self.collect_in_turn().await;
        collected.and(turn.end().await)
    }

    async fn collect_in_turn(&self) -> Result<()> {
        let blobs = self.blobs();
        identity::verify(&self.inner.database, blobs.place()).await?;
        self.forget_deleted_requests().await?;
        self.take_over_deletions(arrivals::TAKEN_OVER).await?;
        match blobs.place() {
            Place::Folder(folder) => self.collect_in_folder(folder).await,
            Place::Bucket(bucket) => self.collect_in_bucket(bucket).await,
        }
    }

    async fn collect_in_folder(&self, folder: &Folder) -> Result<()> {
        for digest in folder.list().await? {
            if folder.is_shared() {
                if let Some(deletion) = self.begin_deletion(&digest).await? {
                    folder.discard(&digest, self.now()).await?;
                    self.forget_deletion(deletion).await?;
                }
            } else if let Some(_gate) = self.unless_referred(&digest).await? {
                folder.discard(&digest, self.now()).await?;
            }
        }
        folder.empty_trash(self.now()).await
    }

    async fn collect_in_bucket(&self, bucket: &Bucket) -> Result<()> {
        let mut listed = bucket.published();
        while let Some(object) = listed.try_next().await? {
            let modified = Timestamp::from_second(object.last_modified.timestamp());
            let age = modified.map(|modified| self.now().duration_since(modified));
            let is_old = age.is_ok_and(|age| age > LEFT_ALONE.try_into().unwrap_or_default());
            if let (true, Some(digest)) = (is_old, object.location.filename()) {
                self.delete_shared(digest).await?;
            }
        }
        Ok(())
    }

    /// Deletes a blob unless a row refers to it: its row was deleted on purpose.
    pub(crate) async fn release(&self, digest: &str) -> Result<()> {
        if self.blobs().place().is_shared() {
            return self.delete_shared(digest).await;
        }
        match self.unless_referred(digest).await? {
            Some(_gate) => self.blobs().delete(digest).await,
            None => Ok(()),
        }
    }

    /// The closed gate, if neither a row nor a backup needs a blob: none will while it is held.
    async fn unless_referred(&self, digest: &str) -> Result<Option<RwLockWriteGuard<'_, ()>>> {
        // Most are in use: do not bar others for those.
        if references::exist(self.inner.database.read(), digest).await? {
            return Ok(None);
        }
        let gate = self.blobs().close_gate().await;
        // A transaction that refers to it may be under way still, although its connection broke:
        // the lock on writing waits for its end.
        let mut tx = self.inner.database.write().await?;
        let is_kept = self.has_arrival(&mut tx, digest).await?;
        Ok((!is_kept && !references::exist(&mut tx, digest).await?).then_some(gate))
    }
}
