//! The error of use cases and of dispatch, below both. It knows no transport: `refusal.rs` turns it
//! into one.

use std::time::Duration;

use bendtwin_budget::Exhausted;
use bendtwin_core::{
    Category, Fault, Problem,
    ids::{InvalidName, TwinId},
};

/// Delay before another attempt where something else has to happen first.
const SOON: Duration = Duration::from_secs(1);
/// Delay before another attempt at another worker, or at one whose queue moves.
const MOMENT: Duration = Duration::from_millis(250);

/// Result with this module's [`Error`].
pub(crate) type Result<T, E = Error> = std::result::Result<T, E>;

/// An error of a use case, or of the routing below it.
#[derive(Debug, thiserror::Error, Problem)]
pub(crate) enum Error {
    #[error(transparent)]
    Store(#[from] bendtwin_store::Error),
    #[error("{0}")]
    #[problem(InvalidArgument, "INVALID_NAME")]
    Name(InvalidName),
    #[error("`{field}` {fault}")]
    #[problem(InvalidArgument, "INVALID_FIELD")]
    Invalid { field: &'static str, fault: String },
    #[error(transparent)]
    KeyEnded(#[from] crate::access::Ended),
    #[error(transparent)]
    Shared(#[from] crate::access::Limited),
    #[error(
        "the key lacks the scope rollouts:run, without which nobody lets others play: use a key that \
         has it"
    )]
    #[problem(PermissionDenied, "SCOPE_MISSING")]
    ShareWithoutRollouts,
    #[error(
        "this server requires no token, so a link needs no key and would not end: everyone who reaches \
         the server can open /#/shared/{}",
        .twin.uuid()
    )]
    #[problem(FailedPrecondition, "SHARE_NOT_NEEDED")]
    ShareNotNeeded { twin: TwinId },
    #[error("{most} people play through {by} already: try again when somebody has stopped")]
    #[problem(ResourceExhausted, "SHARE_FULL")]
    ShareFull { by: &'static str, most: u64 },
    #[error(transparent)]
    SignIn(#[from] crate::sign_in::Error),
    #[error(transparent)]
    Rollout(#[from] bendtwin_contract::rollout::Error),
    #[error(transparent)]
    Registration(#[from] bendtwin_contract::registration::Error),
    #[error(transparent)]
    Picture(#[from] bendtwin_contract::picture::Error),
    #[error(transparent)]
    Plan(#[from] bendtwin_contract::plan::Error),
    #[error(
        "every plan diverged, the nominal one too: lower sigma, bound the speed or shorten the \
         horizon, and see that row 0 is where the control points are"
    )]
    #[problem(FailedPrecondition, "EVERY_PLAN_DIVERGED")]
    EveryPlanDiverged,
    #[error(
        "no plan grasps anything at any of the places: no grasp of the searched grippers finds a node in its \
         region. Put the poses where nodes are (TwinGeometry, in the initial state), widen the regions, and \
         see that `closed` is 1 at the start or on the way"
    )]
    #[problem(FailedPrecondition, "NOTHING_GRASPED")]
    NothingGrasped,
    #[error("the settings are not accepted: {}", .0.join("; "))]
    #[problem(InvalidArgument, "INVALID_SETTINGS")]
    Settings(Vec<String>),
    #[error(
        "the key allows fits a priority of up to {most}, and this one has {priority}: leave the priority \
         out, or use a key made with `bendtwin key create --max-priority {priority}`"
    )]
    #[problem(PermissionDenied, "PRIORITY_TOO_HIGH")]
    PriorityTooHigh { priority: i32, most: i32 },
    /// No worker has the memory for a fit.
    #[error("{0}")]
    #[problem(InvalidArgument, "FIT_OUT_OF_MEMORY")]
    FitTooLarge(String),
    #[error("{0} has too few points for a surface or a picture: use its nodes")]
    #[problem(NotFound, "SURFACE_MISSING")]
    NoSurface(String),
    #[error(transparent)]
    Export(#[from] bendtwin_exchange::Error),
    #[error(transparent)]
    TwinFile(#[from] bendtwin_core::twin::format::FormatError),
    #[error("the upload was interrupted: {0}")]
    #[problem(InvalidArgument, "UPLOAD_BROKEN")]
    UploadBroken(String),
    #[error("the upload was silent for {} s: send it again", .0.as_secs())]
    #[problem(InvalidArgument, "UPLOAD_IDLE")]
    UploadIdle(Duration),
    #[error("the body of the request came too slowly: send it again, over a better connection")]
    #[problem(InvalidArgument, "BODY_TOO_SLOW")]
    BodyTooSlow,
    #[error(
        "the upload continues at byte {offset}, not at {given}: query its offset and send from there"
    )]
    #[problem(Aborted, "UPLOAD_OFFSET")]
    UploadOffset { given: u64, offset: u64 },
    #[error("the upload would be longer than {limit} bytes, which is its length or the limit")]
    #[problem(InvalidArgument, "CONTENT_TOO_LARGE")]
    UploadTooLong { limit: u64 },
    #[error("another request has taken over the upload: wait for its end, then resume")]
    #[problem(Aborted, "UPLOAD_TAKEN_OVER", retry = SOON)]
    UploadTakenOver,
    #[error("the checksum does not match the bytes received: send them again")]
    #[problem(InvalidArgument, "CHECKSUM_MISMATCH")]
    ChecksumMismatch,
    #[error(
        "{name} belongs to someone else than {owner} and the members of {owner}'s projects, and this \
         key has only {scope}:own: ask for a project with its owner (`bendtwin project add`), or for \
         a key with {scope}"
    )]
    #[problem(PermissionDenied, "NOT_OWNER")]
    NotOwner { name: String, owner: String, scope: &'static str },
    #[error(
        "{owner} is no member of {name}: ask someone with the scope admin for a membership \
         (`bendtwin project add`)"
    )]
    #[problem(PermissionDenied, "NOT_MEMBER")]
    NotMember { name: String, owner: String },
    #[error("the worker token is missing or unknown")]
    #[problem(Unauthenticated, "BAD_WORKER_TOKEN")]
    BadToken,
    #[error("{0} is not registered: register it first")]
    #[problem(NotFound, "WORKER_UNKNOWN")]
    WorkerUnknown(String),
    #[error("the call does not show the key of {0}: a worker acts for itself alone")]
    #[problem(PermissionDenied, "WORKER_KEY_MISMATCH")]
    WorkerKeyMismatch(String),
    #[error("{0} is no content of a job that this worker has")]
    #[problem(PermissionDenied, "CONTENT_NOT_LEASED")]
    NotLeased(String),
    #[error("the worker sent {what} that is not what it should be: {fault}")]
    #[problem(InvalidArgument, "RESULT_UNSOUND")]
    Unsound { what: &'static str, fault: String },
    #[error("no worker is ready for rollouts: retry, or start one")]
    #[problem(Unavailable, "NO_WORKER", retry = SOON)]
    NoWorker,
    #[error("the workers that were chosen for the rollout cannot be reached: retry")]
    #[problem(Unavailable, "WORKER_LOST", retry = MOMENT)]
    WorkerLost,
    #[error(
        "{0} is not there: its worker was lost, or nobody used it for a while. Open another from the \
         last state that a reply brought"
    )]
    #[problem(Aborted, "SESSION_LOST")]
    SessionLost(String),
    #[error(
        "{0} is at a worker that answers only the server which started it: send the call to that \
         server, or start workers by themselves (workers.count = 0), which answer every server"
    )]
    #[problem(Aborted, "SESSION_ELSEWHERE")]
    SessionElsewhere(String),
    #[error(
        "the worker ended, or the connection to it broke, while it computed this rollout: it was \
         not sent to another worker, which it might end as well. Send it again with fewer \
         instances or frames, or once more as it is if the worker was stopped"
    )]
    #[problem(Unavailable, "WORKER_LOST")]
    WorkerEnded,
    #[error(
        "too many rollouts wait for the workers already: retry in {} s, or start more workers",
        .retry_after.as_secs_f64().ceil()
    )]
    #[problem(ResourceExhausted, "WORKERS_BUSY", retry = *retry_after)]
    Busy { retry_after: Duration },
    #[error("the deadline passed before the answer was there: ask for less or allow more time")]
    #[problem(DeadlineExceeded, "DEADLINE_EXCEEDED")]
    Deadline,
    #[error("{exhausted}, for {purpose}{}", if .exhausted.is_passing() { ", or retry" } else { "" })]
    #[problem(ResourceExhausted, "MEMORY_IN_USE", retry = SOON, if exhausted.is_passing())]
    // Sent again, it would be refused again.
    #[problem(InvalidArgument, "MEMORY_TOO_SMALL")]
    Memory { purpose: &'static str, exhausted: Exhausted },
    #[error("the server is stopping: retry")]
    #[problem(Unavailable, "STOPPING", retry = SOON)]
    Stopping,
    /// An error of a play, with the reason that the host gave where a call of the play failed.
    #[error("{0}")]
    #[problem(_0.category(), "WORKER_FAULT", retry = _0.retry_after(), fault = _0.fault())]
    Play(#[from] bendtwin_play::Error),
    /// The answer of a worker, unchanged.
    #[error("{0}")]
    #[problem(_0.category, "WORKER_FAULT", retry = until_free(_0), fault = _0.clone())]
    Worker(Fault),
    #[error("{0}")]
    #[problem(Internal, "INTERNAL")]
    Internal(String),
}

impl Error {
    pub(crate) fn invalid(field: &'static str, fault: impl Into<String>) -> Self {
        Self::Invalid { field, fault: fault.into() }
    }
}

/// An error of a call that a play made.
impl From<Error> for bendtwin_play::Error {
    fn from(error: Error) -> Self {
        match error {
            Error::Play(error) => error,
            Error::Stopping => Self::Stopping,
            error => Self::Host { retry_after: error.retry_after(), fault: error.fault() },
        }
    }
}

/// Delay after which a worker that refused for its load may be free.
fn until_free(fault: &Fault) -> Option<Duration> {
    (fault.category == Category::ResourceExhausted).then_some(MOMENT)
}
