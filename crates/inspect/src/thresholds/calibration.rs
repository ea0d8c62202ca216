//! Numbers for the judge of calibrations.

use std::ops::{Range, RangeInclusive};

/// Intrinsics and poses, each for itself.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct CalibrationThresholds {
    /// Largest deviation of a rotation from orthonormal: dot products of rows from 0, and their
    /// lengths from 1. Chosen by hand: poses that were written with three digits pass.
    pub(crate) max_rotation_error: f64,
    /// Focal lengths of usual lenses [widths of the image]: horizontal fields of view from 127 down
    /// to 7 degrees. Chosen by hand.
    pub(crate) focal_widths: RangeInclusive<f64>,
    /// Ratio of the two focal lengths. Pixels are nearly square; chosen by hand.
    pub(crate) focal_ratio: Range<f64>,
    /// Place of the principal point [widths or heights of the image]: the middle half. Chosen by
    /// hand.
    pub(crate) principal_share: RangeInclusive<f64>,
    /// Mean place of the principal point [half widths and half heights]. Outside, the intrinsics
    /// may belong to another resolution, and the message asks. Chosen by hand, within the factors
    /// of 1.33 and more by which usual resolutions differ.
    pub(crate) unscaled_principal: RangeInclusive<f64>,
    /// Largest difference of any number of two poses that are one pose (metres for translations).
    /// Far below what two calibrations agree to: only a copy is that near.
    pub(crate) max_same_pose: f64,
}

impl Default for CalibrationThresholds {
    fn default() -> Self {
        Self {
            max_rotation_error: 1e-2,
            focal_widths: 0.25..=8.0,
            focal_ratio: 0.5..2.0,
            principal_share: 0.25..=0.75,
            unscaled_principal: 0.77..=1.3,
            max_same_pose: 1e-6,
        }
    }
}
