//! Named points at which a crash leaves work half done. Tests stop the store there, open it again
//! and check that nothing acknowledged is lost and nothing half done is visible. Outside of tests
//! no failpoint can be armed.

/// A moment between two durable steps.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Failpoint {
    /// An upload has been received; its content is not named by its digest yet.
    ContentStaged = 1,
    /// The content is in place; no row refers to it yet.
    ContentPublished,
    /// The rows are written, the transaction is not committed.
    BeforeCommit,
    /// Committed; the caller has no answer.
    AfterCommit,
    /// A row has been deleted; its content still exists.
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
