//! Numbers for the judge of masks.

/// Masks that are empty, inverted, overlapping, or that jump.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct MaskThresholds {
    /// Ratio of the areas of a mask in two successive frames from which it jumps. Chosen by hand;
    /// in healthy recordings it is at most 1.18.
    pub(crate) max_area_ratio: f64,
    /// Largest ratio of areas in two successive frames that turning explains; only what exceeds it counts
    /// as a jump. Chosen by hand; rings seen from the side reach 1.25.
    pub(crate) max_turn_ratio: f64,
    /// Area below which such a ratio means nothing [areas of the image]: 150 pixels of 640 x 480.
    /// Chosen by hand.
    pub(crate) min_area_share: f64,
    /// Share of the image beyond which a mask shows the background, 0..=1. Chosen by hand.
    pub(crate) max_covered_share: f64,
    /// Share of the smaller mask that may belong to both, 0..=1. Chosen by hand.
    pub(crate) max_overlap_share: f64,
    /// Share of frames without object from which the only camera that sees it is of little use,
    /// 0..=1. Chosen by hand.
    pub(crate) max_empty_share: f64,
    /// Share of the images with masks up to which only clicks were given, and nothing was followed.
    pub(crate) min_masked_share: f64,
    /// Frames from which a recording is one that masks have to be followed through. Chosen by hand.
    pub(crate) min_followed_frames: usize,
    /// Share of an image at its border where an object's middle counts as out of view, 0..=0.5. Chosen by
    /// hand: about half of a small object.
    pub(crate) view_margin: f64,
    /// Way that an object goes along the ground or up, from which something carries it [m]. Chosen by
    /// hand, well above what a soft object does when it settles.
    pub(crate) carried_m: f64,
    /// Way of the middles of object and hand from one frame to the next, together, from which they may
    /// have changed places [widths of the image]. Chosen by hand, above any motion.
    pub(crate) min_exchange_widths: f64,
    /// Ratio of the way to each other's place to that from their own, below which they did. Chosen by
    /// hand.
    pub(crate) max_exchange_ratio: f64,
}

impl Default for MaskThresholds {
    fn default() -> Self {
        Self {
            max_area_ratio: 1.45,
            max_turn_ratio: 1.25,
            min_area_share: 5e-4,
            max_covered_share: 0.6,
            max_overlap_share: 0.1,
            max_empty_share: 0.3,
            min_masked_share: 0.1,
            min_followed_frames: 4,
            view_margin: 0.05,
            carried_m: 0.05,
            min_exchange_widths: 0.06,
            max_exchange_ratio: 0.3,
        }
    }
}
