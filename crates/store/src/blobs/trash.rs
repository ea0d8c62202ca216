//! Content that no row refers to is set aside for a day before it is removed. It should be left
//! over from a crash; if it is not, there is a day to notice.

use std::{fs, io, time::Duration};

use jiff::Timestamp;

use super::{Folder, TRASH, files, published, trashed};
use crate::Result;

/// Time for which content stays in the trash.
pub(crate) const KEPT: Duration = Duration::from_secs(86_400);

impl Folder {
    /// Moves a blob to the trash. The caller sees to it that no row comes to refer to it meanwhile.
    pub(crate) async fn discard(&self, digest: &str, now: Timestamp) -> Result<()> {
        let file = self.file(digest);
        // Before it moves: a file in the trash must not look old for a moment.
        let touched = tokio::task::spawn_blocking(move || {
            fs::File::options().write(true).open(file)?.set_modified(now.into())
        });
        match touched.await.map_err(io::Error::other)? {
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(()),
            touched => touched?,
        }
        self.rename(&published(digest), &trashed(digest)).await?;
        tracing::warn!(digest, "content without a row is moved to the trash");
        Ok(())
    }

    /// Removes content that has been in the trash for a day.
    pub(crate) async fn empty_trash(&self, now: Timestamp) -> Result<()> {
        let folder = self.root().join(TRASH);
        let emptied = tokio::task::spawn_blocking(move || {
            for (file, _) in files::list(&folder)? {
                let since = fs::metadata(&file)?.modified()?;
                let age = Timestamp::try_from(since).map(|since| now.duration_since(since));
                if age.is_ok_and(|age| age > KEPT.try_into().unwrap_or_default()) {
                    fs::remove_file(&file)?;
                }
            }
            Ok::<_, io::Error>(())
        });
        Ok(emptied.await.map_err(io::Error::other)??)
    }
}
