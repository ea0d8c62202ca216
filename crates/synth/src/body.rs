//! A body as a cubic lattice of nodes inside a signed distance field, joined
//! along axes and face diagonals. A twin's graph, found by radius over scattered
//! surface points, shares neither nodes nor topology with it.

use std::collections::HashMap;

use bendtwin_core::Point;

/// Lattice nodes and springs.
#[derive(Clone, Debug, Default)]
pub(super) struct Body {
    /// Positions [m], shape [N, 3].
    pub(super) positions: Vec<Point>,
    /// `true` where a node lacks a neighbour along an axis, shape [N].
    pub(super) is_surface: Vec<bool>,
    /// Node pairs, shape [E, 2].
    pub(super) springs: Vec<[u32; 2]>,
    /// Distance of neighbours along an axis [m].
    pub(super) spacing_m: f32,
}

/// Directions, one of each opposite pair: three axes, six face diagonals.
const DIRECTIONS: [[i32; 3]; 9] = [
    [1, 0, 0],
    [0, 1, 0],
    [0, 0, 1],
    [1, 1, 0],
    [1, -1, 0],
    [1, 0, 1],
    [1, 0, -1],
    [0, 1, 1],
    [0, 1, -1],
];

impl Body {
    /// Fills the part of a box where `distance` is not positive.
    pub(super) fn fill(
        low: Point,
        high: Point,
        spacing_m: f32,
        distance: impl Fn(Point) -> f32,
    ) -> Self {
        let mut body = Self { spacing_m, ..Self::default() };
        let cells: [i32; 3] =
            std::array::from_fn(|a| ((high[a] - low[a]) / spacing_m).ceil().max(1.0) as i32);
        let mut at = HashMap::new();
        for x in 0..cells[0] {
            for y in 0..cells[1] {
                for z in 0..cells[2] {
                    let cell = [x, y, z];
                    let p = std::array::from_fn(|a| low[a] + (cell[a] as f32 + 0.5) * spacing_m);
                    if distance(p) <= 0.0 {
                        at.insert(cell, body.positions.len() as u32);
                        body.positions.push(p);
                        body.is_surface.push(false);
                    }
                }
            }
        }
        let shifted = |cell: &[i32; 3], by: &[i32; 3], sign: i32| -> [i32; 3] {
            std::array::from_fn(|a| cell[a] + sign * by[a])
        };
        let mut cells: Vec<_> = at.iter().collect();
        // A hash map's order differs from run to run.
        cells.sort_by_key(|(_, node)| **node);
        for (cell, &node) in cells {
            body.is_surface[node as usize] = DIRECTIONS[..3].iter().any(|axis| {
                [1, -1].iter().any(|sign| !at.contains_key(&shifted(cell, axis, *sign)))
            });
            let joined = DIRECTIONS.iter().filter_map(|d| at.get(&shifted(cell, d, 1)));
            body.springs.extend(joined.map(|other| [node, *other]));
        }
        body
    }

    pub(super) fn node_count(&self) -> usize {
        self.positions.len()
    }

    /// Surface nodes.
    pub(super) fn surface(&self) -> Vec<u32> {
        let nodes = 0..self.node_count() as u32;
        nodes.filter(|n| self.is_surface[*n as usize]).collect()
    }

    /// Nodes that a hand holds.
    pub(super) fn within(&self, inside: impl Fn(Point) -> bool) -> Vec<u32> {
        let nodes = 0..self.node_count() as u32;
        nodes.filter(|n| inside(self.positions[*n as usize])).collect()
    }

    /// Outward normals of a deformed state, shape [N, 3]: away from the mean of a
    /// node's neighbours, which at the surface all lie on the inner side.
    pub(super) fn normals(&self, positions: &[Point]) -> Vec<Point> {
        let mut inward = vec![[0.0_f32; 3]; positions.len()];
        for &[a, b] in &self.springs {
            let d = super::pose::sub(positions[b as usize], positions[a as usize]);
            let (a, b) = (a as usize, b as usize);
            inward[a] = super::pose::add(inward[a], d);
            inward[b] = super::pose::sub(inward[b], d);
        }
        inward.into_iter().map(|v| super::pose::unit(super::pose::scale(v, -1.0))).collect()
    }
}
