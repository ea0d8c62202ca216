//! A body's surface as triangles that move with its lattice. The lattice is blocky; the surface
//! lies where the body's distance field says, and each of its vertices follows the nodes around it
//! as they deform (moving least squares).

use std::collections::HashMap;

use bendtwin_core::Point;

use super::{
    body::Body,
    pose::{add, dot, scale, sub},
};

/// Nodes that carry a vertex.
const CARRIERS: usize = 12;

/// Triangles, and how each vertex follows from node positions.
#[derive(Clone, Debug, Default)]
pub(super) struct Skin {
    /// Vertices at rest [m], shape [V, 3].
    pub(super) rest: Vec<Point>,
    /// Counter-clockwise from outside, shape [F, 3].
    pub(super) triangles: Vec<[u32; 3]>,
    carriers: Vec<[(u32, f32); CARRIERS]>,
}

impl Skin {
    /// The skin of a body where `distance` is zero.
    pub(super) fn of(body: &Body, distance: impl Fn(Point) -> f32) -> Self {
        let mut skin = Self::default();
        let Some(&origin) = body.positions.first() else { return skin };
        let cell_of =
            |p: Point| -> [i32; 3] { sub(p, origin).map(|d| (d / body.spacing_m).round() as i32) };
        let cells: HashMap<[i32; 3], ()> =
            body.positions.iter().map(|p| (cell_of(*p), ())).collect();
        let mut corners: HashMap<[i32; 3], u32> = HashMap::new();
        for p in &body.positions {
            let cell = cell_of(*p);
            for (axis, side) in (0..3).flat_map(|a| [(a, -1), (a, 1)]) {
                let mut beside = cell;
                beside[axis] += side;
                if cells.contains_key(&beside) {
                    continue;
                }
                let quad = face(cell, axis, side).map(|corner| {
                    *corners.entry(corner).or_insert_with(|| {
                        let at = corner.map(|c| (c as f32 - 0.5) * body.spacing_m);
                        skin.rest.push(add(origin, at));
                        skin.rest.len() as u32 - 1
                    })
                });
                skin.triangles.extend([[quad[0], quad[1], quad[2]], [quad[0], quad[2], quad[3]]]);
            }
        }
        for v in &mut skin.rest {
            *v = settled(*v, &distance, body.spacing_m);
        }
        skin.carriers = skin.rest.iter().map(|v| carriers(*v, &body.positions)).collect();
        skin
    }

    /// Vertices when the lattice's nodes are at `nodes`.
    pub(super) fn posed(&self, nodes: &[Point]) -> Vec<Point> {
        self.carriers
            .iter()
            .map(|carriers| {
                carriers.iter().fold([0.0; 3], |sum, (node, weight)| {
                    let at = nodes.get(*node as usize).copied().unwrap_or_default();
                    add(sum, scale(at, *weight))
                })
            })
            .collect()
    }
}

/// The corners of a cell's face, counter-clockwise from outside; corner (0, 0, 0) is the cell's
/// lowest.
fn face(cell: [i32; 3], axis: usize, side: i32) -> [[i32; 3]; 4] {
    let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
    let mut around = [[0, 0], [1, 0], [1, 1], [0, 1]];
    if side < 0 {
        around.reverse();
    }
    around.map(|[a, b]| {
        let mut corner = cell;
        corner[axis] += i32::from(side > 0);
        corner[u] += a;
        corner[v] += b;
        corner
    })
}

/// The vertex moved along the gradient to where the distance is zero, at most a spacing away.
fn settled(v: Point, distance: impl Fn(Point) -> f32, spacing_m: f32) -> Point {
    let step = 0.1 * spacing_m;
    let mut at = v;
    for _ in 0..4 {
        let here = distance(at);
        let gradient: Point = std::array::from_fn(|axis| {
            let mut beside = at;
            beside[axis] += step;
            (distance(beside) - here) / step
        });
        let square = dot(gradient, gradient);
        if square < 1e-6 {
            break;
        }
        at = sub(at, scale(gradient, here / square));
    }
    let moved = sub(at, v);
    let length = dot(moved, moved).sqrt();
    if length > spacing_m { add(v, scale(moved, spacing_m / length)) } else { at }
}

/// Weights of the nearest nodes, so that a vertex goes where the affine motion that fits these
/// nodes best takes it.
fn carriers(v: Point, nodes: &[Point]) -> [(u32, f32); CARRIERS] {
    let square = |i: &u32| {
        let d = sub(nodes[*i as usize], v);
        dot(d, d)
    };
    let mut near: Vec<u32> = (0..nodes.len() as u32).collect();
    let count = CARRIERS.min(near.len());
    if near.len() > count {
        near.select_nth_unstable_by(count, |a, b| square(a).total_cmp(&square(b)));
    }
    near.truncate(count);
    let reach = near.iter().map(square).fold(0.0, f32::max) * 1.2 + f32::MIN_POSITIVE;
    let mut weights: Vec<f64> =
        near.iter().map(|i| f64::from(1.0 - square(i) / reach).powi(2)).collect();
    let total: f64 = weights.iter().sum();
    weights.iter_mut().for_each(|w| *w /= total);
    let mean: [f64; 3] = std::array::from_fn(|a| {
        let weighted = near.iter().zip(&weights);
        weighted.map(|(i, w)| w * f64::from(nodes[*i as usize][a])).sum()
    });
    let offset = |p: Point| -> [f64; 3] { std::array::from_fn(|a| f64::from(p[a]) - mean[a]) };
    let mut spread = [[0.0; 3]; 3];
    for (i, w) in near.iter().zip(&weights) {
        let d = offset(nodes[*i as usize]);
        for (row, x) in spread.iter_mut().zip(d) {
            for (cell, y) in row.iter_mut().zip(d) {
                *cell += w * x * y;
            }
        }
    }
    // Where nodes lie in a plane, motion out of it is taken for none.
    let trace: f64 = (0..3).map(|a| spread[a][a]).sum();
    (0..3).for_each(|a| spread[a][a] += 1e-3 * trace + f64::MIN_POSITIVE);
    let pull = solved(spread, offset(v));
    let mut out = [(0, 0.0); CARRIERS];
    for ((slot, i), w) in out.iter_mut().zip(&near).zip(&weights) {
        let d = offset(nodes[*i as usize]);
        *slot = (*i, (w * (1.0 + (0..3).map(|a| pull[a] * d[a]).sum::<f64>())) as f32);
    }
    out
}

/// Solves a symmetric positive system of three unknowns by Cramer's rule.
fn solved(m: [[f64; 3]; 3], b: [f64; 3]) -> [f64; 3] {
    let determinant = |m: [[f64; 3]; 3]| {
        m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1])
            - m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0])
            + m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0])
    };
    let whole = determinant(m);
    std::array::from_fn(|column| {
        let mut replaced = m;
        (0..3).for_each(|row| replaced[row][column] = b[row]);
        determinant(replaced) / whole
    })
}
