//! Numbers for the judge of depth.

/// Depth over the object.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct DepthThresholds {
    /// Ratio of the object's extent in another view to that in a camera's own, from which the camera sees
    /// it end-on. Chosen by hand.
    pub(crate) end_on_ratio: f64,
    /// Share of the object with depth below which there is a warning, 0..=1. Chosen by hand;
    /// cameras of healthy recordings have at least 0.78.
    pub(crate) good_coverage: f64,
    /// Share of the object with depth below which a camera contributes nothing, 0..=1. Chosen by
    /// hand.
    pub(crate) min_coverage: f64,
    /// Share of a mask's depth that may lie far from the rest, 0..=1. Chosen by hand: soft edges of
    /// a mask show some background.
    pub(crate) max_apart_share: f64,
    /// Share of the object's pixels that may carry a number that stands for no depth, 0..=1. Chosen
    /// by hand.
    pub(crate) max_filled_share: f64,
}

impl Default for DepthThresholds {
    fn default() -> Self {
        Self {
            end_on_ratio: 1.5,
            good_coverage: 0.6,
            min_coverage: 0.1,
            max_apart_share: 0.12,
            max_filled_share: 0.005,
        }
    }
}
