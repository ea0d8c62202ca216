//! Motion of a neighbourhood: the rigid motion that takes it from one set of places to another,
//! robustly.

pub(crate) use bendtwin_core::geometry::{
    Alignment as Motion, Pair, point_distance as distance, vector3 as vector,
};
use bendtwin_core::geometry::{Kabsch, Prior, RobustRule};
use nalgebra::Matrix3;

/// Rounds of reweighting.
const ROUNDS: usize = 6;
/// Distances below this are noise of depth, and not worth distinguishing [m].
const NOISE_M: f64 = 0.002;

/// The motion on which most of the weight agrees (iteratively reweighted Kabsch with Tukey's
/// biweight); `None` if fewer than four of four or more do.
///
/// `likely` is a rotation to stay near in directions of which the neighbours say nothing: about
/// their line, if they lie on one, or all if they are too few.
pub(crate) fn rigid(pairs: &[Pair], likely: &Matrix3<f64>) -> Option<Motion> {
    let least = pairs.len().min(4);
    if least == 0 {
        return None;
    }
    let rule = RobustRule {
        rounds: ROUNDS,
        least_width_m: NOISE_M,
        // Wide at first, so that a start that outliers have pulled away can recover.
        first_width: 2.0,
        least_agreeing: least,
        fits_last: false,
        about_origin: false,
        kabsch: Kabsch {
            least_weight: 0.0,
            prior: Some(Prior { rotation: *likely, deviation_m: NOISE_M }),
            epsilon: 1e-15,
            iterations: 200,
        },
    };
    Some(rule.fit(pairs, rule.start(pairs)?)?.motion)
}
