//! Terms of tasks for random models: order, winding and coverage.

use std::sync::Arc;

use bendtwin_core::Point;
use bendtwin_engine::{Model, PointSet, Term};

use super::SPACING_M;

/// Distance of targets from their points along each axis [m].
const ASIDE_M: f32 = 0.002;

/// An order, a winding and a coverage of some of a model's points, in this order. The line passes by the
/// model, so that no chain jumps over it; target points are so near the listed ones that the nearest of each is hardly
/// ever another at the next rounding.
pub fn task_terms(model: &Model, of: PointSet, points: &[u32]) -> [Term; 3] {
    let rest = &model.graph.rest_positions;
    let all = match of {
        PointSet::Nodes => rest.clone(),
        PointSet::Skin => model.skin.positions(rest),
    };
    let least = rest.iter().fold([f32::MAX; 3], |a, b| std::array::from_fn(|k| a[k].min(b[k])));
    let origin = if rest.is_empty() { [0.0; 3] } else { least.map(|x| x - SPACING_M) };
    let targets: Vec<Point> =
        points.iter().map(|&i| all[i as usize].map(|x| x + ASIDE_M)).collect();
    let points = Arc::new(points.to_vec());
    [
        Term::Order {
            of,
            points: Arc::clone(&points),
            direction: [0.6, 0.0, 0.8],
            gap_m: 0.5 * SPACING_M,
        },
        Term::Winding { of, points, origin, direction: [0.48, 0.6, -0.64], turns: 0.4 },
        Term::Coverage { of, targets: Arc::new(targets), reach_m: 0.7 * SPACING_M },
    ]
}
