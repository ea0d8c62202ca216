//! Surface nodes that cameras could have seen: those that no nearer part of the surface hides.

use nalgebra::Vector3;

/// Nodes that are looked at, at most; of more, evenly chosen ones.
const MOST: usize = 2000;
/// A node hides what is this near to the ray through it, in spacings, and at least a spacing
/// farther.
const WIDTH: f64 = 0.6;

/// Indices of surface nodes that some camera could see; all of them without cameras. Of large
/// surfaces a part stands for the whole.
pub(crate) fn visible(
    nodes: &[Vector3<f64>],
    cameras: &[Vector3<f64>],
    spacing_m: f64,
) -> Vec<usize> {
    let stride = nodes.len().div_ceil(MOST).max(1);
    let hidden = |i: usize, camera: &Vector3<f64>| {
        let ray = nodes[i] - camera;
        let far = ray.norm();
        if far <= 0.0 {
            return false;
        }
        let direction = ray / far;
        nodes.iter().any(|node| {
            let to = node - camera;
            let along = to.dot(&direction);
            along > 0.0
                && along < far - spacing_m
                && (to - direction * along).norm() < WIDTH * spacing_m
        })
    };
    let seen = |i: &usize| cameras.is_empty() || cameras.iter().any(|c| !hidden(*i, c));
    (0..nodes.len()).step_by(stride).filter(seen).collect()
}

#[cfg(test)]
mod tests;
