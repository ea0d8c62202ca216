//! Errors of the store.

use std::path::PathBuf;

use bendtwin_core::{Category, Problem, ids::FitId};
use bendtwin_tls::{FileError, TlsError};

use crate::{Digest, JobId, database::plans, disk};

/// Result with this crate's [`Error`].
pub type Result<T, E = Error> = std::result::Result<T, E>;

/// An error of the store.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs)] // The messages say it.
pub enum Error {
    #[error("{name} does not exist")]
    NotFound { name: String },
    #[error(
        "{name} has no playback: wait for the end of its ingest or, if it was read before there were \
         playbacks, run the ingest again"
    )]
    PlaybackMissing { name: String },
    #[error(
        "request id `{request_id}` was used before for {name}, with other content: \
         choose a new request id"
    )]
    RequestIdTaken { request_id: String, name: String },
    #[error(
        "request id `{request_id}` made {name}, which has been deleted since: choose a new request id \
         to make another"
    )]
    DeletedSince { request_id: String, name: String },
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
    #[error("{name} would have more than {limit} tags: take some away first")]
    TooManyTags { name: String, limit: usize },
    #[error(
        "{limit} different requirements wait in the queue already: ask for the same backend, memory and \
         labels as others do, or retry later"
    )]
    TooManyRequirements { limit: usize },
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
    #[error(
        "{queued} jobs of {owner} wait already, and its key allows {limit}: wait for some to begin, or \
         cancel some"
    )]
    QuotaJobs { owner: String, queued: u64, limit: u64 },
    #[error(
        "{owner} has {stored} bytes stored, and with {more} more there were more than its key allows \
         ({limit}): delete captures or twins"
    )]
    QuotaBytes { owner: String, stored: u64, more: u64, limit: u64 },
    #[error("the server's disk is full: free space or delete captures and twins")]
    DiskFull,
    #[error("the data folder is in use by another server: stop it or choose another folder")]
    DataDirInUse,
    #[error(
        "the data folder has content but no database {}: put the database back, or run \
         `bendtwin store repair` to begin a new one beside it", .file.display()
    )]
    DatabaseMissing { file: PathBuf },
    #[error(
        "the database {database} and the content in {blobs} belong to different stores: put the right \
         one back, or run `bendtwin store repair` to join them"
    )]
    StoreMismatch { database: String, blobs: String },
    #[error(
        "another server has the database {database} open, and its content is not in {blobs}: give this \
         server the content, too"
    )]
    ContentElsewhere { database: String, blobs: String },
    #[error(
        "the store is in {} still and {database} is empty: run `bendtwin store migrate --to` with the \
         URL of that database, or choose another folder", .file.display()
    )]
    StoreNotMigrated { file: PathBuf, database: String },
    #[error(
        "the database of this folder is {database}: start the server with its URL (`--database`), back it \
         up with pg_dump (docs/run/storage.md), or remove the file `postgres` from the folder if the \
         database is there no more"
    )]
    DatabaseElsewhere { database: String },
    #[error("{database} is not empty: name a new database")]
    DatabaseNotEmpty { database: String },
    #[error("the rows of {table} differ in {database}: nothing was changed there, report this")]
    MigrationDiffers { table: String, database: String },
    #[error("this is no URL of a PostgreSQL database: write `postgres://USER@HOST:PORT/DATABASE`")]
    InvalidDatabaseUrl,
    #[error("the database cannot be used: {fault}")]
    DatabaseUnfit { fault: String },
    #[error(
        "a newer version of the program has changed the database ({name}, its migration {migration}; \
         this program knows {known}): start that version or a newer one; nothing has been changed"
    )]
    DatabaseNewer { migration: i64, name: String, known: i64 },
    #[error(
        "a newer version of the program has had this store (migration {migration}): run its `bendtwin \
         store migrate`, which knows all that is there"
    )]
    StoreNewer { migration: i64 },
    #[error(
        "this version changes the database so that older ones cannot use it, and {servers} servers \
         have it open: stop all of them (one that was killed counts for a minute), then start this \
         one; nothing has been changed"
    )]
    OlderServersRun { servers: i64 },
    #[error("the database is damaged ({fault}): run `bendtwin store check`")]
    DatabaseDamaged { fault: String },
    #[error("the database cannot be rebuilt ({fault}): restore it from a backup")]
    BeyondRepair { fault: String },
    #[error("the database is locked by another program or overloaded: retry in a moment")]
    DatabaseBusy,
    #[error("the database does not answer: retry in a moment")]
    DatabaseUnavailable,
    #[error(
        "this is no place for content: write `s3://BUCKET` or `s3://BUCKET/PREFIX`, or `file:///FOLDER`; \
         keys go into the environment (AWS_ACCESS_KEY_ID, AWS_SECRET_ACCESS_KEY)"
    )]
    InvalidObjectsUrl,
    #[error("the object storage does not answer: retry in a moment")]
    ObjectsUnavailable,
    #[error("no TLS with the object storage: {fault}")]
    ObjectsUntrusted { fault: TlsError },
    #[error("no TLS with the object storage: {0}")]
    Certificate(#[from] FileError),
    #[error(
        "the object storage refuses the server ({fault}): check the keys, the region and the endpoint in \
         its environment (AWS_*), and the bucket's policy"
    )]
    ObjectsRefused { fault: String },
    #[error(
        "the content of this folder is in {objects}: name it (`--objects`), or remove the file `objects` \
         from the folder if it is there no more"
    )]
    ObjectsElsewhere { objects: String },
    #[error("the content of this folder is in {objects}: {advice}")]
    ObjectsNotLocal { objects: String, advice: &'static str },
    #[error(
        "the content is in {} still: run `bendtwin store migrate --to-objects` with the URL of its new \
         place", .folder.display()
    )]
    ObjectsNotMigrated { folder: PathBuf },
    #[error("equal content is being deleted at this moment: retry in a moment")]
    ContentBusy,
    #[error("text has a NUL character, which the database does not store: leave it out")]
    InvalidText,
    #[error("the folder {} is not empty: name a new one for the backup", .folder.display())]
    BackupNotEmpty { folder: PathBuf },
    #[error("the content {digest} of {name} is missing: run `bendtwin store check`")]
    ContentLost { name: String, digest: String },
    #[error("the content {digest} of {name} is damaged ({fault}): run `bendtwin store check`")]
    ContentDamaged { name: String, digest: String, fault: String },
    #[error("stored row of {name}: {fault}")]
    CorruptRow { name: String, fault: String },
    #[error("database: {0}")]
    Database(#[source] sqlx::Error),
    #[error("migration of the database: {0}")]
    Migration(#[source] sqlx::migrate::MigrateError),
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
            Self::NotFound { .. } | Self::PlaybackMissing { .. } | Self::UploadGone { .. } => {
                Category::NotFound
            }
            Self::RequestIdTaken { .. } | Self::DeletedSince { .. } => Category::AlreadyExists,
            Self::StaleLease { .. } | Self::UploadLocked { .. } => Category::Aborted,
            Self::CaptureInUse { .. }
            | Self::IngestUnderWay { .. }
            | Self::FitRunning { .. }
            | Self::DatabaseMissing { .. }
            | Self::StoreMismatch { .. }
            | Self::ContentElsewhere { .. }
            | Self::StoreNotMigrated { .. }
            | Self::DatabaseElsewhere { .. }
            | Self::DatabaseUnfit { .. }
            | Self::DatabaseNewer { .. }
            | Self::OlderServersRun { .. }
            | Self::StoreNewer { .. }
            | Self::DatabaseNotEmpty { .. }
            | Self::BackupNotEmpty { .. }
            | Self::ObjectsRefused { .. }
            | Self::ObjectsUntrusted { .. }
            | Self::ObjectsElsewhere { .. }
            | Self::ObjectsNotLocal { .. }
            | Self::ObjectsNotMigrated { .. }
            | Self::DataDirInUse => Category::FailedPrecondition,
            Self::Certificate(error) => error.category(),
            Self::InvalidPageToken
            | Self::TooManyTags { .. }
            | Self::TooLarge { .. }
            | Self::DigestMismatch { .. }
            | Self::InvalidDatabaseUrl
            | Self::InvalidObjectsUrl
            | Self::InvalidText
            | Self::UploadLength { .. } => Category::InvalidArgument,
            Self::DiskFull
            | Self::TooManyRequirements { .. }
            | Self::UploadsFull { .. }
            | Self::QuotaJobs { .. }
            | Self::QuotaBytes { .. } => Category::ResourceExhausted,
            Self::ContentLost { .. }
            | Self::ContentDamaged { .. }
            | Self::DatabaseDamaged { .. }
            | Self::BeyondRepair { .. }
            | Self::MigrationDiffers { .. }
            | Self::CorruptRow { .. } => Category::DataLoss,
            Self::DatabaseBusy
            | Self::DatabaseUnavailable
            | Self::ObjectsUnavailable
            | Self::ContentBusy => Category::Unavailable,
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
            Self::PlaybackMissing { .. } => "PLAYBACK_MISSING",
            Self::RequestIdTaken { .. } => "REQUEST_ID_TAKEN",
            Self::DeletedSince { .. } => "DELETED_SINCE",
            Self::StaleLease { .. } => "STALE_LEASE",
            Self::CaptureInUse { .. } => "CAPTURE_IN_USE",
            Self::IngestUnderWay { .. } => "INGEST_UNDER_WAY",
            Self::FitRunning { .. } => "FIT_RUNNING",
            Self::InvalidPageToken => "INVALID_PAGE_TOKEN",
            Self::TooManyTags { .. } => "TOO_MANY_TAGS",
            Self::TooManyRequirements { .. } => "TOO_MANY_REQUIREMENTS",
            Self::TooLarge { .. } => "CONTENT_TOO_LARGE",
            Self::DigestMismatch { .. } => "DIGEST_MISMATCH",
            Self::UploadGone { .. } => "UPLOAD_GONE",
            Self::UploadLocked { .. } => "UPLOAD_LOCKED",
            Self::UploadLength { .. } => "UPLOAD_LENGTH",
            Self::UploadsFull { .. } => "UPLOADS_FULL",
            Self::QuotaJobs { .. } => "QUOTA_QUEUED_JOBS",
            Self::QuotaBytes { .. } => "QUOTA_STORED_BYTES",
            Self::DiskFull => "DISK_FULL",
            Self::DataDirInUse => "DATA_DIR_IN_USE",
            Self::DatabaseMissing { .. } => "DATABASE_MISSING",
            Self::StoreMismatch { .. } => "STORE_MISMATCH",
            Self::ContentElsewhere { .. } => "CONTENT_ELSEWHERE",
            Self::BackupNotEmpty { .. } => "BACKUP_NOT_EMPTY",
            Self::DatabaseDamaged { .. } | Self::BeyondRepair { .. } => "DATABASE_DAMAGED",
            Self::DatabaseBusy => "DATABASE_BUSY",
            Self::DatabaseUnavailable => "DATABASE_UNAVAILABLE",
            Self::DatabaseElsewhere { .. } => "DATABASE_ELSEWHERE",
            Self::DatabaseUnfit { .. } => "DATABASE_UNFIT",
            Self::DatabaseNewer { .. } | Self::StoreNewer { .. } => "DATABASE_NEWER",
            Self::OlderServersRun { .. } => "OLDER_SERVERS_RUN",
            Self::DatabaseNotEmpty { .. } => "DATABASE_NOT_EMPTY",
            Self::MigrationDiffers { .. } => "MIGRATION_DIFFERS",
            Self::InvalidDatabaseUrl => "INVALID_DATABASE_URL",
            Self::InvalidObjectsUrl => "INVALID_OBJECTS_URL",
            Self::ObjectsUnavailable => "OBJECTS_UNAVAILABLE",
            Self::ObjectsUntrusted { fault } => fault.reason(),
            Self::Certificate(error) => error.reason(),
            Self::ObjectsRefused { .. } => "OBJECTS_REFUSED",
            Self::ObjectsElsewhere { .. } | Self::ObjectsNotLocal { .. } => "OBJECTS_ELSEWHERE",
            Self::ObjectsNotMigrated { .. } => "OBJECTS_NOT_MIGRATED",
            Self::ContentBusy => "CONTENT_BUSY",
            Self::InvalidText => "INVALID_TEXT",
            Self::StoreNotMigrated { .. } => "STORE_NOT_MIGRATED",
            Self::ContentLost { .. } => "CONTENT_LOST",
            Self::ContentDamaged { .. } => "CONTENT_DAMAGED",
            Self::CorruptRow { .. } => "CORRUPT_ROW",
            Self::Database(_) | Self::Migration(_) => "DATABASE_FAILED",
            Self::Objects(_) | Self::Io(_) => "FILES_FAILED",
            Self::Failpoint(_) => "FAILPOINT",
        }
    }
}

