//! Points of the scenes' bodies: a grid with jitter, split into surface and inside.

use std::collections::HashSet;

use bendtwin_core::Point;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Distance of grid points [m].
const SPACING_M: f32 = 0.005;
/// A point is off its grid point by up to this share of the spacing in each direction.
const JITTER: f32 = 0.15;
/// Half axes of the ellipsoid, relative to each other.
const AXES: [f32; 3] = [1.5, 1.0, 0.8];
/// Nodes of the rope along each axis.
const ROPE: [i32; 3] = [48, 3, 3];
/// Control points of the rope at each end.
const ROPE_CONTROLS: usize = 4;
/// From the lowest point to the ground [m].
const CLEARANCE_M: f32 = 0.001;
/// From a control point to the node that it is beside [m].
const CONTROL_OFFSET_M: f32 = 0.004;

/// Points of a body at rest [m].
pub(super) struct Body {
    /// Points on the surface, shape [S, 3].
    pub(super) surface: Vec<Point>,
    /// Points inside, shape [I, 3].
    pub(super) interior: Vec<Point>,
    /// Control points, shape [C, 3].
    pub(super) controls: Vec<Point>,
}

type Cell = [i32; 3];

/// The grid's `nodes` innermost points by the ellipsoid's norm, held at the end towards +x.
pub(super) fn ellipsoid(nodes: usize, controls: usize, seed: u64) -> Body {
    // The volume gives the radius; the grid reaches a little farther.
    let radius = (nodes as f32 / (4.19 * AXES[0] * AXES[1] * AXES[2])).cbrt();
    let reach = AXES.map(|a| (1.2 * a * radius) as i32 + 2);
    let norm = |c: &Cell| (0..3).map(|a| (c[a] as f32 / AXES[a]).powi(2)).sum::<f32>();
    let mut cells = grid(reach.map(|r| -r), reach);
    // A stable sort: points equally far out keep the grid's order.
    cells.sort_by(|a, b| norm(a).total_cmp(&norm(b)));
    cells.truncate(nodes);
    Body::new(&cells, &[(1.0, controls)], seed)
}

/// A straight rope along x, held at both ends.
pub(super) fn rope(seed: u64) -> Body {
    let cells = grid([0; 3], ROPE.map(|n| n - 1));
    Body::new(&cells, &[(1.0, ROPE_CONTROLS), (-1.0, ROPE_CONTROLS)], seed)
}

/// All cells between two corners, both included.
fn grid(low: Cell, high: Cell) -> Vec<Cell> {
    let range = |axis: usize| low[axis]..=high[axis];
    range(0)
        .flat_map(|x| range(1).map(move |y| [x, y]))
        .flat_map(|[x, y]| range(2).map(move |z| [x, y, z]))
        .collect()
}

impl Body {
    /// Jitters the cells and stands them on the ground; each end (direction along x, number) gets
    /// control points beside the nodes that are farthest out there.
    fn new(cells: &[Cell], ends: &[(f32, usize)], seed: u64) -> Self {
        let filled: HashSet<Cell> = cells.iter().copied().collect();
        let is_inside = |&[x, y, z]: &Cell| {
            let sides = [
                [x + 1, y, z],
                [x - 1, y, z],
                [x, y + 1, z],
                [x, y - 1, z],
                [x, y, z + 1],
                [x, y, z - 1],
            ];
            sides.iter().all(|side| filled.contains(side))
        };
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut offset = || JITTER * (2.0 * rng.random::<f32>() - 1.0);
        let mut points: Vec<Point> =
            cells.iter().map(|c| c.map(|x| (x as f32 + offset()) * SPACING_M)).collect();
        let lowest = points.iter().map(|p| p[2]).fold(f32::INFINITY, f32::min);
        points.iter_mut().for_each(|p| p[2] += CLEARANCE_M - lowest);
        let mut controls = Vec::new();
        for &(side, count) in ends {
            let mut outermost = points.clone();
            outermost.sort_by(|a, b| (side * b[0]).total_cmp(&(side * a[0])));
            let beside = |p: &Point| [p[0] + side * CONTROL_OFFSET_M, p[1], p[2]];
            controls.extend(outermost.iter().take(count).map(beside));
        }
        let (mut surface, mut interior) = (Vec::new(), Vec::new());
        for (cell, point) in cells.iter().zip(points) {
            if is_inside(cell) { interior.push(point) } else { surface.push(point) }
        }
        Self { surface, interior, controls }
    }
}
