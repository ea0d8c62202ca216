//! Numbers for the registration of depth and colour onto the masks.

/// Outlines of masks, and what depth and colour do there.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct OutlineThresholds {
    /// Pairs of spots across the outline that an image needs.
    pub(crate) min_pairs: usize,
    /// Step in depth behind an outline over the depth of what the mask shows. Relative, so that
    /// units do not matter: 2 cm at 0.6 m.
    pub(crate) step_share: f64,
    /// Distance of the spots from the outline [widths of the image]: 2 to 4 pixels, since outlines
    /// of masks are good to a few pixels.
    pub(crate) beside_widths: f64,
    /// Sum of the offsets of pixels outside the mask around a spot of an outline with a direction
    /// [px].
    pub(crate) min_direction: f64,
    /// Share of the pairs whose inner spot must have depth, 0..=1. Chosen by hand: without depth on a
    /// hand, the object is left.
    pub(crate) min_known_share: f64,
    /// Share of pairs that agree beyond which other fields of view are not tried, 0..=1: to save time.
    pub(crate) good_share: f64,
    /// Difference of colours that counts fully [grey levels of 255, summed over channels].
    pub(crate) full_contrast: f64,
}

impl Default for OutlineThresholds {
    fn default() -> Self {
        Self {
            min_pairs: 40,
            step_share: 0.03,
            beside_widths: 0.006,
            min_direction: 8.0,
            min_known_share: 0.4,
            good_share: 0.75,
            full_contrast: 90.0,
        }
    }
}
