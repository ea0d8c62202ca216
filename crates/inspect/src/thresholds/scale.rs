//! Numbers for the judge of sizes and heights.

use std::ops::RangeInclusive;

/// Sizes, heights, and the up axis.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct ScaleThresholds {
    /// Sizes of things that hands move and depth cameras resolve [m]. Chosen by hand, so that
    /// centimetres or millimetres taken for metres lie outside for usual objects.
    pub(crate) object_size_m: RangeInclusive<f64>,
    /// Usual size of such things [m]: of two units that differ by a power of ten, the one is right
    /// with which the object is nearer to it. The objects of PhysTwin's cases are 0.1 to 0.6 m large.
    pub(crate) usual_object_m: f64,
    /// Size from which there is a warning [m]: five times as large as usual. Chosen by hand.
    pub(crate) large_object_m: f64,
    /// Size of the visible part of a hand or gripper from which units are doubted too [m]. Chosen
    /// by hand: of a person, more than a forearm is rarely masked.
    pub(crate) large_manipulator_m: f64,
    /// Depth below the ground from which the object lies there not by noise alone [m]. Chosen by
    /// hand.
    pub(crate) below_m: f64,
    /// Share of points below the ground that noise explains, 0..=1. Chosen by hand.
    pub(crate) max_below_share: f64,
    /// Share of points below the ground from which the ground is useless, 0..=1. Below the quarter of
    /// the lifted points that `bendtwin_capture::check` allows.
    pub(crate) bad_below_share: f64,
    /// Depth of the lowest point below the ground from which a single frame counts [m]: twice
    /// `below_m`.
    pub(crate) deep_below_m: f64,
    /// Share of one camera's points below the ground from which a single frame counts, 0..=1.
    /// Chosen by hand.
    pub(crate) deep_below_share: f64,
    /// Height of the lowest point from which the object does not need the ground [m]. Chosen by
    /// hand.
    pub(crate) max_height_m: f64,
    /// Median cosine between the down axis of the images and down in the world below which the
    /// world is upside down. Chosen by hand: below 0, so that cameras that look straight down do
    /// not count.
    pub(crate) upside_down_cosine: f64,
}

impl Default for ScaleThresholds {
    fn default() -> Self {
        Self {
            object_size_m: 0.01..=3.0,
            usual_object_m: 0.25,
            large_object_m: 1.25,
            large_manipulator_m: 0.8,
            below_m: 0.02,
            max_below_share: 0.02,
            bad_below_share: 0.2,
            deep_below_m: 0.04,
            deep_below_share: 0.1,
            max_height_m: 0.5,
            upside_down_cosine: -0.2,
        }
    }
}
