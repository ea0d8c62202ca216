//! The Gaussian window of SSIM, and the means that it takes.

use std::sync::LazyLock;

use crate::{
    filter::{Border, gaussian, separable},
    planes::Plane,
};

/// (K1 L)² with K1 = 0.01 and colours up to L = 1.
pub(super) const C1: f32 = 1e-4;
/// (K2 L)² with K2 = 0.03.
pub(super) const C2: f32 = 9e-4;

/// 11 values with σ = 1.5 pixels.
static KERNEL: LazyLock<Vec<f32>> = LazyLock::new(|| gaussian(1.5, 5));

/// Windowed means of one channel.
pub(super) struct Moments {
    /// Windowed mean of the values.
    pub(super) mean: Plane,
    /// Windowed mean of their squares.
    pub(super) square: Plane,
}

impl Moments {
    pub(super) fn of(plane: &Plane) -> Self {
        let squares = plane.zip(plane, |a, b| a * b);
        Self { mean: smooth(plane), square: smooth(&squares) }
    }
}

/// Windowed means of a plane.
pub(super) fn smooth(plane: &Plane) -> Plane {
    separable(plane, &KERNEL, &KERNEL, Border::Zero)
}
