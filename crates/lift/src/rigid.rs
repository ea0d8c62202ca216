//! The rigid motion that best takes points to points, in spite of some that go astray.

pub(crate) use bendtwin_core::geometry::{
    RigidMotion as Rigid, point_distance as distance, vector3 as vector,
};
use bendtwin_core::{
    Point,
    geometry::{Alignment, Kabsch, Pair, RobustRule, median},
};
use nalgebra::{Matrix3, Vector3};

/// Rounds of reweighting.
const ROUNDS: usize = 4;

/// A fitted motion with the median distance that it leaves [m].
pub(crate) struct RigidFit {
    pub(crate) motion: Rigid,
    pub(crate) residual_m: f64,
}

/// Takes `from` to `to`; `None` with fewer than three pairs. Residuals below `least_m` count as
/// noise.
pub(crate) fn fit(pairs: &[(Point, Point)], least_m: f64) -> Option<RigidFit> {
    if pairs.len() < 3 {
        return None;
    }
    let weighted: Vec<Pair> =
        pairs.iter().map(|&(before, after)| Pair { before, after, weight: 1.0 }).collect();
    let rule = RobustRule {
        rounds: ROUNDS,
        least_width_m: 3.0 * least_m,
        first_width: 1.0,
        least_agreeing: 0,
        fits_last: true,
        about_origin: true,
        kabsch: Kabsch::default(),
    };
    let fit = rule.fit(&weighted, start(pairs))?;
    Some(RigidFit { motion: fit.motion.motion(), residual_m: fit.residual_m })
}

/// A first guess that outliers cannot pull far: the median translation.
fn start(pairs: &[(Point, Point)]) -> Alignment {
    let mut shift = [0.0; 3];
    let mut values = Vec::with_capacity(pairs.len());
    for (axis, shift) in shift.iter_mut().enumerate() {
        values.clear();
        values.extend(pairs.iter().map(|(a, b)| f64::from(b[axis]) - f64::from(a[axis])));
        *shift = median(&mut values).unwrap_or(0.0);
    }
    Alignment { rotation: Matrix3::identity(), from: Vector3::zeros(), to: Vector3::from(shift) }
}

#[cfg(test)]
mod tests;
