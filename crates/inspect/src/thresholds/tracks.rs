//! Numbers for the judge of 2D tracks.

/// 2D tracks of each camera.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct TrackThresholds {
    /// Share of visible tracks that should lie on a mask, 0..=1. Chosen by hand; in healthy
    /// recordings it is at least 0.99.
    pub(crate) min_inside_share: f64,
    /// Ratio of tracks on a mask with exchanged coordinates to those without, from which they are
    /// exchanged. Chosen by hand.
    pub(crate) transposed_ratio: f64,
    /// Share of tracks that then lie on a mask, 0..=1. The majority decides.
    pub(crate) min_transposed_share: f64,
    /// Share of visible track points beyond which NaN or infinity is an error, 0..=1. The majority
    /// decides.
    pub(crate) max_not_finite_share: f64,
    /// Share of the tracks that should be visible at the end of the part for fitting, 0..=1. Chosen
    /// by hand; in healthy recordings more than half are.
    pub(crate) min_survival_share: f64,
    /// Frames at the end in which survivors are counted: a hand in front of the lens loses tracks
    /// for a moment. Chosen by hand.
    pub(crate) end_frames: usize,
    /// Travel of the object from which its tracks must move [m]. Chosen by hand.
    pub(crate) min_travel_m: f64,
    /// Reach of tracks that is no motion but jitter [px]. Chosen by hand.
    pub(crate) still_px: f64,
    /// Motion that counts as still in large images [widths of the image]: 3.4 of 848 pixels. Chosen
    /// by hand.
    pub(crate) still_widths: f64,
}

impl Default for TrackThresholds {
    fn default() -> Self {
        Self {
            min_inside_share: 0.6,
            transposed_ratio: 2.0,
            min_transposed_share: 0.5,
            max_not_finite_share: 0.5,
            min_survival_share: 0.15,
            end_frames: 5,
            min_travel_m: 0.05,
            still_px: 1.0,
            still_widths: 0.004,
        }
    }
}
