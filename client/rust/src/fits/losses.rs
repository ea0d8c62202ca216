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
}

impl TryFrom<v1::fit_losses::LossCurve> for LossCurve {
    type Error = Error;
    fn try_from(wire: v1::fit_losses::LossCurve) -> Result<Self, Error> {
        let count = wire.iterations.len();
        if wire.losses.len() != count || wire.best_losses.len() != count {
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
        })
    }
}
