//! Settings that are made again when their files change. A file that cannot be used is logged, and
//! the settings before it stay in force.

use std::{
    path::PathBuf,
    sync::{Arc, Mutex, PoisonError},
    time::Duration,
};

use tokio::sync::watch;
use tokio_util::sync::CancellationToken;

use crate::FileError;

/// Interval at which the files are checked. They are small, and compared by content: a modification
/// time is too coarse, and does not reveal a link that points elsewhere now.
const INTERVAL: Duration = Duration::from_secs(2);

/// Settings read from files, in the last usable version. Clones share them.
#[derive(Debug)]
pub struct Reloaded<T>(Arc<Shared<T>>);

struct Shared<T> {
    files: Vec<PathBuf>,
    load: Box<dyn Fn() -> Result<T, FileError> + Send + Sync>,
    current: watch::Sender<Arc<T>>,
    /// Contents that were tried last.
    tried: Mutex<Contents>,
}

/// Content of each file; none if it cannot be read.
type Contents = Vec<Option<Vec<u8>>>;

impl<T> Clone for Reloaded<T> {
    fn clone(&self) -> Self {
        Self(self.0.clone())
    }
}

impl<T> std::fmt::Debug for Shared<T> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Reloaded").field("files", &self.files).finish_non_exhaustive()
    }
}

impl<T: Send + Sync + 'static> Reloaded<T> {
    /// Settings that `load` makes of files.
    ///
    /// # Errors
    /// If the files cannot be used.
    pub fn new(
        files: Vec<PathBuf>,
        load: impl Fn() -> Result<T, FileError> + Send + Sync + 'static,
    ) -> Result<Self, FileError> {
        // Before they are loaded: a change in between is seen later.
        let tried = Mutex::new(contents(&files));
        let current = watch::Sender::new(Arc::new(load()?));
        Ok(Self(Arc::new(Shared { files, load: Box::new(load), current, tried })))
    }

    /// The settings in force.
    pub fn get(&self) -> Arc<T> {
        self.0.current.borrow().clone()
    }

    /// The settings in force, and those that come to be.
    pub(crate) fn changes(&self) -> watch::Receiver<Arc<T>> {
        self.0.current.subscribe()
    }

    /// Makes the settings again if the files have changed since the last attempt. True if there are
    /// new ones.
    pub fn refresh(&self) -> bool {
        let found = contents(&self.0.files);
        let mut tried = self.0.tried.lock().unwrap_or_else(PoisonError::into_inner);
        if *tried == found {
            return false;
        }
        *tried = found;
        match (self.0.load)() {
            Ok(settings) => {
                self.0.current.send_replace(settings.into());
                tracing::info!(files = ?self.0.files, "certificates reloaded");
                true
            }
            Err(error) => {
                tracing::warn!(%error, "certificates not reloaded: those before stay in force");
                false
            }
        }
    }

    /// Checks the files at an interval, and immediately when the process gets SIGHUP, until `stop`.
    pub async fn watch(self, stop: CancellationToken) {
        let mut hangup = Hangup::new();
        loop {
            tokio::select! {
                () = stop.cancelled() => return,
                () = tokio::time::sleep(INTERVAL) => {}
                () = hangup.received() => tracing::info!("SIGHUP: looking at the certificates"),
            }
            let of_files = self.clone();
            // Files may lie on a network.
            let _ = tokio::task::spawn_blocking(move || of_files.refresh()).await;
        }
    }
}

fn contents(files: &[PathBuf]) -> Contents {
    let content = |path: &PathBuf| crate::files::read(std::fs::File::open(path), path).ok();
    files.iter().map(content).collect()
}

/// The signal SIGHUP, where there are signals.
struct Hangup {
    #[cfg(unix)]
    signal: Option<tokio::signal::unix::Signal>,
}

impl Hangup {
    fn new() -> Self {
        Self {
            #[cfg(unix)]
            signal: tokio::signal::unix::signal(tokio::signal::unix::SignalKind::hangup()).ok(),
        }
    }

    async fn received(&mut self) {
        #[cfg(unix)]
        if let Some(signal) = &mut self.signal
            && signal.recv().await.is_some()
        {
            return;
        }
        std::future::pending::<()>().await;
    }
}

#[cfg(test)]
mod tests;
