//! The purge of what is in the trash: when it is due, or earlier where the disk needs its space.

use super::{Remove, Resource, Row, Trash, select};
use crate::{Error, Result, blobs::Place, folder::disk::Disk, labels::Collection};

/// The turn to purge: `the_bin` in ASCII.
pub(super) const TURN: i64 = 0x0074_6865_5f62_696e;
/// Most resources of a collection that one sweep purges; the next one continues.
const MOST: i64 = 500;

impl Trash<'_> {
    /// Purges what is due. Of servers that share the database, one at a time does it.
    ///
    /// # Errors
    /// Database and file errors.
    pub async fn sweep(&self) -> Result<Vec<Resource>> {
        let Some(turn) = self.store.inner.database.turn(TURN).await? else {
            return Ok(Vec::new());
        };
        let purged = self.purge_due().await;
        let ended = turn.end().await;
        let purged = purged?;
        ended?;
        Ok(purged)
    }

    async fn purge_due(&self) -> Result<Vec<Resource>> {
        let now = {
            let tx = self.store.inner.database.write().await?;
            self.store.lease_until(&tx, std::time::Duration::ZERO)
        };
        let mut purged = Vec::new();
        for collection in Collection::ALL {
            let mut sql = select(collection);
            sql.push(" and trashed_at is not null and purge_at <= ").push_bind(now);
            sql.push(" order by trashed_at, id limit ").push_bind(MOST);
            let rows: Vec<Row> = sql.build().fetch_all(self.store.inner.database.read()).await?;
            for row in rows {
                let resource = row.read(collection)?.resource;
                if self.purge(resource, Remove::Due(now)).await? {
                    purged.push(resource);
                }
            }
        }
        Ok(purged)
    }

    /// Purges what was deleted first, before it is due, until the disk that has the content has this
    /// much free [bytes], or nothing with content is left. Content in a bucket stays: its
    /// space is not that of a disk.
    ///
    /// # Errors
    /// Database and file errors.
    pub async fn make_room(&self, free_bytes: u64) -> Result<Vec<Resource>> {
        let Place::Folder(folder) = self.store.blobs().place() else { return Ok(Vec::new()) };
        let is_low = || Ok::<_, Error>(Disk::of(folder.root())?.free_bytes < free_bytes);
        if !is_low()? {
            return Ok(Vec::new());
        }
        let Some(turn) = self.store.inner.database.turn(TURN).await? else {
            return Ok(Vec::new());
        };
        let purged = self.purge_while(is_low).await;
        let ended = turn.end().await;
        let purged = purged?;
        ended?;
        Ok(purged)
    }

    /// Purges what was deleted first, one by one.
    pub(super) async fn purge_while(
        &self,
        mut wanted: impl FnMut() -> Result<bool>,
    ) -> Result<Vec<Resource>> {
        let mut purged = Vec::new();
        for (_, resource) in self.oldest().await? {
            if !wanted()? {
                break;
            }
            if self.purge(resource, Remove::TRASHED).await? {
                purged.push(resource);
            }
        }
        Ok(purged)
    }

    /// Captures and twins in the trash with the times of their deletion, oldest first.
    async fn oldest(&self) -> Result<Vec<(i64, Resource)>> {
        let mut oldest = Vec::new();
        // Fits have no content of a size that counts.
        for collection in [Collection::Captures, Collection::Twins] {
            let mut sql = select(collection);
            sql.push(" and trashed_at is not null order by trashed_at, id limit ").push_bind(MOST);
            let rows: Vec<Row> = sql.build().fetch_all(self.store.inner.database.read()).await?;
            for row in rows {
                oldest.push((row.trashed_at.unwrap_or_default(), row.read(collection)?.resource));
            }
        }
        oldest.sort_unstable();
        Ok(oldest)
    }

    /// Removes a resource for good if it is still in the trash, and due. Returns false if it is not,
    /// or is in use: a server of an older version may have begun a fit of it.
    async fn purge(&self, resource: Resource, which: Remove) -> Result<bool> {
        let removed = match resource {
            Resource::Capture(id) => self.store.captures().remove(id, which).await,
            Resource::Fit(id) => self.store.jobs().remove(id, which).await,
            Resource::Twin(id) => self.store.twins().remove(id, which).await,
        };
        match removed {
            Ok(()) => Ok(true),
            Err(Error::NotFound { .. }) => Ok(false),
            Err(error @ (Error::CaptureInUse { .. } | Error::FitRunning { .. })) => {
                tracing::warn!(%resource, %error, "it stays in the trash until it is not in use");
                Ok(false)
            }
            Err(error) => Err(error),
        }
    }
}
