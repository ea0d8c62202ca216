//! FLIP: differences that people see when they flip between two images.

mod color;
mod detail;
mod sensitivity;

use rayon::prelude::*;

pub use self::color::linear;
use self::color::{Lab, Opponent};
use crate::{
    Pair,
    planes::{Plane, channels},
};

/// Pixels per degree of the visual angle that FLIP's authors assume: a display 0.7 m wide with 3840
/// columns, seen from 0.7 m.
pub const PIXELS_PER_DEGREE: f64 = 67.020_643;

/// Exponent of the colour difference.
const COLOR_EXPONENT: f32 = 0.7;
/// Exponent of the feature difference.
const FEATURE_EXPONENT: f32 = 0.5;
/// Share of the largest colour difference below which differences are stretched.
const KNEE_AT: f32 = 0.4;
/// Value that differences have there.
const KNEE_VALUE: f32 = 0.95;

/// FLIP of two images, 0 to 1: the mean over pixels of LDR-FLIP of Andersson et al., "FLIP: a
/// difference evaluator for alternating images" (2020), at [`PIXELS_PER_DEGREE`].
///
/// With the colour difference c (HyAB distance of colours that are filtered by the eye's contrast
/// sensitivity, to the power 0.7 and mapped to 0..1) and the feature difference f (of edges and
/// points, to the power 0.5), a pixel has c^(1 - f). Beyond the border lies the nearest pixel.
pub fn flip(pair: &Pair<'_>) -> f64 {
    let values = flip_map(pair);
    values.iter().map(|v| f64::from(*v)).sum::<f64>() / values.len() as f64
}

/// FLIP of each pixel, shape [height, width].
fn flip_map(pair: &Pair<'_>) -> Vec<f32> {
    let seen: Vec<Perceived> = [pair.image(), pair.reference()]
        .into_par_iter()
        .map(|image| Perceived::new(&channels(pair, image)))
        .collect();
    let [a, b] = seen.as_slice() else { return Vec::new() };
    let largest = largest_color_difference();
    let pixel = |p: usize| {
        let color = stretched(hyab(a.colors[p], b.colors[p]).powf(COLOR_EXPONENT), largest);
        let edges = (a.edges.values[p] - b.edges.values[p]).abs();
        let points = (a.points.values[p] - b.points.values[p]).abs();
        let feature = (edges.max(points) * std::f32::consts::FRAC_1_SQRT_2).powf(FEATURE_EXPONENT);
        color.powf(1.0 - feature)
    };
    (0..a.colors.len()).map(pixel).collect()
}

/// An image as an eye has it.
struct Perceived {
    /// Filtered colours.
    colors: Vec<Lab>,
    /// Strength of edges at each pixel.
    edges: Plane,
    /// Strength of points and lines at each pixel.
    points: Plane,
}

impl Perceived {
    fn new(srgb: &[Plane; 3]) -> Self {
        let opponent = Opponent::of(srgb);
        let (edges, points) = detail::strengths(&opponent.achromatic, PIXELS_PER_DEGREE);
        let filtered = sensitivity::filtered(&opponent, PIXELS_PER_DEGREE);
        Self { colors: filtered.colors(), edges, points }
    }
}

/// Distance that suits large colour differences: |ΔL| + |(Δa, Δb)|.
fn hyab(a: Lab, b: Lab) -> f32 {
    (a.lightness - b.lightness).abs() + (a.a - b.a).hypot(a.b - b.b)
}

/// Colour difference of pure green and pure blue, the largest that there is, to the power 0.7.
fn largest_color_difference() -> f32 {
    let [green, blue] = [[0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(color::hunt_lab_of_linear);
    hyab(green, blue).powf(COLOR_EXPONENT)
}

/// Difference mapped to 0..1: most of the range is spent on the smaller ones.
fn stretched(difference: f32, largest: f32) -> f32 {
    let knee = KNEE_AT * largest;
    if difference < knee {
        KNEE_VALUE / knee * difference
    } else {
        KNEE_VALUE + (difference - knee) / (largest - knee) * (1.0 - KNEE_VALUE)
    }
}

#[cfg(test)]
mod tests;
