//! The points at which a crash leaves something half done, by name. Tests stop
//! the store there, open it again and check that nothing acknowledged is lost
//! and nothing half done is seen. Outside of tests no failpoint can be armed.

/// A moment between two durable steps.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Failpoint {
    /// An upload has been received, its content not yet named by its digest.
    ContentStaged = 1,
    /// The content is in place; no row refers to it yet.
    ContentPublished,
    /// The rows are written, the transaction is not committed.
    BeforeCommit,
    /// Committed; the caller was not told.
    AfterCommit,
    /// A row is gone; its content is still there.
    BeforeRelease,
}

#[cfg(test)]
impl Failpoint {
    pub(crate) const ALL: [Self; 5] = [
        Self::ContentStaged,
        Self::ContentPublished,
        Self::BeforeCommit,
        Self::AfterCommit,
        Self::BeforeRelease,
    ];
}

/// The armed failpoint, if any.
#[derive(Debug, Default)]
pub(crate) struct Armed {
    #[cfg(test)]
    point: std::sync::atomic::AtomicU8,
}

impl Armed {
    #[cfg(test)]
    pub(crate) fn arm(&self, point: Failpoint) {
        self.point.store(point as u8, std::sync::atomic::Ordering::SeqCst);
    }

    #[cfg(test)]
    pub(crate) fn pass(&self, point: Failpoint) -> crate::Result<()> {
        if self.point.load(std::sync::atomic::Ordering::SeqCst) == point as u8 {
            return Err(crate::Error::Failpoint(point));
        }
        Ok(())
    }

    #[cfg(not(test))]
    #[inline]
    pub(crate) fn pass(&self, _point: Failpoint) -> crate::Result<()> {
        Ok(())
    }
}
