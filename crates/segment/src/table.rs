//! The plane on which things lie: the largest one near the strokes in the depth of all cameras.

use bendtwin_core::{
    Point,
    geometry::{Vector, cross, dot, sub, unit, wide},
};
use bendtwin_near::PointTree;
use nalgebra::{Matrix3, SymmetricEigen};

/// Points farther than this from all strokes do not count [m].
const NEAR_M: f64 = 0.6;
/// Points that are looked at.
const MOST_POINTS: usize = 6_000;
const TRIALS: usize = 400;
/// Distance of a point of the plane [m].
const INLIER_M: f64 = 0.008;
/// Share of the points near the strokes that a plane must hold.
const MIN_SHARE: f64 = 0.2;
/// Least and largest distance from the plane at which a point no longer lies on it [m].
const THICKNESS_M: std::ops::RangeInclusive<f32> = 0.004..=0.012;

/// A plane, with its normal towards the cameras.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Table {
    normal: Vector,
    offset_m: f64,
    /// Distance from the plane up to which a point lies on it [m].
    pub(crate) thickness_m: f32,
}

impl Table {
    /// Height above the plane [m].
    pub(crate) fn height(&self, p: Point) -> f32 {
        (dot(self.normal, wide(p)) - self.offset_m) as f32
    }

    /// Finds the plane among points; `eyes` are the centres of the cameras, `marked` the places of
    /// strokes. `None` if no plane holds enough of the points near them.
    pub(crate) fn find(points: &[Point], eyes: &[Vector], marked: &[Point]) -> Option<Self> {
        let metric = |a, b| {
            let offset = sub(wide(a), wide(b));
            dot(offset, offset)
        };
        let strokes = PointTree::with_metric(marked.iter().copied(), metric);
        let is_near = |p: &&Point| strokes.closest(**p).is_some_and(|m| m.square.sqrt() < NEAR_M);
        let near: Vec<Vector> = points.iter().filter(is_near).map(|p| wide(*p)).collect();
        let step = near.len().div_ceil(MOST_POINTS).max(1);
        let near: Vec<Vector> = near.into_iter().step_by(step).collect();
        if near.len() < 100 {
            return None;
        }
        let mut random = 0x9E37_79B9_7F4A_7C15_u64;
        let mut pick = || {
            random ^= random << 13;
            random ^= random >> 7;
            random ^= random << 17;
            near[(random % near.len() as u64) as usize]
        };
        let mut best: Option<(usize, Vector, f64)> = None;
        for _ in 0..TRIALS {
            let [a, b, c] = [pick(), pick(), pick()];
            let Some(normal) = unit(cross(sub(b, a), sub(c, a))) else { continue };
            let offset = dot(normal, a);
            let held = near.iter().filter(|p| (dot(normal, **p) - offset).abs() < INLIER_M);
            let held = held.count();
            if best.is_none_or(|(most, ..)| held > most) {
                best = Some((held, normal, offset));
            }
        }
        let (_, mut normal, mut offset) = best?;
        for _ in 0..3 {
            (normal, offset) = fitted(&near, normal, offset)?;
        }
        let mut off: Vec<f64> = near
            .iter()
            .map(|p| (dot(normal, *p) - offset).abs())
            .filter(|d| *d < INLIER_M)
            .collect();
        if (off.len() as f64) < MIN_SHARE * near.len() as f64 {
            return None;
        }
        off.sort_unstable_by(f64::total_cmp);
        let deviation = 1.48 * off[off.len() / 2];
        let above = eyes.iter().filter(|eye| dot(normal, **eye) > offset).count();
        if 2 * above < eyes.len() {
            (normal, offset) = (normal.map(|x| -x), -offset);
        }
        let thickness_m = (3.0 * deviation) as f32;
        let thickness_m = thickness_m.clamp(*THICKNESS_M.start(), *THICKNESS_M.end());
        Some(Self { normal, offset_m: offset, thickness_m })
    }
}

/// The plane of least squares through the points of a plane.
fn fitted(points: &[Vector], normal: Vector, offset: f64) -> Option<(Vector, f64)> {
    let held: Vec<&Vector> =
        points.iter().filter(|p| (dot(normal, **p) - offset).abs() < INLIER_M).collect();
    let n = held.len() as f64;
    if n < 3.0 {
        return None;
    }
    let mean: Vector = std::array::from_fn(|a| held.iter().map(|p| p[a]).sum::<f64>() / n);
    let mut spread = Matrix3::zeros();
    for p in held {
        let d = nalgebra::Vector3::from(sub(*p, mean));
        spread += d * d.transpose();
    }
    let eigen = SymmetricEigen::new(spread);
    let least = eigen.eigenvalues.imin();
    let normal = unit(eigen.eigenvectors.column(least).into_owned().into())?;
    Some((normal, dot(normal, mean)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tilted_table_is_found_below_what_lies_on_it() {
        let mut points = Vec::new();
        for i in 0..60 {
            for j in 0..60 {
                let [x, y] = [i, j].map(|k| 0.01 * (k as f32 - 30.0));
                let noise = 0.001 * ((i * 7 + j * 13) % 5) as f32 - 0.002;
                points.push([x, y, 0.1 * x + noise]);
                if i % 3 == 0 && j < 20 {
                    points.push([x, y, 0.1 * x + 0.05]);
                }
            }
        }
        let table = Table::find(&points, &[[0.0, 0.0, 1.0]], &[[0.0; 3]]).unwrap();
        assert!(table.height([0.2, 0.1, 0.02]).abs() < 0.001);
        assert!((table.height([0.0, 0.0, 0.05]) - 0.05).abs() < 0.001);
        assert!(Table::find(&points, &[[0.0, 0.0, 1.0]], &[[9.0; 3]]).is_none());
    }
}
