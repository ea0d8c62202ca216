//! Errors of the store.

use bendtwin_core::{Category, Problem, ids::FitId};

use crate::{Digest, JobId};

/// Result with this crate's [`Error`].
pub type Result<T, E = Error> = std::result::Result<T, E>;

/// An error of the store.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs)] // The messages say it.
pub enum Error {
    #[error("{name} does not exist")]
    NotFound { name: String },
    #[error(
        "request id `{request_id}` was used before for {name}, with other content: \
         choose a new request id"
    )]
    RequestIdTaken { request_id: String, name: String },
    #[error(
        "the lease {epoch} of {job} has been lost to another worker or the job has ended: stop"
    )]
    StaleLease { job: JobId, epoch: u64 },
    #[error("{name} is used by {fits} queued or running fits: cancel them first")]
    CaptureInUse { name: String, fits: u64 },
    #[error("the ingest of {name} is under way: wait for its end, or cancel it first")]
    IngestUnderWay { name: String },
    #[error("{fit} is running: cancel it first")]
    FitRunning { fit: FitId },
    #[error("the page token is not from this listing: start without one")]
    InvalidPageToken,
    #[error("the content is larger than the limit of {limit} bytes")]
    TooLarge { limit: u64 },
    #[error("the content's BLAKE3 digest is {actual}, not {given}: send it again")]
    DigestMismatch { given: Digest, actual: Digest },
    #[error("{name} is gone: {why}")]
    UploadGone { name: String, why: String },
    #[error("{name} is in use by another request: retry in a moment")]
    UploadLocked { name: String },
    #[error(
        "the upload cannot be {given} bytes long: {}",
        .known.map_or_else(|| format!("{offset} are here already"), |n| format!("its length is {n}"))
    )]
    UploadLength { given: u64, known: Option<u64>, offset: u64 },
    #[error(
        "there is no room for another upload beside those under way ({count} of them, {bytes} bytes): \
         finish or delete one, or retry later"
    )]
    UploadsFull { count: u64, bytes: u64 },
    #[error("the server's disk is full: free space or delete captures and twins")]
    DiskFull,
    #[error("the data folder is in use by another server: stop it or choose another folder")]
    DataDirInUse,
    #[error("the content {digest} of {name} is missing or damaged")]
    ContentLost { name: String, digest: String },
    #[error("stored row of {name}: {fault}")]
    CorruptRow { name: String, fault: String },
    #[error("database: {0}")]
    Database(#[source] sqlx::Error),
    #[error("migration of the database: {0}")]
    Migration(#[from] sqlx::migrate::MigrateError),
    #[error("files: {0}")]
    Objects(#[source] object_store::Error),
    #[error("files: {0}")]
    Io(#[source] std::io::Error),
    #[error("stopped at {0:?}")]
    Failpoint(crate::failpoint::Failpoint),
}

impl Problem for Error {
    fn category(&self) -> Category {
        match self {
            Self::NotFound { .. } | Self::UploadGone { .. } => Category::NotFound,
            Self::RequestIdTaken { .. } => Category::AlreadyExists,
            Self::StaleLease { .. } | Self::UploadLocked { .. } => Category::Aborted,
            Self::CaptureInUse { .. }
            | Self::IngestUnderWay { .. }
            | Self::FitRunning { .. }
            | Self::DataDirInUse => Category::FailedPrecondition,
            Self::InvalidPageToken
            | Self::TooLarge { .. }
            | Self::DigestMismatch { .. }
            | Self::UploadLength { .. } => Category::InvalidArgument,
            Self::DiskFull | Self::UploadsFull { .. } => Category::ResourceExhausted,
            Self::ContentLost { .. } | Self::CorruptRow { .. } => Category::DataLoss,
            Self::Database(sqlx::Error::PoolTimedOut) => Category::Unavailable,
            Self::Database(_)
            | Self::Migration(_)
            | Self::Objects(_)
            | Self::Io(_)
            | Self::Failpoint(_) => Category::Internal,
        }
    }

    fn reason(&self) -> &'static str {
        match self {
            Self::NotFound { .. } => "NOT_FOUND",
            Self::RequestIdTaken { .. } => "REQUEST_ID_TAKEN",
            Self::StaleLease { .. } => "STALE_LEASE",
            Self::CaptureInUse { .. } => "CAPTURE_IN_USE",
            Self::IngestUnderWay { .. } => "INGEST_UNDER_WAY",
            Self::FitRunning { .. } => "FIT_RUNNING",
            Self::InvalidPageToken => "INVALID_PAGE_TOKEN",
            Self::TooLarge { .. } => "CONTENT_TOO_LARGE",
            Self::DigestMismatch { .. } => "DIGEST_MISMATCH",
            Self::UploadGone { .. } => "UPLOAD_GONE",
            Self::UploadLocked { .. } => "UPLOAD_LOCKED",
            Self::UploadLength { .. } => "UPLOAD_LENGTH",
            Self::UploadsFull { .. } => "UPLOADS_FULL",
            Self::DiskFull => "DISK_FULL",
            Self::DataDirInUse => "DATA_DIR_IN_USE",
            Self::ContentLost { .. } => "CONTENT_LOST",
            Self::CorruptRow { .. } => "CORRUPT_ROW",
            Self::Database(sqlx::Error::PoolTimedOut) => "DATABASE_BUSY",
            Self::Database(_) | Self::Migration(_) => "DATABASE_FAILED",
            Self::Objects(_) | Self::Io(_) => "FILES_FAILED",
            Self::Failpoint(_) => "FAILPOINT",
        }
    }
}

impl From<sqlx::Error> for Error {
    fn from(error: sqlx::Error) -> Self {
        /// SQLITE_FULL; extended codes keep it in the low byte.
        const SQLITE_FULL: i64 = 13;
        let code = error.as_database_error().and_then(|e| e.code()?.parse::<i64>().ok());
        if code.is_some_and(|c| c & 0xff == SQLITE_FULL) {
            return Self::DiskFull;
        }
        Self::Database(error)
    }
}

impl From<std::io::Error> for Error {
    fn from(error: std::io::Error) -> Self {
        if is_disk_full(&error) { Self::DiskFull } else { Self::Io(error) }
    }
}

impl From<object_store::Error> for Error {
    fn from(error: object_store::Error) -> Self {
        let mut source: Option<&(dyn std::error::Error + 'static)> = Some(&error);
        while let Some(e) = source {
            if e.downcast_ref::<std::io::Error>().is_some_and(is_disk_full) {
                return Self::DiskFull;
            }
            source = e.source();
        }
        Self::Objects(error)
    }
}

fn is_disk_full(error: &std::io::Error) -> bool {
    use std::io::ErrorKind;
    matches!(error.kind(), ErrorKind::StorageFull | ErrorKind::QuotaExceeded)
}
