//! The contrast sensitivity of the eye, as filters of an opponent image.

use std::f64::consts::PI;

use super::color::Opponent;
use crate::{
    filter::{Border, sampled, separable},
    planes::Plane,
};

/// Term a sqrt(π / b) exp(-π² r² / b) of a filter, r in degrees.
struct Gaussian {
    a: f64,
    b: f64,
}

const ACHROMATIC: [Gaussian; 1] = [Gaussian { a: 1.0, b: 0.0047 }];
const RED_GREEN: [Gaussian; 1] = [Gaussian { a: 1.0, b: 0.0053 }];
const BLUE_YELLOW: [Gaussian; 2] = [Gaussian { a: 34.1, b: 0.04 }, Gaussian { a: 13.5, b: 0.025 }];
/// The largest b, which gives the radius of all three.
const WIDEST: f64 = 0.04;

/// Image after the filters of its three channels, table 1 of the paper. Each filter is cut off at
/// three standard deviations of the widest, and its sum is 1.
pub(super) fn filtered(image: &Opponent, pixels_per_degree: f64) -> Opponent {
    let filter = |plane: &Plane, terms: &[Gaussian]| filter(plane, terms, pixels_per_degree);
    Opponent {
        achromatic: filter(&image.achromatic, &ACHROMATIC),
        red_green: filter(&image.red_green, &RED_GREEN),
        blue_yellow: filter(&image.blue_yellow, &BLUE_YELLOW),
    }
}

fn filter(plane: &Plane, terms: &[Gaussian], pixels_per_degree: f64) -> Plane {
    let radius = (3.0 * (WIDEST / (2.0 * PI * PI)).sqrt() * pixels_per_degree).ceil() as usize;
    // A Gaussian of the distance is the product of one along x and one along y.
    let kernels: Vec<(f64, Vec<f64>)> = terms
        .iter()
        .map(|term| {
            let exponent = PI * PI / (term.b * pixels_per_degree * pixels_per_degree);
            (term.a * (PI / term.b).sqrt(), sampled(radius, |x| (-exponent * x * x).exp()))
        })
        .collect();
    let sum: f64 = kernels.iter().map(|(scale, k)| scale * k.iter().sum::<f64>().powi(2)).sum();
    let parts = kernels.iter().map(|(scale, kernel)| {
        let along_x: Vec<f32> = kernel.iter().map(|v| *v as f32).collect();
        let along_y: Vec<f32> = kernel.iter().map(|v| (scale / sum * v) as f32).collect();
        separable(plane, &along_x, &along_y, Border::Nearest)
    });
    parts.reduce(|a, b| a.zip(&b, |a, b| a + b)).unwrap_or_else(|| plane.clone())
}
