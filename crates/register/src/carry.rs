//! The part of a correction that lasts. A corrected state goes back to where the twin's errors take
//! it, unless the rest shape takes part in the correction. Corrections that are repeated and carried
//! are the integral part of an observer: the rest shape moves until they have nothing left to do.

use bendtwin_core::{
    Graph, Params, Point,
    geometry::{point_distance, vector3},
};
use bendtwin_engine::{Model, model::State};

use crate::Corrected;

/// Greatest factor by which rest lengths grow beyond the twin's own.
const LONGEST: f64 = 2.0;
/// Least factor: a spring's stiffness grows in inverse proportion to its length, and substeps have
/// a margin of 1.3 in frequency, 1.69 in stiffness.
const SHORTEST: f64 = 1.0 / 1.5;
/// Largest turn of a rest angle away from the twin's own [rad].
const FARTHEST_TURN: f64 = 1.0;
/// Lengths below this have no ratio [m].
const LEAST_M: f64 = 1e-4;

impl Corrected {
    /// Share of the squared distances before the correction that noise of the points does not
    /// explain, 0..=1: r² / (r² + noise²), Wiener's gain, with the median distance r. A
    /// distance within the noise is no error of the twin that could last.
    pub fn beyond_noise(&self, noise_m: f64) -> f64 {
        let median_m = 1e-3 * self.before.median_mm;
        let total = median_m.powi(2) + noise_m.powi(2);
        if total > 0.0 { median_m.powi(2) / total } else { 0.0 }
    }
}

/// Parameters of a model whose rest shape takes a share, 0..=1, of the deformation from one state to
/// another with the same control points: springs lengthen and triplets turn by that share of what
/// they did, so that at a share of 1 the second state is as far from balance as the first was.
///
/// Deformations of several corrections add up, but rest lengths stay between 2/3 and twice those of
/// `own`, the twin's own parameters, and rest angles within 1 rad of them.
pub fn carried(
    model: &Model,
    own: &Params,
    from: &State,
    to: &State,
    controls: &[Point],
    share: f64,
) -> Params {
    let graph: &Graph = &model.graph;
    let mut params = model.params.clone();
    let at = |state: &State, e: u32| -> Option<Point> {
        let e = e as usize;
        state.positions.get(e).or_else(|| controls.get(e.checked_sub(graph.node_count())?)).copied()
    };
    let length =
        |state: &State, [a, b]: [u32; 2]| Some(point_distance(at(state, a)?, at(state, b)?));
    let rests = params.rest_lengths_m.iter_mut().zip(&own.rest_lengths_m);
    for ((rest, own), spring) in rests.zip(&graph.springs) {
        let (Some(before), Some(after)) = (length(from, *spring), length(to, *spring)) else {
            continue;
        };
        if before > LEAST_M && after > LEAST_M {
            let length = f64::from(*rest) * (1.0 + share * (after / before - 1.0));
            let own = f64::from(*own);
            *rest = length.clamp(SHORTEST * own, LONGEST * own) as f32;
        }
    }
    let angle = |state: &State, [i, j, k]: [u32; 3]| {
        let (center, a, b) =
            (vector3(at(state, j)?), vector3(at(state, i)?), vector3(at(state, k)?));
        Some((a - center).angle(&(b - center)))
    };
    let rests = params.rest_angles_rad.iter_mut().zip(&own.rest_angles_rad);
    for ((rest, own), triplet) in rests.zip(&graph.triplets) {
        if let (Some(before), Some(after)) = (angle(from, *triplet), angle(to, *triplet)) {
            let turned = f64::from(*rest) + share * (after - before);
            let own = f64::from(*own);
            let turned = turned.clamp(own - FARTHEST_TURN, own + FARTHEST_TURN);
            *rest = turned.clamp(0.0, std::f64::consts::PI) as f32;
        }
    }
    params
}

#[cfg(test)]
mod tests;
