//! The springs that PhysTwin makes of points, in its order, which that of its stiffnesses is.

use std::{collections::HashSet, num::NonZero};

use bendtwin_capture::phystwin::results::SearchResult;
use bendtwin_core::{
    Point,
    geometry::{length, sub, wide},
};
use kiddo::{ImmutableKdTree, SquaredEuclidean};

/// Shorter springs between object points are left out [m].
const LEAST_M: f64 = 1e-4;

/// Springs between object points, then those of control points.
pub(super) struct Springs {
    /// Endpoints, a node first, shape [E].
    pub(super) ends: Vec<[u32; 2]>,
    /// Rest lengths [m], shape [E].
    pub(super) lengths: Vec<f32>,
    /// Number of springs between object points.
    pub(super) object_count: usize,
}

impl Springs {
    /// For each object point in turn its neighbours nearer than the radius, the nearest first and as
    /// many as allowed, itself counted; each pair once, where it first comes. Then for each control
    /// point in turn its object points in the same way. Positions must be finite.
    pub(super) fn of(objects: &[Point], controls: &[Point], search: &SearchResult) -> Self {
        let points: Vec<[f64; 3]> = objects.iter().map(|p| wide(*p)).collect();
        let mut this = Self { ends: Vec::new(), lengths: Vec::new(), object_count: 0 };
        // It fails beyond 2^32 points alone, which no capture has.
        let Ok(tree) = ImmutableKdTree::new_from_slice(&points) else { return this };
        let near =
            |at: [f64; 3], radius: f64, most: usize| neighbours(&tree, &points, at, radius, most);
        let mut joined = HashSet::new();
        for (i, &at) in points.iter().enumerate() {
            // The first is the point itself.
            let found = near(at, search.object_radius_m, search.object_max_neighbours);
            for j in found.into_iter().skip(1) {
                let rest = length(sub(at, points[j as usize]));
                let i = i as u32;
                if rest > LEAST_M && joined.insert([i.min(j), i.max(j)]) {
                    this.push([i, j], rest);
                }
            }
        }
        this.object_count = this.ends.len();
        for (c, control) in controls.iter().enumerate() {
            let at = wide(*control);
            for j in near(at, search.control_radius_m, search.control_max_neighbours) {
                let end = (points.len() + c) as u32;
                this.push([j, end], length(sub(at, points[j as usize])));
            }
        }
        this
    }

    fn push(&mut self, ends: [u32; 2], rest_m: f64) {
        self.ends.push(ends);
        self.lengths.push(rest_m as f32);
    }
}

/// The nearest points within a radius, the nearest first, equally near ones by index.
fn neighbours(
    tree: &ImmutableKdTree<f64, 3>,
    points: &[[f64; 3]],
    at: [f64; 3],
    radius_m: f64,
    most: usize,
) -> Vec<u32> {
    let Some(most) = NonZero::new(most.min(points.len())) else { return Vec::new() };
    let found = tree.query(&at).nearest_n::<SquaredEuclidean<f64>>(most).execute();
    let mut near: Vec<(f64, u32)> = found
        .iter()
        .map(|n| (n.distance, n.item))
        .filter(|(square, _)| *square < radius_m * radius_m)
        .collect();
    near.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    near.into_iter().map(|(_, item)| item).collect()
}
