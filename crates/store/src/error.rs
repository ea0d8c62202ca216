//! Errors of the store.

use std::{path::PathBuf, time::Duration};

use bendtwin_core::{
    Problem,
    ids::{CaptureId, FitId, TwinId},
};
use bendtwin_tls::{FileError, TlsError};
use jiff::Timestamp;

use crate::{Digest, JobId, database::plans, folder::disk};

/// Delay after which what another request or the database holds may be free.
const SOON: Duration = Duration::from_secs(1);

/// Result with this crate's [`Error`].
pub type Result<T, E = Error> = std::result::Result<T, E>;

/// An error of the store.
#[derive(Debug, thiserror::Error, Problem)]
#[allow(missing_docs)] // The messages say it.
pub enum Error {
    #[error("{name} does not exist")]
    #[problem(NotFound, "NOT_FOUND")]
    NotFound { name: String },
    #[error(
        "{name} is in the trash until {until}: restore it with `bendtwin trash restore {name}`"
    )]
    #[problem(NotFound, "IN_TRASH")]
    InTrash { name: String, until: Timestamp },
    #[error(
        "{name} has no playback: wait for the end of its ingest or, if it was read before there were \
         playbacks, run the ingest again"
    )]
    #[problem(NotFound, "PLAYBACK_MISSING")]
    PlaybackMissing { name: String },
    #[error(
        "{name} has no preview: one is made while a fit searches and refines, and goes once it has a twin"
    )]
    #[problem(NotFound, "PREVIEW_MISSING")]
    PreviewMissing { name: String },
    #[error(
        "{name} has no masks of strokes: mark the object and run the ingest with the strokes \
         (docs/use/cameras.md#masks)"
    )]
    #[problem(NotFound, "CAPTURE_HAS_NO_MASKS")]
    MasksMissing { name: String },
    #[error(
        "request id `{request_id}` was used before for {name}, with other content: \
         choose a new request id"
    )]
    #[problem(AlreadyExists, "REQUEST_ID_TAKEN")]
    RequestIdTaken { request_id: String, name: String },
    #[error(
        "request id `{request_id}` made {name}, which has been deleted since: choose a new request id \
         to make another, or restore it if it is in the trash"
    )]
    #[problem(AlreadyExists, "DELETED_SINCE")]
    DeletedSince { request_id: String, name: String },
    #[error(
        "the lease {epoch} of {job} has been lost to another worker or the job has ended: stop"
    )]
    #[problem(Aborted, "STALE_LEASE")]
    StaleLease { job: JobId, epoch: u64 },
    #[error("{name} is used by {fits} queued or running fits: cancel them first")]
    #[problem(FailedPrecondition, "CAPTURE_IN_USE")]
    CaptureInUse { name: String, fits: u64 },
    #[error("the ingest of {name} is under way: wait for its end, or cancel it first")]
    #[problem(FailedPrecondition, "INGEST_UNDER_WAY")]
    IngestUnderWay { name: String },
    #[error("{name} has masks but no points: run its ingest up to points, then fit")]
    #[problem(FailedPrecondition, "CAPTURE_NOT_LIFTED")]
    CaptureHasNoPoints { name: CaptureId },
    #[error("{fit} is running: cancel it first")]
    #[problem(FailedPrecondition, "FIT_RUNNING")]
    FitRunning { fit: FitId },
    #[error("{name} would have more than {limit} tags: take some away first")]
    #[problem(InvalidArgument, "TOO_MANY_TAGS")]
    TooManyTags { name: String, limit: usize },
    #[error("a project has {limit} members at most: make another, or give people one owner")]
    #[problem(InvalidArgument, "TOO_MANY_MEMBERS")]
    TooManyMembers { limit: usize },
    #[error("there are {limit} projects, which is the limit: delete those that nobody needs")]
    #[problem(ResourceExhausted, "TOO_MANY_PROJECTS")]
    TooManyProjects { limit: i64 },
    #[error(
        "{twin} has {limit} links that are valid, which is the limit: revoke those that nobody needs \
         (`bendtwin twin shares`, `bendtwin twin unshare`)"
    )]
    #[problem(ResourceExhausted, "TOO_MANY_SHARES")]
    TooManyShares { twin: TwinId, limit: i64 },
    #[error(
        "{limit} different requirements wait in the queue already: ask for the same backend, memory and \
         labels as others do, or retry later"
    )]
    #[problem(ResourceExhausted, "TOO_MANY_REQUIREMENTS")]
    TooManyRequirements { limit: usize },
    #[error("the page token is not from this listing: start without one")]
    #[problem(InvalidArgument, "INVALID_PAGE_TOKEN")]
    InvalidPageToken,
    #[error("the content is larger than the limit of {limit} bytes")]
    #[problem(InvalidArgument, "CONTENT_TOO_LARGE")]
    TooLarge { limit: u64 },
    #[error("the content's BLAKE3 digest is {actual}, not {given}: send it again")]
    #[problem(InvalidArgument, "DIGEST_MISMATCH")]
    DigestMismatch { given: Digest, actual: Digest },
    #[error("{name} is gone: {why}")]
    #[problem(NotFound, "UPLOAD_GONE")]
    UploadGone { name: String, why: String },
    #[error("{name} is in use by another request: retry in a moment")]
    #[problem(Aborted, "UPLOAD_LOCKED", retry = SOON)]
    UploadLocked { name: String },
    #[error(
        "the upload cannot be {given} bytes long: {}",
        .known.map_or_else(|| format!("{offset} are here already"), |n| format!("its length is {n}"))
    )]
    #[problem(InvalidArgument, "UPLOAD_LENGTH")]
    UploadLength { given: u64, known: Option<u64>, offset: u64 },
    #[error(
        "there is no room for another upload beside those under way ({count} of them, {bytes} bytes): \
         finish or delete one, or retry later"
    )]
    #[problem(ResourceExhausted, "UPLOADS_FULL")]
    UploadsFull { count: u64, bytes: u64 },
    #[error(
        "{queued} jobs of {owner} wait already, and its key allows {limit}: wait for some to begin, or \
         cancel some"
    )]
    #[problem(ResourceExhausted, "QUOTA_QUEUED_JOBS")]
    QuotaJobs { owner: String, queued: u64, limit: u64 },
    #[error(
        "{owner} has {stored} bytes stored or on their way, which leaves no room for {more} more within \
         the {limit} that its key allows: delete captures or twins and empty \
         the trash, which counts, or terminate uploads"
    )]
    #[problem(ResourceExhausted, "QUOTA_STORED_BYTES")]
    QuotaBytes { owner: String, stored: u64, more: u64, limit: u64 },
    #[error("there are {limit} retention rules already: delete some")]
    #[problem(ResourceExhausted, "TOO_MANY_RETENTION_RULES")]
    TooManyRules { limit: u64 },
    #[error("the server's disk is full: free space or delete captures and twins")]
    #[problem(ResourceExhausted, "DISK_FULL")]
    DiskFull,
    #[error("the data folder is in use by another server: stop it or choose another folder")]
    #[problem(FailedPrecondition, "DATA_DIR_IN_USE")]
    DataDirInUse,
    #[error(
        "the data folder has content but no database {}: put the database back, or run \
         `bendtwin store repair` to begin a new one beside it", .file.display()
    )]
    #[problem(FailedPrecondition, "DATABASE_MISSING")]
    DatabaseMissing { file: PathBuf },
    #[error(
        "the database {database} and the content in {blobs} belong to different stores: put the right \
         one back, or run `bendtwin store repair` to join them"
    )]
    #[problem(FailedPrecondition, "STORE_MISMATCH")]
    StoreMismatch { database: String, blobs: String },
    #[error(
        "another server has the database {database} open, and its content is not in {blobs}: give this \
         server the content, too"
    )]
    #[problem(FailedPrecondition, "CONTENT_ELSEWHERE")]
    ContentElsewhere { database: String, blobs: String },
    #[error(
        "the store is in {} still and {database} is empty: run `bendtwin store migrate --to` with the \
         URL of that database, or choose another folder", .file.display()
    )]
    #[problem(FailedPrecondition, "STORE_NOT_MIGRATED")]
    StoreNotMigrated { file: PathBuf, database: String },
    #[error(
        "the database of this folder is {database}: name it (`--database`), or remove the file `postgres` \
         from the folder if the database is there no more"
    )]
    #[problem(FailedPrecondition, "DATABASE_ELSEWHERE")]
    DatabaseElsewhere { database: String },
    #[error("{database} is not empty: name a new database")]
    #[problem(FailedPrecondition, "DATABASE_NOT_EMPTY")]
    DatabaseNotEmpty { database: String },
    #[error("the rows of {table} differ in {database}: nothing was changed there, report this")]
    #[problem(DataLoss, "MIGRATION_DIFFERS")]
    MigrationDiffers { table: String, database: String },
    #[error("this is no URL of a PostgreSQL database: write `postgres://USER@HOST:PORT/DATABASE`")]
    #[problem(InvalidArgument, "INVALID_DATABASE_URL")]
    InvalidDatabaseUrl,
    #[error("the database cannot be used: {fault}")]
    #[problem(FailedPrecondition, "DATABASE_UNFIT")]
    DatabaseUnfit { fault: String },
    #[error(
        "a newer version of the program has changed the database ({name}, its migration {migration}; \
         this program knows {known}): start that version or a newer one; nothing has been changed"
    )]
    #[problem(FailedPrecondition, "DATABASE_NEWER")]
    DatabaseNewer { migration: i64, name: String, known: i64 },
    #[error(
        "a newer version of the program has had this store (migration {migration}): run this command of \
         that version, which knows all that is there"
    )]
    #[problem(FailedPrecondition, "DATABASE_NEWER")]
    StoreNewer { migration: i64 },
    #[error(
        "an older version of the program has this store (it lacks migration {migration}): run this \
         command of that version, or start a server of this version first; a backup of that version can \
         be restored with this one"
    )]
    #[problem(FailedPrecondition, "DATABASE_OLDER")]
    StoreOlder { migration: i64 },
    #[error(
        "this version changes the database so that older ones cannot use it, and {servers} servers \
         have it open: stop all of them (one that was killed counts for a minute), then start this \
         one; nothing has been changed"
    )]
    #[problem(FailedPrecondition, "OLDER_SERVERS_RUN")]
    OlderServersRun { servers: i64 },
    #[error("the database is damaged ({fault}): run `bendtwin store check`")]
    #[problem(DataLoss, "DATABASE_DAMAGED")]
    DatabaseDamaged { fault: String },
    #[error("the database cannot be rebuilt ({fault}): restore it from a backup")]
    #[problem(DataLoss, "DATABASE_DAMAGED")]
    BeyondRepair { fault: String },
    #[error("the database is locked by another program or overloaded: retry in a moment")]
    #[problem(Unavailable, "DATABASE_BUSY", retry = SOON)]
    DatabaseBusy,
    #[error("the database does not answer: retry in a moment")]
    #[problem(Unavailable, "DATABASE_UNAVAILABLE", retry = SOON)]
    DatabaseUnavailable,
    #[error(
        "this is no place for content: write `s3://BUCKET` or `s3://BUCKET/PREFIX`, or `file:///FOLDER`; \
         keys go into the environment (AWS_ACCESS_KEY_ID, AWS_SECRET_ACCESS_KEY)"
    )]
    #[problem(InvalidArgument, "INVALID_OBJECTS_URL")]
    InvalidObjectsUrl,
    #[error("the object storage does not answer: retry in a moment")]
    #[problem(Unavailable, "OBJECTS_UNAVAILABLE")]
    ObjectsUnavailable,
    #[error("no TLS with the object storage: {fault}")]
    #[problem(transparent)]
    ObjectsUntrusted { fault: TlsError },
    #[error("no TLS with the object storage: {0}")]
    #[problem(transparent)]
    Certificate(#[from] FileError),
    #[error(
        "the object storage refuses the server ({fault}): check the keys, the region and the endpoint in \
         its environment (AWS_*), and the bucket's policy"
    )]
    #[problem(FailedPrecondition, "OBJECTS_REFUSED")]
    ObjectsRefused { fault: String },
    #[error(
        "the content of this folder is in {objects}: name it (`--objects`), or remove the file `objects` \
         from the folder if it is there no more"
    )]
    #[problem(FailedPrecondition, "OBJECTS_ELSEWHERE")]
    ObjectsElsewhere { objects: String },
    #[error("the content of this folder is in {objects}: {advice}")]
    #[problem(FailedPrecondition, "OBJECTS_ELSEWHERE")]
    ObjectsNotLocal { objects: String, advice: &'static str },
    #[error(
        "the content is in {} still: run `bendtwin store migrate --to-objects` with the URL of its new \
         place", .folder.display()
    )]
    #[problem(FailedPrecondition, "OBJECTS_NOT_MIGRATED")]
    ObjectsNotMigrated { folder: PathBuf },
    #[error("equal content is being deleted at this moment: retry in a moment")]
    #[problem(Unavailable, "CONTENT_BUSY")]
    ContentBusy,
    #[error("text has a NUL character, which the database does not store: leave it out")]
    #[problem(InvalidArgument, "INVALID_TEXT")]
    InvalidText,
    #[error(
        "the folder {} is not empty and no backup: name a new one for the backup", .folder.display()
    )]
    #[problem(FailedPrecondition, "BACKUP_NOT_EMPTY")]
    BackupNotEmpty { folder: PathBuf },
    #[error(
        "the folder {} has a backup of another store (a restored store is another one): name a new folder",
        .folder.display()
    )]
    #[problem(FailedPrecondition, "BACKUP_OF_ANOTHER_STORE")]
    BackupOfAnother { folder: PathBuf },
    #[error(
        "another command or a server uses the backup in {}: retry when it has ended", .folder.display()
    )]
    #[problem(FailedPrecondition, "BACKUP_IN_USE")]
    BackupInUse { folder: PathBuf },
    #[error(
        "the first backup into {} has not been completed: run it again, or restore another", .folder.display()
    )]
    #[problem(FailedPrecondition, "BACKUP_INCOMPLETE")]
    BackupIncomplete { folder: PathBuf },
    #[error("the backup in {} is damaged ({fault}): restore another", .folder.display())]
    #[problem(DataLoss, "BACKUP_DAMAGED")]
    BackupDamaged { folder: PathBuf, fault: String },
    #[error("the file backup.json in {} cannot be read ({fault})", .folder.display())]
    #[problem(FailedPrecondition, "BACKUP_UNREADABLE")]
    BackupUnreadable { folder: PathBuf, fault: String },
    #[error(
        "the folder {} is a backup: restore it to a data folder (`bendtwin store restore`)", .folder.display()
    )]
    #[problem(FailedPrecondition, "IS_BACKUP")]
    IsBackup { folder: PathBuf },
    #[error(
        "the restore to {} has not ended: run the same `bendtwin store restore` again, which continues it, \
         or remove the folder and what it has restored", .folder.display()
    )]
    #[problem(FailedPrecondition, "RESTORE_UNFINISHED")]
    RestoreUnfinished { folder: PathBuf },
    #[error(
        "a restore of another backup, or to another database or bucket, has begun in {}: run that again, or \
         remove the folder and what it has restored", .folder.display()
    )]
    #[problem(FailedPrecondition, "ANOTHER_RESTORE")]
    AnotherRestore { folder: PathBuf },
    #[error("the folder {} is not empty: restore to a new data folder", .folder.display())]
    #[problem(FailedPrecondition, "DATA_DIR_NOT_EMPTY")]
    DataDirNotEmpty { folder: PathBuf },
    #[error("there is content in {objects}: restore to an empty bucket, or below another prefix")]
    #[problem(FailedPrecondition, "OBJECTS_NOT_EMPTY")]
    ObjectsNotEmpty { objects: String },
    #[error("the content {digest} of {name} is missing: run `bendtwin store check`")]
    #[problem(DataLoss, "CONTENT_LOST")]
    ContentLost { name: String, digest: String },
    #[error("the content {digest} of {name} is damaged ({fault}): run `bendtwin store check`")]
    #[problem(DataLoss, "CONTENT_DAMAGED")]
    ContentDamaged { name: String, digest: String, fault: String },
    #[error("stored row of {name}: {fault}")]
    #[problem(DataLoss, "CORRUPT_ROW")]
    CorruptRow { name: String, fault: String },
    #[error("database: {0}")]
    #[problem(Internal, "DATABASE_FAILED")]
    Database(#[source] sqlx::Error),
    #[error("migration of the database: {0}")]
    #[problem(Internal, "DATABASE_FAILED")]
    Migration(#[source] sqlx::migrate::MigrateError),
    #[error("files: {0}")]
    #[problem(Internal, "FILES_FAILED")]
    Objects(#[source] object_store::Error),
    #[error("files: {0}")]
    #[problem(Internal, "FILES_FAILED")]
    Io(#[source] std::io::Error),
    #[error("stopped at {0:?}")]
    #[problem(Internal, "FAILPOINT")]
    Failpoint(crate::failpoint::Failpoint),
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

/// Meaning of a code of PostgreSQL, unless it is a fault of this program.
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
