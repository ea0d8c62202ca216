//! Reasons why a rollout is refused or fails.

use bendtwin_contract::{picture, registration, rollout};
use bendtwin_core::Problem;
use bendtwin_engine::backend;
use bendtwin_proto::tensor::TensorError;
use bendtwin_register as register;

/// Reason why a rollout is refused or fails.
#[derive(Debug, thiserror::Error, Problem)]
pub enum Error {
    /// The request is wrong, too large or does not fit the twin.
    #[error(transparent)]
    Request(#[from] rollout::Error),
    /// The registration or correction is wrong, too large or does not fit the twin.
    #[error(transparent)]
    Observation(#[from] registration::Error),
    /// The pictures are wrong or too large.
    #[error(transparent)]
    Picture(#[from] picture::Error),
    /// The twin has no Gaussians.
    #[error(
        "{twin} has no Gaussians: ask for SURFACE, or fit its capture with appearance.gaussians"
    )]
    #[problem(FailedPrecondition, "GAUSSIANS_UNKNOWN")]
    NoGaussians {
        /// twins/{uuid}
        twin: String,
    },
    /// The Gaussians of the twin cannot be drawn.
    #[error(transparent)]
    Appearance(#[from] bendtwin_appearance::Error),
    /// The twin does not explain the observation.
    #[error(transparent)]
    Register(register::Error),
    /// A state of a session does not.
    #[error("slot {slot}: {error}")]
    #[problem(transparent)]
    Correct {
        /// The slot.
        slot: usize,
        /// The refusal.
        error: register::Error,
    },
    /// A state of a session does not follow its object any more.
    #[error(
        "slot {slot} is lost ({unexplained} observations in a row are not explained, mean misfit {misfit:.2}): set \
         `options.register_if_lost`, or reset it to a state that `register` finds. This time {error}",
        misfit = tracking.misfit, unexplained = tracking.unexplained
    )]
    #[problem(FailedPrecondition, "OBJECT_LOST")]
    Lost {
        /// The slot.
        slot: usize,
        /// Tracking record of the slot.
        tracking: register::Tracking,
        /// The refusal.
        error: register::Error,
    },
    /// The session is not here.
    #[error(
        "{name} is not there: its worker was lost, or nobody used it for a while. Open another from the last state that a reply brought"
    )]
    #[problem(Aborted, "SESSION_LOST")]
    SessionLost {
        /// Name of the session.
        name: String,
    },
    /// The limit of open sessions is reached.
    #[error(
        "{limit} sessions are open on this worker: close one, or wait until one has been idle for its time-out"
    )]
    #[problem(ResourceExhausted, "TOO_MANY_SESSIONS")]
    TooManySessions {
        /// Number of sessions that it takes.
        limit: usize,
    },
    /// The twin cannot be evaluated on the capture.
    #[error(transparent)]
    Evaluation(bendtwin_eval::Error),
    /// The capture cannot be replayed.
    #[error("the capture cannot be replayed with this twin: {0}")]
    #[problem(FailedPrecondition, "CAPTURE_NOT_REPLAYABLE")]
    Capture(String),
    /// The replay of the capture left the finite numbers.
    #[error(
        "the twin diverges in frame {frame} of the capture's replay: start at an earlier frame"
    )]
    #[problem(FailedPrecondition, "REPLAY_DIVERGED")]
    ReplayDiverged {
        /// Frame of the capture.
        frame: usize,
    },
    /// The motion is not plausible, and the request wants that refused.
    #[error("the motion is not plausible: {what}")]
    #[problem(FailedPrecondition, "IMPLAUSIBLE_MOTION")]
    Implausible {
        /// Finding and advice.
        what: String,
    },
    /// The twin left the finite numbers while it was to come to rest.
    #[error(
        "the twin diverges {after_s:.2} s after it was let go at rest, so it has no settled state: start at rest or \
         in a frame of a capture"
    )]
    #[problem(FailedPrecondition, "SETTLING_DIVERGED")]
    SettlingDiverged {
        /// Time of it [s].
        after_s: f64,
    },
    /// The twin does not come to rest.
    #[error(
        "the twin still moves at {speed_m_s:.3} m/s after {after_s:.0} s, so it has no settled state: hold it with \
         control points, give it a ground, or start at rest"
    )]
    #[problem(FailedPrecondition, "NEVER_AT_REST")]
    NeverAtRest {
        /// Speed of the fastest node [m/s].
        speed_m_s: f64,
        /// Time that it had [s].
        after_s: f64,
    },
    /// The engine refuses or fails.
    #[error(transparent)]
    Engine(#[from] backend::Error),
}

impl Error {
    /// A wrong field.
    pub fn field(field: impl Into<String>, fault: impl Into<String>) -> Self {
        Self::Request(rollout::Error::field(field, fault))
    }

    /// The refusal of a correction of a slot with this record.
    pub(crate) fn of_slot(
        slot: usize,
        tracking: register::Tracking,
        error: register::Error,
    ) -> Self {
        match error {
            register::Error::NotExplained { .. } if tracking.is_lost() => {
                Self::Lost { slot, tracking, error }
            }
            register::Error::NotExplained { .. } => Self::Correct { slot, error },
            other => other.into(),
        }
    }
}

impl From<register::Error> for Error {
    fn from(error: register::Error) -> Self {
        match error {
            register::Error::Cancelled => Self::Engine(backend::Error::Cancelled),
            register::Error::Backend(error) => Self::Engine(error),
            other => Self::Register(other),
        }
    }
}

impl From<bendtwin_eval::Error> for Error {
    fn from(error: bendtwin_eval::Error) -> Self {
        match error {
            bendtwin_eval::Error::Backend(error) => Self::Engine(error),
            bendtwin_eval::Error::Register(error) => error.into(),
            other => Self::Evaluation(other),
        }
    }
}

impl From<TensorError> for Error {
    fn from(error: TensorError) -> Self {
        Self::Request(error.into())
    }
}
