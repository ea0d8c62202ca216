//! Measurements of the calls to the database and to the place of content, for the metrics of a server.
//! Every statement and every request to a bucket passes here, so that a slow or failing store is seen
//! where it is slow, and not only in the requests that wait for it.

use std::{
    fmt,
    future::Future,
    sync::{
        Arc,
        atomic::{AtomicU64, Ordering},
    },
    time::{Duration, Instant},
};

use bendtwin_core::{Category, Problem as _};

use crate::{Error, Result};

/// A part of the store that is called.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Part {
    /// The database.
    Database,
    /// The bucket, or the folder of content.
    Content,
}

impl Part {
    /// The word of the part in metrics.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Database => "database",
            Self::Content => "content",
        }
    }

    /// The words for its calls.
    pub fn operations(self) -> &'static [&'static str] {
        match self {
            Self::Database => &["read", "write", "begin", "commit"],
            Self::Content => &["read", "write", "delete", "list"],
        }
    }
}

/// A call that ended.
#[derive(Clone, Copy, Debug)]
pub struct Call {
    /// The part that was called.
    pub part: Part,
    /// Word of the operation, out of [`Part::operations`].
    pub operation: &'static str,
    /// Time that it took, the wait for a connection included.
    pub took: Duration,
    /// True if the part did not answer, or answered that it is broken; false where a request was
    /// refused for its content.
    pub failed: bool,
}

/// A receiver of measurements.
pub trait Observer: fmt::Debug + Send + Sync {
    /// A call has ended.
    fn called(&self, call: Call);
}

/// The meter of one part. Clones share it.
#[derive(Clone, Debug)]
pub(crate) struct Meter {
    part: Part,
    observer: Option<Arc<dyn Observer>>,
    /// Time of the last answer.
    answered: Arc<LastAnswer>,
}

impl Meter {
    pub(crate) fn new(part: Part, observer: Option<Arc<dyn Observer>>) -> Self {
        Self { part, observer, answered: Arc::new(LastAnswer::new()) }
    }

    /// A meter that nobody reads.
    pub(crate) fn idle(part: Part) -> Self {
        Self::new(part, None)
    }

    /// The result of a call, which is measured.
    pub(crate) async fn measure<T>(
        &self,
        operation: &'static str,
        call: impl Future<Output = Result<T>>,
    ) -> Result<T> {
        debug_assert!(self.part.operations().contains(&operation), "{operation}");
        let started = Instant::now();
        let result = call.await;
        let failed = result.as_ref().is_err_and(is_fault);
        if !failed {
            self.answered.note();
        }
        if let Some(observer) = &self.observer {
            observer.called(Call { part: self.part, operation, took: started.elapsed(), failed });
        }
        result
    }

    /// True if a call was answered within this time.
    pub(crate) fn answered_within(&self, time: Duration) -> bool {
        self.answered.age() < time
    }
}

/// True for an error of the part itself.
fn is_fault(error: &Error) -> bool {
    let of_rows = |error: &sqlx::Error| {
        matches!(error, sqlx::Error::RowNotFound)
            || error
                .as_database_error()
                .is_some_and(|found| !matches!(found.kind(), sqlx::error::ErrorKind::Other))
    };
    match error {
        Error::Database(error) if of_rows(error) => false,
        Error::Objects(object_store::Error::NotFound { .. }) => false,
        Error::DiskFull | Error::ObjectsRefused { .. } => true,
        error => matches!(
            error.category(),
            Category::Unavailable | Category::Internal | Category::DataLoss
        ),
    }
}

/// Time of the last answer, in milliseconds since the start; 0 before the first.
#[derive(Debug)]
struct LastAnswer {
    start: Instant,
    at_ms: AtomicU64,
}

impl LastAnswer {
    fn new() -> Self {
        Self { start: Instant::now(), at_ms: AtomicU64::new(0) }
    }

    fn now_ms(&self) -> u64 {
        u64::try_from(self.start.elapsed().as_millis()).unwrap_or(u64::MAX)
    }

    fn note(&self) {
        self.at_ms.fetch_max(self.now_ms().max(1), Ordering::Relaxed);
    }

    fn age(&self) -> Duration {
        match self.at_ms.load(Ordering::Relaxed) {
            0 => Duration::MAX,
            at => Duration::from_millis(self.now_ms().saturating_sub(at)),
        }
    }
}

#[cfg(test)]
mod tests;
