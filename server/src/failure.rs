//! The error of use cases and of dispatch, below both. It knows no transport: `error.rs` turns it
//! into one.

use std::time::Duration;

use bendtwin_budget::Exhausted;
use bendtwin_core::{Category, Fault, Problem, ids::InvalidName};

use crate::memory::is_passing;

/// Result with this module's [`Error`].
pub(crate) type Result<T, E = Error> = std::result::Result<T, E>;

/// An error of a use case, or of the routing below it.
#[derive(Debug, thiserror::Error)]
pub(crate) enum Error {
    #[error(transparent)]
    Store(#[from] bendtwin_store::Error),
    #[error("{0}")]
    Name(InvalidName),
    #[error("`{field}` {fault}")]
    Invalid { field: &'static str, fault: String },
    #[error(transparent)]
    Rollout(#[from] bendtwin_contract::rollout::Error),
    #[error(transparent)]
    Registration(#[from] bendtwin_contract::registration::Error),
    #[error(transparent)]
    Plan(#[from] bendtwin_contract::plan::Error),
    #[error(
        "every plan diverged, the nominal one too: lower sigma, bound the speed or shorten the \
         horizon, and see that row 0 is where the control points are"
    )]
    EveryPlanDiverged,
    #[error("the settings are not accepted: {}", .0.join("; "))]
    Settings(Vec<String>),
    /// No worker has the memory for a fit.
    #[error("{0}")]
    FitTooLarge(String),
    #[error(transparent)]
    TwinFile(#[from] bendtwin_core::twin::format::FormatError),
    #[error("the upload was interrupted: {0}")]
    UploadBroken(String),
    #[error("the upload was silent for {} s: send it again", .0.as_secs())]
    UploadIdle(Duration),
    #[error("the body of the request came too slowly: send it again, over a better connection")]
    BodyTooSlow,
    #[error(
        "the upload continues at byte {offset}, not at {given}: query its offset and send from there"
    )]
    UploadOffset { given: u64, offset: u64 },
    #[error("the upload would be longer than {limit} bytes, which is its length or the limit")]
    UploadTooLong { limit: u64 },
    #[error("another request has taken over the upload: wait for its end, then resume")]
    UploadTakenOver,
    #[error("the checksum does not match the bytes received: send them again")]
    ChecksumMismatch,
    #[error("the worker token is missing or unknown")]
    BadToken,
    #[error("{0} is not registered: register it first")]
    WorkerUnknown(String),
    #[error("the call does not show the key of {0}: a worker acts for itself alone")]
    WorkerKeyMismatch(String),
    #[error("{0} is no content of a job that this worker has")]
    NotLeased(String),
    #[error("the worker sent {what} that is not what it should be: {fault}")]
    Unsound { what: &'static str, fault: String },
    #[error("no worker is ready for rollouts: retry, or start one")]
    NoWorker,
    #[error("the workers that were chosen for the rollout cannot be reached: retry")]
    WorkerLost,
    #[error(
        "{0} is not there: its worker was lost, or nobody used it for a while. Open another from the \
         last state that a reply brought"
    )]
    SessionLost(String),
    #[error(
        "{0} is at a worker that answers only the server which started it: send the call to that \
         server, or start workers by themselves (workers.count = 0), which answer every server"
    )]
    SessionElsewhere(String),
    #[error(
        "the worker ended, or the connection to it broke, while it computed this rollout: it was \
         not sent to another worker, which it might end as well. Send it again with fewer \
         instances or frames, or once more as it is if the worker was stopped"
    )]
    WorkerEnded,
    #[error(
        "too many rollouts wait for the workers already: retry in {} s, or start more workers",
        .retry_after.as_secs_f64().ceil()
    )]
    Busy { retry_after: Duration },
    #[error("the deadline passed before the answer was there: ask for less or allow more time")]
    Deadline,
    #[error("{exhausted}, for {purpose}{}", if is_passing(.exhausted) { ", or retry" } else { "" })]
    Memory { purpose: &'static str, exhausted: Exhausted },
    #[error("the server is stopping: retry")]
    Stopping,
    #[error("{most} {what} already: close one, or raise {option}")]
    PlayFull { what: &'static str, most: usize, option: &'static str },
    #[error(
        "{0} is not there: the page that played it was closed, or it is at another server. Plays live \
         at the server that began them: call that one, or begin another"
    )]
    PlayEnded(String),
    #[error("nobody has touched the play for {} s: open it again", .0.as_secs())]
    PlayIdle(Duration),
    #[error("messages come faster than they can be taken in: send at most 200 a second")]
    PlayTooFast,
    #[error("nothing was recorded in this play: record something, or put a recording")]
    NothingRecorded,
    /// The answer of a worker, unchanged.
    #[error("{0}")]
    Worker(Fault),
    #[error("{0}")]
    Internal(String),
}

impl Error {
    pub(crate) fn invalid(field: &'static str, fault: impl Into<String>) -> Self {
        Self::Invalid { field, fault: fault.into() }
    }

