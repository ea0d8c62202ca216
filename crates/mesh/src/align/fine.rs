//! The fine stage of alignment: distances along the surface's normal, on all points, robustly
//! weighted. It converges quickly once the start is near.

use nalgebra::{Rotation3, SMatrix, SVector};

use super::coarse::{evenly_taken, mean_square, nearest_share, observed_half};
use crate::{Bvh, Similarity, Vec3, cloud::Cloud};

/// Most Gauss-Newton steps.
const MAX_STEPS: usize = 30;
/// Samples of the mesh; the nearest half is taken to have been observed.
const MAX_SAMPLES: usize = 300;
/// Weight of these samples beside the observed points.
const SAMPLE_WEIGHT: f64 = 0.1;
/// Share of the observed points, the nearest to the mesh, that the score is made of.
const INLIER_SHARE: f64 = 0.85;
/// Damping of steps, as a share of the mean curvature.
const DAMPING: f64 = 1e-3;

/// A similarity after the fine stage.
pub(super) struct Refined {
    pub(super) similarity: Similarity,
    /// Mean squared distances [m²]; smaller is better.
    pub(super) score: f64,
}

type Square = SMatrix<f64, 7, 7>;
type Column = SVector<f64, 7>;

/// Gauss-Newton over rotation, translation and the logarithm of scale, about the observed middle.
pub(super) fn refine(
    start: Similarity,
    bvh: &Bvh,
    surface: &Cloud,
    cloud: &Cloud,
    within_m: f64,
) -> Refined {
    let samples = evenly_taken(&surface.points, MAX_SAMPLES);
    let middle = cloud.points.iter().sum::<Vec3>() / cloud.points.len().max(1) as f64;
    let mut at = start;
    for step in 0..MAX_STEPS {
        // Outliers lose their weight slowly: at first nothing lies on the surface yet.
        let reach = within_m * (1.0 + 4.0 * (1.0 - step as f64 / (MAX_STEPS / 2) as f64).max(0.0));
        let mut system = System::new(middle);
        for o in &cloud.points {
            let Some((on_mesh, _, triangle)) = bvh.nearest(at.apply_inverse(*o)) else { continue };
            let [a, b, c] = bvh.triangles[triangle];
            let Some(normal) = (b - a).cross(&(c - a)).try_normalize(0.0) else { continue };
            let there = at.map(on_mesh);
            let weight = tukey((o - there).norm() / reach);
            system.add(there, at.matrix() * normal, *o, weight / cloud.points.len() as f64);
        }
        let backward = observed_half(at, &samples, cloud);
        let weight = SAMPLE_WEIGHT / backward.len().max(1) as f64;
        for pair in &backward {
            let there = at.map(pair.mesh);
            for axis in [Vec3::x(), Vec3::y(), Vec3::z()] {
                system.add(there, axis, pair.observed, weight / 3.0);
            }
        }
        let Some((next, moved)) = system.solve(at) else { break };
        at = next;
        if step > MAX_STEPS / 2 && moved < 1e-6 {
            break;
        }
    }
    let forward = cloud.points.iter().filter_map(|o| {
        let (mesh, square, _) = bvh.nearest(at.apply_inverse(*o))?;
        Some(super::coarse::Pair { mesh, observed: *o, square: square * at.scale * at.scale })
    });
    let forward = nearest_share(forward.collect(), INLIER_SHARE);
    let score =
        mean_square(&forward) + SAMPLE_WEIGHT * mean_square(&observed_half(at, &samples, cloud));
    Refined { similarity: at, score: if score.is_finite() { score } else { f64::INFINITY } }
}

/// 1 at the surface, 0 from a distance of 1.
fn tukey(distance: f64) -> f64 {
    let x = 1.0 - distance * distance;
    if x > 0.0 { x * x } else { 0.0 }
}

/// Normal equations of one step.
struct System {
    middle: Vec3,
    curvature: Square,
    gradient: Column,
}

impl System {
    fn new(middle: Vec3) -> Self {
        Self { middle, curvature: Square::zeros(), gradient: Column::zeros() }
    }

    /// Adds the condition that the point `there` moves along `axis` until it is level with
    /// `observed`.
    fn add(&mut self, there: Vec3, axis: Vec3, observed: Vec3, weight: f64) {
        let arm = there - self.middle;
        let turn = arm.cross(&axis);
        let row = Column::from([turn.x, turn.y, turn.z, axis.x, axis.y, axis.z, axis.dot(&arm)]);
        self.curvature += row * row.transpose() * weight;
        self.gradient += row * (axis.dot(&(observed - there)) * weight);
    }

    /// The next similarity, and the length of the step (radians, shares of size and metres
    /// together).
    fn solve(mut self, at: Similarity) -> Option<(Similarity, f64)> {
        for i in 0..7 {
            self.curvature[(i, i)] *= 1.0 + DAMPING;
            self.curvature[(i, i)] += f64::EPSILON * self.curvature.trace();
        }
        let step = self.curvature.cholesky()?.solve(&self.gradient);
        if !step.iter().all(|x| x.is_finite()) {
            return None;
        }
        let turn = Rotation3::new(Vec3::new(step[0], step[1], step[2]));
        let growth = step[6].clamp(-0.2, 0.2).exp();
        let shift = Vec3::new(step[3], step[4], step[5]);
        let moved = Vec3::from(at.translation) - self.middle;
        Some((
            Similarity::new(
                turn.matrix() * at.matrix(),
                at.scale * growth,
                turn * moved * growth + self.middle + shift,
            ),
            turn.angle() + (growth - 1.0).abs() + shift.norm(),
        ))
    }
}
