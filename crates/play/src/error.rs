//! The error of plays.

use std::time::Duration;

use bendtwin_core::{Fault, Problem};

/// Delay before another attempt where something else has to happen first.
const SOON: Duration = Duration::from_secs(1);

/// Result with this crate's [`Error`].
pub type Result<T, E = Error> = std::result::Result<T, E>;

/// An error of a play, or of the host that it runs in.
#[derive(Debug, thiserror::Error, Problem)]
pub enum Error {
    /// A message or a document has a value that is not accepted.
    #[error("`{field}` {fault}")]
    #[problem(InvalidArgument, "INVALID_FIELD")]
    Invalid {
        /// The field.
        field: &'static str,
        /// The fault of its value.
        fault: String,
    },
    /// There are as many plays, or watchers of a play, as the host allows.
    #[error("{most} {what} already: close one, or raise {option}")]
    #[problem(ResourceExhausted, "PLAYS_FULL")]
    Full {
        /// What the host bounds.
        what: &'static str,
        /// The bound.
        most: usize,
        /// The option of the host that sets it.
        option: &'static str,
    },
    /// The play has ended, or runs in another host.
    #[error(
        "{0} is not there: the page that played it was closed, or it is at another server. Plays live \
         at the server that began them: call that one, or begin another"
    )]
    #[problem(NotFound, "PLAY_NOT_FOUND")]
    Ended(String),
    /// The play was left alone for too long.
    #[error("nobody has touched the play for {} s: open it again", .0.as_secs())]
    #[problem(Aborted, "PLAY_IDLE")]
    Idle(Duration),
    /// Messages come faster than they can be read.
    #[error("messages come faster than they can be taken in: send at most 200 a second")]
    #[problem(ResourceExhausted, "PLAY_TOO_FAST")]
    TooFast,
    /// The play has no recording.
    #[error("nothing was recorded in this play: record something, or put a recording")]
    #[problem(FailedPrecondition, "NOTHING_RECORDED")]
    NothingRecorded,
    /// The host is stopping.
    #[error("the server is stopping: retry")]
    #[problem(Unavailable, "STOPPING", retry = SOON)]
    Stopping,
    /// The answer of a worker cannot be read.
    #[error("{0}")]
    #[problem(Internal, "INTERNAL")]
    Unreadable(String),
    /// An error of the host, unchanged.
    #[error("{fault}")]
    #[problem(fault.category, "WORKER_FAULT", retry = *retry_after, fault = fault.clone())]
    Host {
        /// The error in its portable form.
        fault: Fault,
        /// Delay after which another attempt makes sense.
        retry_after: Option<Duration>,
    },
}

impl Error {
    /// An error of a field's value.
    pub fn invalid(field: &'static str, fault: impl Into<String>) -> Self {
        Self::Invalid { field, fault: fault.into() }
    }
}
