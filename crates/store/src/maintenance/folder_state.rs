//! The state of a data folder as it shows from outside, without opening the store.

use std::{fs::File, io, path::Path};

use rustix::fs::{Access, access};
use serde::Serialize;

use super::integrity;
use crate::{
    Error, Result,
    database::{self, migrations},
    folder::disk::Disk,
};

/// State of a data folder.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct FolderState {
    /// True if there is a folder; all else is about the nearest one above it if not.
    pub exists: bool,
    /// True if this user may write there.
    pub writable: bool,
    /// True if a server has it open.
    pub in_use: bool,
    /// Space that this user may still use [bytes].
    pub free_bytes: u64,
    /// Version of the database's tables, if there is a database.
    pub schema: Option<i64>,
    /// True if a newer version of the program made the tables so that this one cannot use them.
    pub too_new: bool,
}

/// The state of a data folder. Nothing is made or changed; a server that starts in the same instant
/// may find the lock taken.
///
/// # Errors
/// If the path is no folder; database and file errors.
pub async fn folder_state(data_dir: &Path) -> Result<FolderState> {
    let absolute = std::path::absolute(data_dir)?;
    let nearest = absolute.ancestors().find(|path| path.exists()).unwrap_or(Path::new("/"));
    if !nearest.is_dir() {
        return Err(io::Error::from(io::ErrorKind::NotADirectory).into());
    }
    let (schema, too_new) = match integrity::read_only(data_dir).await {
        Ok(mut connection) => {
            let version = sqlx::query_scalar("select max(version) from _sqlx_migrations");
            let version = version.fetch_one(&mut connection).await?;
            match migrations::newer(&mut connection).await {
                Err(Error::DatabaseNewer { .. }) => (version, true),
                usable => {
                    usable?;
                    (version, false)
                }
            }
        }
        Err(Error::NotFound { .. }) => (None, false),
        Err(error) => return Err(error),
    };
    Ok(FolderState {
        exists: nearest == absolute,
        writable: access(nearest, Access::WRITE_OK | Access::EXEC_OK).is_ok(),
        in_use: is_locked(data_dir),
        free_bytes: Disk::of(nearest)?.free_bytes,
        schema,
        too_new,
    })
}

/// True if a server holds the lock of a folder.
fn is_locked(data_dir: &Path) -> bool {
    let lock = File::open(data_dir.join(database::LOCK));
    lock.is_ok_and(|file| matches!(file.try_lock_shared(), Err(std::fs::TryLockError::WouldBlock)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Options, Store};

    #[tokio::test]
    async fn a_folder_is_seen_before_during_and_after_a_server() {
        let parent = tempfile::tempdir().unwrap();
        let folder = parent.path().join("not/yet");
        let before = folder_state(&folder).await.unwrap();
        assert!(!before.exists && before.writable && !before.in_use && before.schema.is_none());
        assert!(!folder.exists(), "looking made the folder");
        let store = Store::open(Options::new(&folder)).await.unwrap();
        let during = folder_state(&folder).await.unwrap();
        assert!(during.exists && during.in_use);
        assert_eq!((during.schema, during.too_new), (Some(migrations::newest()), false));
        store.close().await;
        drop(store);
        assert!(!folder_state(&folder).await.unwrap().in_use);
    }

    #[tokio::test]
    async fn a_file_is_no_folder() {
        let parent = tempfile::tempdir().unwrap();
        let file = parent.path().join("file");
        std::fs::write(&file, "x").unwrap();
        assert!(folder_state(&file).await.is_err());
    }
}