impl From<sqlx::Error> for Error {
    fn from(error: sqlx::Error) -> Self {
        const BUSY: i64 = 5;
        const LOCKED: i64 = 6;
        const CORRUPT: i64 = 11;
        const FULL: i64 = 13;
        const NOT_A_DATABASE: i64 = 26;
        /// The index of the log cannot grow: its file is as large as the disk lets it be.
        const SHARED_MEMORY_SIZE: i64 = 4874;
        use sqlx::Error::{BeginFailed, Io, PoolClosed, PoolTimedOut, Protocol, Tls};
        match &error {
            PoolTimedOut => return Self::DatabaseBusy,
            // Of a connection that broke: SQLite has none of these.
            Io(_) | Tls(_) | Protocol(_) | BeginFailed | PoolClosed => {
                return Self::DatabaseUnavailable;
            }
            _ => {}
        }
        if let Some(state) = sql_state(&error) {
            return of_state(&state).unwrap_or(Self::Database(error));
        }
        let code = error.as_database_error().and_then(|e| e.code()?.parse::<i64>().ok());
        // Extended codes have the primary one in the low byte.
        match code.map(|code| (code, code & 0xff)) {
            Some((SHARED_MEMORY_SIZE, _) | (_, FULL)) => Self::DiskFull,
            Some((_, BUSY | LOCKED)) => Self::DatabaseBusy,
            Some((_, CORRUPT | NOT_A_DATABASE)) => {
                Self::DatabaseDamaged { fault: error.to_string() }
            }
            _ => Self::Database(error),
        }
    }
}

