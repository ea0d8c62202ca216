//! The convex hull of a few points, from outside: the extents along fixed directions, after the
//! points were stretched to be equally wide along their principal axes. Needs no care with points
//! in one plane, and thin parts get thin hulls.

use nalgebra::Matrix3;

use crate::Vec3;

/// Half-spaces of a hull: it is then at most 2 % wider than the true one.
const DIRECTIONS: usize = 160;
/// Steps across a hull, along each axis, by which its volume is measured.
const VOLUME_STEPS: usize = 14;
/// Least points of a hull.
const MIN_POINTS: usize = 8;

/// The hull of a part.
pub(super) struct Hull {
    middle: Vec3,
    /// Principal axes, and extents along them, longest first [m].
    pub(super) axes: [Vec3; 3],
    pub(super) extents: [f64; 3],
    /// Farthest extent of the stretched points along each direction.
    support: Vec<f64>,
    /// In m³.
    pub(super) volume: f64,
}

impl Hull {
    /// `None` if the points lie in a plane or are too few.
    pub(super) fn of(points: &[Vec3], directions: &[Vec3]) -> Option<Self> {
        if points.len() < MIN_POINTS {
            return None;
        }
        let mean = points.iter().sum::<Vec3>() / points.len() as f64;
        let spread: Matrix3<f64> = points.iter().map(|p| (p - mean) * (p - mean).transpose()).sum();
        let eigen = spread.symmetric_eigen();
        let mut sides: Vec<(f64, f64, Vec3)> = eigen
            .eigenvectors
            .column_iter()
            .map(|axis| {
                let along = || points.iter().map(|p| axis.dot(p));
                let low = along().fold(f64::INFINITY, f64::min);
                let high = along().fold(f64::NEG_INFINITY, f64::max);
                (high - low, (high + low) / 2.0, axis.into_owned())
            })
            .collect();
        sides.sort_by(|a, b| b.0.total_cmp(&a.0));
        let extents: [f64; 3] = std::array::from_fn(|i| sides[i].0);
        if extents[2].is_nan() || extents[2] <= 1e-6 * extents[0] {
            return None;
        }
        let axes = std::array::from_fn(|i| sides[i].2);
        let middle = sides.iter().map(|(_, centre, axis)| axis * *centre).sum();
        let mut hull = Self { middle, axes, extents, support: Vec::new(), volume: 0.0 };
        let stretched: Vec<Vec3> = points.iter().map(|p| hull.stretch(*p)).collect();
        let farthest =
            |d: &Vec3| stretched.iter().map(|p| d.dot(p)).fold(f64::NEG_INFINITY, f64::max);
        hull.support = directions.iter().map(farthest).collect();

        let at = |i: usize| (2 * i + 1) as f64 / VOLUME_STEPS as f64 - 1.0;
        let cells = (0..VOLUME_STEPS.pow(3)).map(|i| {
            Vec3::new(
                at(i / VOLUME_STEPS / VOLUME_STEPS),
                at(i / VOLUME_STEPS % VOLUME_STEPS),
                at(i % VOLUME_STEPS),
            )
        });
        let full = cells.filter(|p| hull.contains_stretched(*p, directions)).count();
        let share = full as f64 / VOLUME_STEPS.pow(3) as f64;
        hull.volume = share * extents.iter().product::<f64>();
        Some(hull)
    }

    /// True if a point lies inside.
    pub(super) fn contains(&self, p: Vec3, directions: &[Vec3]) -> bool {
        let p = self.stretch(p);
        p.amax() <= 1.0 && self.contains_stretched(p, directions)
    }

    fn contains_stretched(&self, p: Vec3, directions: &[Vec3]) -> bool {
        directions.iter().zip(&self.support).all(|(d, support)| d.dot(&p) <= *support)
    }

    /// A point in the hull's stretched frame: within -1..1 along each axis for points of the hull.
    fn stretch(&self, p: Vec3) -> Vec3 {
        let d = p - self.middle;
        Vec3::from_fn(|i, _| 2.0 * self.axes[i].dot(&d) / self.extents[i])
    }
}

/// Unit vectors spread evenly over the sphere.
pub(super) fn directions() -> Vec<Vec3> {
    let golden = std::f64::consts::PI * (3.0 - 5.0_f64.sqrt());
    let on_sphere = |i: usize| {
        let z = 1.0 - (2.0 * i as f64 + 1.0) / DIRECTIONS as f64;
        let (s, c) = (golden * i as f64).sin_cos();
        let r = (1.0 - z * z).sqrt();
        Vec3::new(r * c, r * s, z)
    };
    (0..DIRECTIONS).map(on_sphere).collect()
}
