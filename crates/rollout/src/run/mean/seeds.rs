//! Gradients by positions as objectives: the adjoint of a backend begins at the terms of an objective,
//! and terms on the distance to targets begin with any gradient, if the targets are put where they pull
//! as hard.

use std::sync::Arc;

use bendtwin_core::Point;
use bendtwin_engine::{Objective, PointLoss, PointSet, Term, objective::WeightedTerm};

/// Distance of a target from its node along the largest component of a frame [m]. The farther it is, the
/// less a path matters that a device does not repeat to the last bit; the precision of a difference of
/// positions is that of single numbers at any distance.
const REACH_M: f32 = 64.0;

/// The objective whose gradient along a path, of positions [m], is `weight` times `seeds`, shape
/// [F + 1, nodes, 3] both.
pub(super) fn seeded(path: &[Point], seeds: &[Point], nodes: usize, weight: f64) -> Objective {
    let rows = path.chunks_exact(nodes.max(1)).zip(seeds.chunks_exact(nodes.max(1)));
    let terms = rows.enumerate().filter_map(|(frame, (path, seeds))| {
        let largest = seeds.as_flattened().iter().fold(0.0_f32, |most, x| most.max(x.abs()));
        // d / dx of weight / nodes |x - target|² is 2 weight / nodes (x - target).
        let pull = weight * f64::from(largest) * nodes as f64 / (2.0 * f64::from(REACH_M));
        let at = |(x, seed): (&Point, &Point)| -> Point {
            std::array::from_fn(|axis| x[axis] - REACH_M * (seed[axis] / largest))
        };
        let term = || Term::Track {
            of: PointSet::Nodes,
            points: (0..nodes as u32).collect(),
            targets: path.iter().zip(seeds).map(at).collect(),
            loss: PointLoss::SquaredDistance,
        };
        let weight = (pull as f32).min(f32::MAX);
        (largest > 0.0).then(|| WeightedTerm { frame, weight, group: 0, term: term() })
    });
    Objective { groups: vec!["seeds".to_owned()], terms: Arc::new(terms.collect()) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn targets_pull_as_hard_as_the_seeds() {
        let path = [[0.3, -0.2, 1.0], [0.0, 0.1, 0.9], [0.4, -0.2, 1.1], [0.1, 0.1, 0.8]];
        let seeds = [[0.0; 3], [0.0; 3], [1e-7, -3e-9, 0.0], [2e-8, 0.0, -5e-8]];
        let objective = seeded(&path, &seeds, 2, 0.25);
        assert_eq!(objective.terms.len(), 1, "nothing pulls in frame 0");
        let WeightedTerm { frame: 1, weight, term: Term::Track { points, targets, .. }, .. } =
            &objective.terms[0]
        else {
            panic!("{:?}", objective.terms);
        };
        assert_eq!(points, &[0, 1]);
        for (i, target) in targets.iter().enumerate() {
            for axis in 0..3 {
                let pull = 2.0 * weight / 2.0 * (path[2 + i][axis] - target[axis]);
                let seed = 0.25 * seeds[2 + i][axis];
                assert!((pull - seed).abs() < 1e-6 * 2.5e-8, "{pull} is not {seed}");
            }
        }
    }
}
