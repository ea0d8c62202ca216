//! Free space of the disk. New content is refused before the disk is full, so that work under way
//! can end, and content that is not needed can be deleted.

use bendtwin_store::Error as StoreError;

use crate::app::{App, Error, Result};

impl App {
    /// Refuses new content of at least `bytes` that would leave less than the floor free.
    pub(crate) fn require_room(&self, bytes: u64) -> Result<()> {
        let disk = match self.store.disk() {
            Ok(disk) => disk,
            Err(error) => {
                // The write itself will show.
                tracing::warn!(%error, "the free space of the disk is not known");
                return Ok(());
            }
        };
        self.metrics.disk(disk.free_bytes, disk.total_bytes);
        let floor = self.options.disk_floor_bytes();
        if disk.free_bytes < floor.saturating_add(bytes) {
            self.room_wanted.notify_one();
            return Err(StoreError::DiskFull.into());
        }
        Ok(())
    }

    /// Counts a write that failed because of the disk or the database, if that is the cause.
    pub(crate) fn write_failed(&self, error: &StoreError) {
        let is_cause = matches!(
            error,
            StoreError::DiskFull
                | StoreError::Database(_)
                | StoreError::Objects(_)
                | StoreError::Io(_)
        );
        if is_cause {
            self.metrics.write_failed(bendtwin_core::Problem::reason(error));
        }
    }

    /// Runs a change of the store to its end even if the caller goes away. Dropped half-way
    /// (between a blob and the row that refers to it, or between the last search for such rows and
    /// the unlinking), it would release the lock that keeps the two apart while files and database
    /// still change.
    pub(in crate::app) async fn change<T: Send + 'static>(
        &self,
        change: impl Future<Output = bendtwin_store::Result<T>> + Send + 'static,
    ) -> Result<T> {
        match tokio::spawn(change).await {
            Ok(changed) => Ok(changed.inspect_err(|error| self.write_failed(error))?),
            Err(panic) => Err(Error::Internal(format!("a change of the store: {panic}"))),
        }
    }
}