/// The code of an error that PostgreSQL reports.
fn sql_state(error: &sqlx::Error) -> Option<String> {
    let found = error.as_database_error()?;
    let found = found.try_downcast_ref::<sqlx::postgres::PgDatabaseError>()?;
    Some(found.code().to_owned())
}

/// What a code of PostgreSQL means here, if it is anything but a fault of this program.
fn of_state(state: &str) -> Option<Error> {
    const NUL_IN_TEXT: &str = "22021";
    /// A prepared statement whose table has another form by now.
    const STALE_PLAN: &str = "0A000";
    const DISK_FULL: &str = "53100";
    const LOCK_TIMEOUT: &str = "55P03";
    const CANCELLED: &str = "57014";
    const IDLE_IN_TRANSACTION: &str = "25P03";
    /// Shutting down, crashed, starting up.
    const DOWN: [&str; 3] = ["57P01", "57P02", "57P03"];
    let class = state.get(..2).unwrap_or_default();
    match state {
        NUL_IN_TEXT => Some(Error::InvalidText),
        DISK_FULL => Some(Error::DiskFull),
        STALE_PLAN => {
            plans::refused();
            Some(Error::DatabaseBusy)
        }
        LOCK_TIMEOUT | CANCELLED | IDLE_IN_TRANSACTION => Some(Error::DatabaseBusy),
        state if DOWN.contains(&state) => Some(Error::DatabaseUnavailable),
        // Connections, too many of them, deadlocks and lost races.
        _ if class == "08" || class == "53" => Some(Error::DatabaseUnavailable),
        _ if class == "40" => Some(Error::DatabaseBusy),
        _ => None,
    }
}

impl From<sqlx::migrate::MigrateError> for Error {
    fn from(error: sqlx::migrate::MigrateError) -> Self {
        use sqlx::migrate::MigrateError;
        match error {
            MigrateError::Execute(error) | MigrateError::ExecuteMigration(error, _) => {
                match error.into() {
                    Self::Database(error) => Self::Migration(MigrateError::Execute(error)),
                    known => known,
                }
            }
            error => Self::Migration(error),
        }
    }
}

impl From<std::io::Error> for Error {
    fn from(error: std::io::Error) -> Self {
        if disk::is_full(&error) { Self::DiskFull } else { Self::Io(error) }
    }
}

impl From<object_store::Error> for Error {
    fn from(error: object_store::Error) -> Self {
        let mut source: Option<&(dyn std::error::Error + 'static)> = Some(&error);
        while let Some(e) = source {
            if e.downcast_ref::<std::io::Error>().is_some_and(disk::is_full) {
                return Self::DiskFull;
            }
            source = e.source();
        }
        Self::Objects(error)
    }
}
