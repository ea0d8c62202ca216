//! Numbers for the judge of the grids of depth, colour and masks.
//!
//! Measured on the healthy recordings and on the public capture `toy_lift`, as medians over a
//! camera's frames: 94 to 100 % of the pairs across an outline agree with depth, the best warp gains
//! at most 2 % and moves by at most 0.8 px; 94 % or more agree with colour, and 51 % or fewer with
//! mirrored colour.

/// Depth, colour or masks that lie on another grid.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct AlignmentThresholds {
    /// Share of pairs that must agree under the warp that is named, 0..=1: the majority.
    pub(crate) min_share: f64,
    /// Gain in that share over the declared grid from which depth is off. Depth of `toy_lift` that
    /// is shifted by 3 px gains 0.13 to 0.23, by 2 px 0.07 to 0.14.
    pub(crate) min_gain: f64,
    /// Distance by which the warp moves what the masks show from which depth is off [px]. Twice what
    /// is measured where nothing is off.
    pub(crate) min_moved_px: f64,
    /// Smallest shift where depth of the object is sparse.
    pub(crate) min_moved_sparse_px: f64,
    /// Shift from which a fit is meaningless [widths of the image]: 8 of 424 pixels, 1 cm and more
    /// at 0.6 m. Chosen by hand.
    pub(crate) bad_moved_widths: f64,
    /// Error of the scale from which a fit is meaningless: another field of view. Chosen by hand.
    pub(crate) bad_scale_error: f64,
    /// Share of pairs whose outer spot is nearer, from which depth falls with distance, 0..=1. In
    /// healthy recordings it is at most 0.05.
    pub(crate) min_forward_share: f64,
    /// Gain in agreement with colour from which the masks are what is off.
    pub(crate) min_color_gain: f64,
    /// Gain in agreement by mirroring from which colour is mirrored. Mirrored colour of the healthy
    /// recordings gains 0.5 and more.
    pub(crate) min_mirrored_gain: f64,
    /// Share of the frames that must name one warp, 0..=1.
    pub(crate) min_votes: f64,
    /// Ratio of two scales that are one, less 1.
    pub(crate) same_scale: f64,
    /// Distance of two shifts that are one [px], with a share of the width of the image.
    pub(crate) same_shift_px: f64,
    /// Shift of that share [widths of the image].
    pub(crate) same_shift_widths: f64,
}

impl Default for AlignmentThresholds {
    fn default() -> Self {
        Self {
            min_share: 0.5,
            min_gain: 0.08,
            min_moved_px: 1.6,
            min_moved_sparse_px: 4.0,
            bad_moved_widths: 0.02,
            bad_scale_error: 0.06,
            min_forward_share: 0.6,
            min_color_gain: 0.02,
            min_mirrored_gain: 0.25,
            min_votes: 0.6,
            same_scale: 0.1,
            same_shift_px: 2.0,
            same_shift_widths: 0.01,
        }
    }
}
