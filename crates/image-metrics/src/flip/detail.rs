//! Edges, and points or lines, of the achromatic channel.

use crate::{
    filter::{Border, gaussian, sampled, separable},
    planes::Plane,
};

/// Width of the features that are looked for [degrees].
const FEATURE_DEG: f64 = 0.082;

/// Strengths of edges and of points at each pixel: lengths of the first and of the second
/// derivatives along x and y of the channel, mapped to 0..1, after a Gaussian with σ half a feature
/// wide. Positive weights of a derivative sum up to 1 and negative ones to -1.
pub(super) fn strengths(achromatic: &Plane, pixels_per_degree: f64) -> (Plane, Plane) {
    let sigma = 0.5 * FEATURE_DEG * pixels_per_degree;
    let radius = (3.0 * sigma).ceil() as usize;
    let unit = achromatic.zip(achromatic, |y, _| (y + 16.0) / 116.0);
    let bell = |x: f64| (-x * x / (2.0 * sigma * sigma)).exp();
    let smooth = gaussian(sigma, radius);
    let strength = |derivative: Vec<f64>| {
        let kernel = balanced(&derivative);
        let along_x = separable(&unit, &kernel, &smooth, Border::Nearest);
        let along_y = separable(&unit, &smooth, &kernel, Border::Nearest);
        along_x.zip(&along_y, f32::hypot)
    };
    let edges = strength(sampled(radius, |x| -x * bell(x)));
    let points = strength(sampled(radius, |x| (x * x / (sigma * sigma) - 1.0) * bell(x)));
    (edges, points)
}

/// Kernel whose positive values are scaled to a sum of 1 and its negative ones to -1.
fn balanced(kernel: &[f64]) -> Vec<f32> {
    let above: f64 = kernel.iter().filter(|v| **v > 0.0).sum();
    let below: f64 = -kernel.iter().filter(|v| **v < 0.0).sum::<f64>();
    kernel.iter().map(|v| (v / if *v > 0.0 { above } else { below }) as f32).collect()
}
