//! Points spread evenly over a mesh's surface.

use std::collections::HashMap;

use bendtwin_core::Point;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::{Error, Mesh, Vec3, point};

/// Random points tried for each disc that the area could hold: more fill the last gaps, at a price.
const TRIES_PER_DISC: f64 = 12.0;
/// Most samples that a spacing may ask for.
const MAX_SAMPLES: f64 = 2_000_000.0;

impl Mesh {
    /// Points on the surface, none nearer to another than `spacing_m` and hardly a gap that one
    /// more would fit into (random by area, then thinned: a Poisson disc pattern). The same seed
    /// gives the same points.
    ///
    /// # Errors
    /// If the spacing is no length, or so fine that memory would not hold the points.
    pub fn sample_surface(&self, spacing_m: f32, seed: u64) -> Result<Vec<Point>, Error> {
        let triangles: Vec<[Vec3; 3]> = self.corners().collect();
        let mut area = 0.0;
        let until: Vec<f64> = triangles
            .iter()
            .map(|[a, b, c]| {
                area += (b - a).cross(&(c - a)).norm() / 2.0;
                area
            })
            .collect();
        let spacing = f64::from(spacing_m);
        let discs = area / (spacing * spacing);
        // NaN is no length either.
        if !(spacing > 0.0 && discs <= MAX_SAMPLES) {
            let samples = discs.max(0.0) as u64;
            return Err(Error::Spacing { spacing_m, samples, limit: MAX_SAMPLES as u64 });
        }
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut thinning = Thinning::new(spacing);
        for _ in 0..(discs * TRIES_PER_DISC).ceil() as usize {
            let [along, across, place]: [f64; 3] = std::array::from_fn(|_| rng.random::<f64>());
            let chosen = until.partition_point(|u| *u <= place * area);
            let Some([a, b, c]) = triangles.get(chosen) else { continue };
            // Uniform over the triangle.
            let root = along.sqrt();
            thinning.offer(a * (1.0 - root) + b * (root * (1.0 - across)) + c * (root * across));
        }
        Ok(thinning.kept.into_iter().map(point).collect())
    }
}

/// Keeps points that are not near one that was kept before.
pub(crate) struct Thinning {
    spacing: f64,
    cells: HashMap<[i64; 3], Vec<usize>>,
    pub(crate) kept: Vec<Vec3>,
}

impl Thinning {
    pub(crate) fn new(spacing: f64) -> Self {
        Self { spacing, cells: HashMap::new(), kept: Vec::new() }
    }

    /// Keeps a point if it is not near a kept one.
    pub(crate) fn offer(&mut self, p: Vec3) {
        let cell = [p.x, p.y, p.z].map(|x| (x / self.spacing).floor() as i64);
        let square = self.spacing * self.spacing;
        let is_near = |i: &usize| (self.kept[*i] - p).norm_squared() < square;
        let around = (0..27).map(|k| [k / 9 - 1, k / 3 % 3 - 1, k % 3 - 1]);
        for step in around {
            let beside = std::array::from_fn(|a| cell[a].saturating_add(step[a]));
            if self.cells.get(&beside).is_some_and(|there| there.iter().any(is_near)) {
                return;
            }
        }
        self.cells.entry(cell).or_default().push(self.kept.len());
        self.kept.push(p);
    }
}

#[cfg(test)]
mod tests;
