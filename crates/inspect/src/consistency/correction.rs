//! The rigid motion of one camera that best fits it to the others: point-to-plane registration with
//! correspondences by projection, and weights that fade with distance.
//!
//! With q the place and n the normal of what another camera measured where a surfel p appears, the
//! motion `x -> Ωx + t` minimises the weighted sum of `(n · (p + ω × (p - c) + t - q))²`; see Chen
//! and Medioni, *Object modelling by registration of multiple range images* (1992), and for the
//! correspondences Blais and Levine (1995).

use bendtwin_capture::raw::Pose;
use nalgebra::{Matrix6, Rotation3, Vector3, Vector6};

use super::{SampledCrop, ViewSet, hypothesis::Hypothesis, reprojection::place};
use crate::vector::{Vector, add, cross, dot, pixel_of, scaled, sub, to_camera, to_world, turn};

/// Gauss-Newton steps, each with new correspondences.
const ITERATIONS: usize = 20;
/// Stiffness against moving along what the surface does not determine, as a share of the trace.
const DAMPING: f64 = 1e-4;

/// The rigid motion that would fit one camera to the others.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Correction {
    pub(crate) motion: Pose,
    /// Angle of its rotation [rad].
    pub(crate) angle: f64,
    /// Distance by which the motion moves the middle of what the camera sees of the object [m].
    pub(crate) shift_m: f64,
}

/// A surfel, and the plane on which another camera sees it.
struct Match {
    at: Vector,
    plane: Vector,
    normal: Vector,
}

/// Fits view `which` to all the others. `None` if they have too little in common.
pub(crate) fn correct(
    set: &ViewSet<'_>,
    hypothesis: &Hypothesis,
    which: usize,
) -> Option<Correction> {
    let mut total = Pose::IDENTITY;
    let mut pivot = None;
    let limits = set.thresholds;
    for iteration in 0..ITERATIONS {
        let share = iteration as f64 / (ITERATIONS - 1) as f64;
        let reach = limits.max_apart_m * (limits.end_reach_m / limits.max_apart_m).powf(share);
        let moved = hypothesis.with(which, |s| s.moved = Some(total));
        let matches = matches(set, &moved, which);
        if matches.len() < limits.min_matches {
            return None;
        }
        let middle = scaled(
            matches.iter().fold([0.0; 3], |sum, m| add(sum, m.at)),
            1.0 / matches.len() as f64,
        );
        // The surfels' middle before anything moved.
        pivot.get_or_insert(middle);
        let step = solve(&matches, middle, reach)?;
        total = step.after(&total);
    }
    let pivot = pivot?;
    let shift_m = crate::vector::distance(total.moved(pivot), pivot);
    let rotation =
        Rotation3::from_matrix_unchecked(nalgebra::Matrix3::from_fn(|i, j| total.rotation[i][j]));
    Some(Correction { motion: total, angle: rotation.angle(), shift_m })
}

fn matches(set: &ViewSet<'_>, hypothesis: &Hypothesis, which: usize) -> Vec<Match> {
    let mut found = Vec::new();
    let Some(own) = set.views.get(which) else { return found };
    for sampled in own.crops.iter().filter(|s| set.frames.contains(&s.crop.frame)) {
        let frame = sampled.crop.frame;
        let Some(posed) = hypothesis.posed(&set.views, which, frame) else { continue };
        for (index, other) in set.views.iter().enumerate().filter(|(i, _)| *i != which) {
            let same = |s: &&SampledCrop<'_>| s.crop.frame == frame;
            let Some(seen) = other.crops.iter().find(same) else { continue };
            let Some(other_posed) = hypothesis.posed(&set.views, index, frame) else { continue };
            for surfel in &sampled.surfels {
                let at = place(surfel, &posed);
                let Some(pixel) = pixel_of(other.camera, to_camera(&other_posed.pose, at)) else {
                    continue;
                };
                let Some(cell) = seen.crop.cell(pixel) else { continue };
                let Some(normal) = seen.crop.normal(other.camera, cell) else { continue };
                let Some(surface) = seen.crop.place(other.camera, cell) else { continue };
                let surface = scaled(surface, other_posed.depth_scale);
                let normal = turn(&other_posed.pose.rotation, normal);
                if dot(normal, turn(&posed.pose.rotation, surfel.normal))
                    > set.thresholds.min_normal_cosine
                {
                    found.push(Match { at, plane: to_world(&other_posed.pose, surface), normal });
                }
            }
        }
    }
    found
}

fn solve(matches: &[Match], middle: Vector, reach: f64) -> Option<Pose> {
    let mut normal_matrix = Matrix6::zeros();
    let mut right = Vector6::zeros();
    for m in matches {
        let residual = dot(m.normal, sub(m.at, m.plane));
        let ratio = residual / reach;
        if ratio.abs() >= 1.0 {
            continue;
        }
        let weight = (1.0 - ratio * ratio).powi(2);
        let [a, b, c] = cross(sub(m.at, middle), m.normal);
        let row = Vector6::new(a, b, c, m.normal[0], m.normal[1], m.normal[2]);
        normal_matrix += row * row.transpose() * weight;
        right -= row * residual * weight;
    }
    let damping = DAMPING * normal_matrix.trace() / 6.0;
    let step = (normal_matrix + Matrix6::identity() * damping).cholesky()?.solve(&right);
    let rotation = Rotation3::new(Vector3::new(step[0], step[1], step[2]));
    let rotation: [[f64; 3]; 3] =
        std::array::from_fn(|i| std::array::from_fn(|j| rotation.matrix()[(i, j)]));
    let shift = [step[3], step[4], step[5]];
    // About the middle: x becomes R (x - c) + c + t.
    let translation = add(sub(middle, turn(&rotation, middle)), shift);
    translation.iter().all(|x| x.is_finite()).then_some(Pose { rotation, translation })
}
