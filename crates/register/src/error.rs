//! Errors of registration and correction.

use bendtwin_core::Problem;
use bendtwin_engine::backend;

/// An observation that is refused, or that the twin does not explain.
#[derive(Clone, Debug, PartialEq, thiserror::Error, Problem)]
pub enum Error {
    /// The observation, the state or an option contradicts the twin.
    #[error("the observation cannot be used: {0}")]
    #[problem(InvalidArgument, "INVALID_OBSERVATION")]
    Invalid(String),
    /// The twin cannot be brought near enough to the points.
    #[error(
        "the twin stays {median_mm:.1} mm (median) from the observed points, with {share:.0} % of them \
         within reach; at most {limit_mm:.1} mm and at least {least_share:.0} % are accepted: check that \
         the points are of this object, in metres and in the twin's frame, give a better start, or \
         raise the limit",
        share = 100.0 * explained, least_share = 100.0 * least_explained
    )]
    #[problem(FailedPrecondition, "OBSERVATION_NOT_EXPLAINED")]
    NotExplained {
        /// Median distance that is left [mm].
        median_mm: f64,
        /// Largest median that is accepted [mm].
        limit_mm: f64,
        /// Share of the points that is explained, 0..=1.
        explained: f64,
        /// Least share that is accepted, 0..=1.
        least_explained: f64,
        /// Misfit: up to 1 noise and the twin's resolution explain the distances
        /// ([`Tracking`](crate::Tracking)).
        misfit: f64,
    },
    /// The work was cancelled through its token.
    #[error("cancelled")]
    #[problem(Cancelled, "CANCELLED")]
    Cancelled,
    /// The simulation failed.
    #[error(transparent)]
    Backend(backend::Error),
}

impl From<backend::Error> for Error {
    fn from(error: backend::Error) -> Self {
        match error {
            backend::Error::Cancelled => Self::Cancelled,
            other => Self::Backend(other),
        }
    }
}
