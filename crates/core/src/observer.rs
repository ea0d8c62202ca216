//! Callbacks of long work: progress, and checkpoints to resume from.

/// Reason for which an observer cannot keep a checkpoint.
pub type ObserverError = Box<dyn std::error::Error + Send + Sync>;

/// Callbacks of long work whose progress is of type `P`.
pub trait Observer<P> {
    /// Called after every unit of work.
    fn progress(&mut self, progress: P);

    /// Called now and then with all that is needed to resume in another process; keeps nothing by
    /// default.
    ///
    /// # Errors
    /// If the work should end, because the checkpoint cannot be kept.
    fn checkpoint(&mut self, _checkpoint: Vec<u8>) -> Result<(), ObserverError> {
        Ok(())
    }

    /// True if progress is to come with previews, where the work can make some; they take a few per
    /// cent of its time.
    fn wants_previews(&self) -> bool {
        false
    }
}

/// No-op observer.
impl<P> Observer<P> for () {
    fn progress(&mut self, _progress: P) {}
}
