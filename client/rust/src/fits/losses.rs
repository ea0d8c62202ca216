//! Losses of a fit.

use bendtwin_proto::v1;
use serde::Serialize;

use crate::Error;

/// Losses of one model over the iterations of a stage. Of a long stage every second iteration is
/// kept, every fourth and so on, and the last.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LossCurve {
    /// `search` or `refine`.
    pub stage: String,
    /// `bending` or `axial`, of several starts followed by which: `bending 2/3`.
    pub variant: String,
    /// Iterations, ascending from 1.
    pub iterations: Vec<u32>,
    /// Loss of each iteration; none where it was not finite.
    pub losses: Vec<Option<f64>>,
    /// Lowest loss up to each iteration.
    pub best_losses: Vec<Option<f64>>,
    /// Error over the training frames with the best parameters up to each iteration [m]; none where it
    /// was not measured.
    pub errors_m: Vec<Option<f64>>,
}

impl TryFrom<v1::fit_losses::LossCurve> for LossCurve {
    type Error = Error;
    fn try_from(wire: v1::fit_losses::LossCurve) -> Result<Self, Error> {
        let count = wire.iterations.len();
        let mut errors_m = wire.errors_m;
        if errors_m.is_empty() {
            // A server of an earlier version.
            errors_m.resize(count, f64::NAN);
        }
        if [&wire.losses, &wire.best_losses, &errors_m].iter().any(|list| list.len() != count) {
            return Err(Error::malformed("a curve of losses has lists of different lengths"));
        }
        let finite =
            |losses: Vec<f64>| losses.into_iter().map(|l| l.is_finite().then_some(l)).collect();
        Ok(Self {
            stage: wire.stage,
            variant: wire.variant,
            iterations: wire.iterations,
            losses: finite(wire.losses),
            best_losses: finite(wire.best_losses),
            errors_m: finite(errors_m),
        })
    }
}