    /// Delay after which another attempt makes sense, if it does.
    pub(crate) fn retry_after(&self) -> Option<Duration> {
        match self {
            Self::Busy { retry_after } => Some(*retry_after),
            Self::WorkerLost => Some(Duration::from_millis(250)),
            Self::Store(
                bendtwin_store::Error::UploadLocked { .. }
                | bendtwin_store::Error::DatabaseBusy
                | bendtwin_store::Error::DatabaseUnavailable,
            )
            | Self::UploadTakenOver
            | Self::NoWorker
            | Self::Stopping => Some(Duration::from_secs(1)),
            Self::Memory { exhausted, .. } => {
                is_passing(exhausted).then_some(Duration::from_secs(1))
            }
            Self::Worker(fault) if fault.category == Category::ResourceExhausted => {
                Some(Duration::from_millis(250))
            }
            _ => None,
        }
    }
}

impl Problem for Error {
    fn category(&self) -> Category {
        match self {
            Self::Store(error) => error.category(),
            Self::TwinFile(error) => error.category(),
            Self::Rollout(error) => error.category(),
            Self::Registration(error) => error.category(),
            Self::Plan(error) => error.category(),
            Self::EveryPlanDiverged => Category::FailedPrecondition,
            Self::Worker(fault) => fault.category,
            Self::Name(_)
            | Self::Invalid { .. }
            | Self::Settings(_)
            | Self::FitTooLarge(_)
            | Self::UploadBroken(_)
            | Self::UploadIdle(_)
            | Self::BodyTooSlow
            | Self::UploadTooLong { .. }
            | Self::ChecksumMismatch
            | Self::Unsound { .. } => Category::InvalidArgument,
            Self::UploadOffset { .. }
            | Self::UploadTakenOver
            | Self::SessionLost(_)
            | Self::SessionElsewhere(_)
            | Self::PlayIdle(_) => Category::Aborted,
            Self::BadToken => Category::Unauthenticated,
            Self::WorkerKeyMismatch(_) | Self::NotLeased(_) => Category::PermissionDenied,
            Self::WorkerUnknown(_) | Self::PlayEnded(_) => Category::NotFound,
            Self::NoWorker | Self::WorkerLost | Self::WorkerEnded | Self::Stopping => {
                Category::Unavailable
            }
            Self::Busy { .. } | Self::PlayFull { .. } | Self::PlayTooFast => {
                Category::ResourceExhausted
            }
            Self::NothingRecorded => Category::FailedPrecondition,
            // Sent again, it would be refused again.
            Self::Memory { exhausted: Exhausted::TooLarge { .. }, .. } => Category::InvalidArgument,
            Self::Memory { .. } => Category::ResourceExhausted,
            Self::Deadline => Category::DeadlineExceeded,
            Self::Internal(_) => Category::Internal,
        }
    }

    fn reason(&self) -> &'static str {
        match self {
            Self::Store(error) => error.reason(),
            Self::TwinFile(error) => error.reason(),
            Self::Rollout(error) => error.reason(),
            Self::Registration(error) => error.reason(),
            Self::Plan(error) => error.reason(),
            Self::EveryPlanDiverged => "EVERY_PLAN_DIVERGED",
            Self::Name(_) => "INVALID_NAME",
            Self::Invalid { .. } => "INVALID_FIELD",
            Self::Settings(_) => "INVALID_SETTINGS",
            Self::FitTooLarge(_) => "FIT_OUT_OF_MEMORY",
            Self::UploadBroken(_) => "UPLOAD_BROKEN",
            Self::UploadIdle(_) => "UPLOAD_IDLE",
            Self::BodyTooSlow => "BODY_TOO_SLOW",
            Self::UploadOffset { .. } => "UPLOAD_OFFSET",
            Self::UploadTooLong { .. } => "CONTENT_TOO_LARGE",
            Self::UploadTakenOver => "UPLOAD_TAKEN_OVER",
            Self::ChecksumMismatch => "CHECKSUM_MISMATCH",
            Self::BadToken => "BAD_WORKER_TOKEN",
            Self::WorkerKeyMismatch(_) => "WORKER_KEY_MISMATCH",
            Self::NotLeased(_) => "CONTENT_NOT_LEASED",
            Self::Unsound { .. } => "RESULT_UNSOUND",
            Self::WorkerUnknown(_) => "WORKER_UNKNOWN",
            Self::NoWorker => "NO_WORKER",
            Self::SessionLost(_) => "SESSION_LOST",
            Self::SessionElsewhere(_) => "SESSION_ELSEWHERE",
            Self::WorkerLost | Self::WorkerEnded => "WORKER_LOST",
            Self::Busy { .. } => "WORKERS_BUSY",
            Self::PlayFull { .. } => "PLAYS_FULL",
            Self::PlayEnded(_) => "PLAY_NOT_FOUND",
            Self::PlayTooFast => "PLAY_TOO_FAST",
            Self::PlayIdle(_) => "PLAY_IDLE",
            Self::NothingRecorded => "NOTHING_RECORDED",
            Self::Memory { exhausted: Exhausted::TooLarge { .. }, .. } => "MEMORY_TOO_SMALL",
            Self::Memory { .. } => "MEMORY_IN_USE",
            Self::Deadline => "DEADLINE_EXCEEDED",
            Self::Stopping => "STOPPING",
            Self::Worker(_) => "WORKER_FAULT",
            Self::Internal(_) => "INTERNAL",
        }
    }

    fn fault(&self) -> Fault {
        match self {
            Self::Worker(fault) => fault.clone(),
            _ => Fault {
                category: self.category(),
                reason: self.reason().to_owned(),
                message: self.to_string(),
            },
        }
    }
}
