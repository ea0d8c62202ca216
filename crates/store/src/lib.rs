//! The durable truth: captures, jobs (the queue), twins, workers, keys and blobs.
//!
//! Rows are in SQLite or PostgreSQL, content is in files or in S3 behind [`object_store`]. Acknowledged data survives
//! `kill -9` of any process and loss of power.
//!
//! # The queue as a design
//! A job is a row of `jobs`, of one of two kinds. An *ingest* reads a capture and
//! makes its observation and its report; there is one for each capture, made in
//! the transaction that makes the capture and replaced when it is run again. A
//! *fit* makes a twin of the observation. The states of either:
//!
//! ```text
//!              claim (epoch + 1)            complete
//!   queued ───────────────────────► running ────────► succeeded
//!     ▲ │                            │ │ │
//!     │ │ cancel                     │ │ └─ fail (permanent, or the third stalled attempt) ─► failed
//!     │ └───────────► cancelled ◄────┘ │    cancelled by the worker, or lost while cancelling
//!     └────────────────────────────────┘ released, failed, or lease expired
//! ```
//!
//! * **Claim** takes the queued job of a kind of highest priority, oldest first
//!   (a fit only once its capture's ingest has ended, small captures before large ones), adds 1 to
//!   `lease_epoch` and sets `lease_until`. One statement, so two claimants never
//!   get the same job.
//! * **Fencing**: every write of a worker shows its [`Lease`] and applies only while the job runs
//!   under that epoch at that worker; else [`Error::StaleLease`]
//!   and nothing changes. A lease that has run out but was not taken over still
//!   writes: expiry by itself changes nothing, the sweeper does.
//! * **Leases** end by the time for which this process has run ([`Store::lease_time`]), so that
//!   neither a clock that is set nor a process that stood still ends one. After a
//!   restart the leases of running jobs begin again. `lease_until` is for people in SQLite; in
//!   PostgreSQL it follows the database's clock, by which a lease must have ended, too,
//!   since another server may have renewed it.
//! * **Attempts**: a claim adds 1 to `stalled`; a checkpoint with new content or a
//!   report further along than any before resets it. An attempt that ends badly
//!   with `stalled` at [`MAX_STALLED_ATTEMPTS`] fails the job; the faults of all
//!   attempts stay with it. An attempt that other work of its worker ended (a rollout that
//!   killed it) does not count, up to [`MAX_INTERRUPTED_ATTEMPTS`] without progress.
//! * **Turns**: owners take turns at the claim. A running fit makes way for a fit of an owner that
//!   has none running ([`Turns`]): its worker releases it with its checkpoint. An owner has no more
//!   jobs running than the key allows with which they were created.
//! * **Time**: every report of a worker adds the lease time since the one before to the job's
//!   running time ([`JobTimes`]), by which the server ends fits that run too long, and takes jobs away
//!   that make no progress.
//! * **Completion** inserts the twin, or observation and report, and ends the job
//!   in one transaction, and is idempotent for one lease, so a lost reply can be
//!   asked for again.
//! * **An ingest that fails** or is cancelled fails the fits that wait for it, in
//!   the same transaction and with its fault, and all that are asked for later. An
//!   observation is replaced by the next ingest that succeeds, and only while no
//!   fit of the capture is queued or running: a fit never sees two.
//!
//! # Losses of a fit
//! The table `losses` has a row for each stage, model and iteration, written with the reports of
//! its worker, up to 4096 for a fit: then every second iteration is forgotten. Losses of an
//! attempt replace those that an earlier one computed from there on, so the rows describe the path
//! to the twin, from any checkpoint. They stay until the fit is deleted. The table `previews` has the
//! newest preview of a fit until it has a twin.
//!
//! # Content before rows
//! A blob is written under `incoming/`, synced, and renamed (or sent) to the name that its
//! BLAKE3 digest gives it, all before the transaction that first refers to it.
//! So a crash can leave blobs without rows, never rows without blobs. Equal
//! content is one blob. It is deleted when a row went and no other refers to it:
//! the check and the deletion hold a gate that publishing shares, so a
//! reference cannot appear in between. The remains of crashes, and of callers that
//! went away in mid-call, are moved to a trash folder by [`Store::collect_garbage`],
//! and removed a day later. Database and blobs have a common identity: [`Store::open`] refuses to
//! make garbage of the blobs of another database.
//!
//! # Requests that come again
//! The row of what a request made has its request id, so a repetition finds it. Each owner has its
//! own ids (`owners::request_ids`). The id outlives the row for a day (`owners::deleted_requests`): an attempt that its client had given up, and that comes to its
//! end after the deletion, makes nothing.
//!
//! # The trash
//! A deleted capture, fit or twin keeps its row, with a time at which it is purged ([`trash`](Trash)):
//! references, quotas, backups and the check count it as before. Reading such a row as a resource
//! fails ([`Error::InTrash`]), and lists leave it out. A job in the trash is in no queue.
//!
//! # Content that is not what it was
//! Sizes are compared when content is opened, digests while it is read: damaged
//! content never arrives whole. [`maintenance`] has the check of a whole store, its
//! repair and its backup.
//!
//! # A full disk
//! A reserve file is given up when the database meets a full disk, so that
//! deletions and the ends of jobs get through; new content is refused until the
//! reserve is there again. A connection whose transaction SQLite ended by itself
//! is closed, so that writes work again as soon as the disk has room.
//!
//! The crash points are named in [`failpoint`] and are inputs of the tests.
//!
//! # Quotas of bytes
//! No byte of a client is written for which its owner has no room. Content has its bytes set aside
//! before they are received, in the row of its resumable upload or in one of `reservations`, within
//! the transaction that compares them with the bound; so uploads at the same time, also at several
//! servers, do not exceed it together. `keys::quotas` has the rules. Results of workers are stored
//! beyond the bound, too: they count, and their owner makes nothing new until it has room again.
//!
//! # SQLite and PostgreSQL
//! SQL is in one file per aggregate, in what both dialects share (`$1`, `returning`, `on conflict`),
//! and so are the migrations. `sql` runs a statement on either database. The differences are in
//! `database`: in SQLite the pragmas, one connection that writes, the lock on the folder; in PostgreSQL
//! the pools, time limits, notifications and the lock on writing. A transaction that writes excludes
//! all others in both: what it has read stays true until it commits, so a check of an epoch needs no
//! second one in the update. Text has the order of its bytes, and leases are measured by the
//! database's clock where it has one.
//!
//! # Content in a bucket
//! Content is in the folder, in a folder that servers share, or in a bucket of S3: the *place*
//! ([`blobs`](Blobs)). If several servers may use it, no lock of this process keeps deletions away
//! from publications; `blobs::arrivals` has the protocol that does, in rows, and `uploads::lease` that by
//! which one server at a time writes to a resumable upload.

