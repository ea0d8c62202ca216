//! The part of a correction that lasts. A corrected state goes back to where the twin's errors take
//! it, unless the rest shape takes part in the correction.

use bendtwin_core::{
    Graph, Params, Point,
    geometry::{point_distance, vector3},
};
use bendtwin_engine::{Model, model::State};

/// Rest lengths change at most by this factor.
const MOST: f64 = 2.0;
/// Lengths below this have no ratio [m].
const LEAST_M: f64 = 1e-4;

/// Parameters whose rest shape takes a share, 0..=1, of the deformation from one state to another
/// with the same control points: springs lengthen and triplets turn by that share of what they did,
/// so that at a share of 1 the second state is as far from balance as the first was.
pub fn carried(model: &Model, from: &State, to: &State, controls: &[Point], share: f64) -> Params {
    let graph: &Graph = &model.graph;
    let mut params = model.params.clone();
    let at = |state: &State, e: u32| -> Option<Point> {
        let e = e as usize;
        state.positions.get(e).or_else(|| controls.get(e.checked_sub(graph.node_count())?)).copied()
    };
    let length =
        |state: &State, [a, b]: [u32; 2]| Some(point_distance(at(state, a)?, at(state, b)?));
    for (rest, spring) in params.rest_lengths_m.iter_mut().zip(&graph.springs) {
        let (Some(before), Some(after)) = (length(from, *spring), length(to, *spring)) else {
            continue;
        };
        if before > LEAST_M && after > LEAST_M {
            let factor = 1.0 + share * ((after / before).clamp(1.0 / MOST, MOST) - 1.0);
            *rest = (f64::from(*rest) * factor) as f32;
        }
    }
    let angle = |state: &State, [i, j, k]: [u32; 3]| {
        let (center, a, b) =
            (vector3(at(state, j)?), vector3(at(state, i)?), vector3(at(state, k)?));
        Some((a - center).angle(&(b - center)))
    };
    for (rest, triplet) in params.rest_angles_rad.iter_mut().zip(&graph.triplets) {
        if let (Some(before), Some(after)) = (angle(from, *triplet), angle(to, *triplet)) {
            let turned = f64::from(*rest) + share * (after - before);
            *rest = turned.clamp(0.0, std::f64::consts::PI) as f32;
        }
    }
    params
}

#[cfg(test)]
mod tests;
