//! Points of a skin that cameras could have seen: those that no nearer part of the surface hides.

use bendtwin_core::geometry::point;
use nalgebra::Vector3;

use crate::{rigid::thinned, surface::spacing};

/// Points used at most; of more, evenly chosen ones stand for the whole.
const MOST: usize = 2000;
/// A point hides what is this near to the ray through it, in spacings, and at least a spacing
/// farther.
const WIDTH: f64 = 0.6;

/// The points of a skin that some camera could see [m]; all of them without cameras.
pub(crate) fn visible(skin: &[Vector3<f64>], cameras: &[Vector3<f64>]) -> Vec<Vector3<f64>> {
    let points = thinned(skin, MOST);
    if cameras.is_empty() {
        return points;
    }
    let spacing_m = spacing(&points.iter().map(|p| point(*p)).collect::<Vec<_>>());
    let hidden = |p: &Vector3<f64>, camera: &Vector3<f64>| {
        let ray = p - camera;
        let far = ray.norm();
        if far <= 0.0 {
            return false;
        }
        let direction = ray / far;
        points.iter().any(|other| {
            let to = other - camera;
            let along = to.dot(&direction);
            along > 0.0
                && along < far - spacing_m
                && (to - direction * along).norm() < WIDTH * spacing_m
        })
    };
    points.iter().filter(|p| cameras.iter().any(|c| !hidden(p, c))).copied().collect()
}

#[cfg(test)]
mod tests;