pub mod bench;
mod blobs;
mod captures;
mod database;
mod error;
pub mod failpoint;
mod fleet;
mod folder;
mod jobs;
mod keys;
mod labels;
mod listing;
pub mod maintenance;
mod owners;
mod sql;
mod store;
mod trash;
mod twins;
mod uploads;

pub use blobs::{Blobs, Content, ObjectsUrl, Staged, Upload};
pub use captures::{
    Capture, CaptureChange, CaptureFacts, Captures, NewCapture, Overview,
    observations::{Observation, Report},
    supplements::{NewSupplement, Supplement, SupplementKind, UnknownKind},
};
pub use database::DatabaseUrl;
pub use error::{Error, Result};
pub use fleet::{
    servers::{Server, Servers},
    workers::{NewWorker, Worker, Workers},
};
pub use folder::disk::Disk;
pub use jobs::{
    AttemptEnd, Capabilities, Claimant, IngestOutcome, IngestResult, Job, JobId, JobReport,
    JobTimes, Jobs, Kind, Lease, LeaseTerms, MAX_INTERRUPTED_ATTEMPTS, MAX_STALLED_ATTEMPTS,
    NewFit, NewIngest, NewReport, QueueDepth, Reported, Requirements, State, StoredPreview, Turns,
    WorkerEnd,
};
pub use keys::usage::{OwnerUsage, StoredBytes, Usage};
pub use keys::{
    Key, Keys, NewKey, NewShare, Share, SignedIn,
    quotas::{Creator, Quotas, reservation::Incoming},
};
pub use labels::{Collection, LabelChange, Labels, MAX_TAGS};
pub use listing::{
    ListQuery, Order, OrderKey,
    page::{Page, PageRequest},
};
pub use owners::{
    Owners,
    projects::{MAX_MEMBERS, MemberChange, Memberships, Project, ProjectChange, Projects},
};
pub use store::meter::{Call, Observer, Part};
pub use store::{
    Options, Store,
    clock::{Clock, ManualClock, SystemClock},
};
pub use trash::{
    Deletion, Trash, Trashed,
    resource::Resource,
    retention::{KEEP_TAG, Kept, Match, NewRule, Preview, Retention, Rule},
};
pub use twins::{NewTwin, Twin, TwinFacts, Twins};
pub use uploads::{
    FIRST_ROOM, NewResumableUpload, ResumableUpload, UploadBounds, UploadState, UploadUse,
    UploadWriter, Uploads,
};

/// Name of the file in a data folder with the token of clients.
pub const CLIENT_TOKEN: &str = "client-token";

/// BLAKE3 digest of a blob.
pub use blake3::Hash as Digest;
