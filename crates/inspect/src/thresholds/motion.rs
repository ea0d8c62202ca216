//! Numbers for the judge of motion and contact.

/// Motion of object and hand, and their contact.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct MotionThresholds {
    /// Travel below which a thing stands still [m]. Chosen by hand, above the noise of the middle
    /// of a mask.
    pub(crate) still_m: f64,
    /// Reach of tracks below which they stand still [px]. Chosen by hand.
    pub(crate) still_px: f64,
    /// Ratio of largest to smallest area of a mask below which its shape does not change. Chosen by
    /// hand.
    pub(crate) same_area_ratio: f64,
    /// Distance between hand and object beyond which they do not touch [m]. Chosen by hand: fingers
    /// hide the contact from cameras, so that what they see of hand and object stays apart; in
    /// healthy recordings 5 mm.
    pub(crate) max_gap_m: f64,
    /// Motion from frame to frame that blurs images and loses tracks [m]: 2.4 m/s at 30 frames a
    /// second. Chosen by hand; healthy recordings reach 14 mm.
    pub(crate) fast_m: f64,
    /// Fast motion in the image [widths of the image]: 50 of 848 pixels. Chosen by hand.
    pub(crate) fast_widths: f64,
    /// Fast frames that are no chance. Chosen by hand.
    pub(crate) min_fast_frames: usize,
    /// Ratio of a step to those around it from which a frame was skipped. A skipped frame doubles
    /// the step; chosen by hand, below 2.
    pub(crate) skip_ratio: f64,
    /// Ratio of the steps beside a frame to the usual one from which motion is steady there. Chosen by
    /// hand.
    pub(crate) steady_ratio: f64,
    /// Step below which such a ratio is noise [m]. Chosen by hand.
    pub(crate) skip_m: f64,
    /// Median step around a frame from which the object moves there [multiples of `skip_m`]. Chosen
    /// by hand.
    pub(crate) moving_ratio: f64,
    /// Share of moving frames with skips from which there is a finding, 0..=1. Chosen by hand.
    pub(crate) min_skip_share: f64,
    /// Skips from which there is a finding. Chosen by hand.
    pub(crate) min_skips: usize,
}

impl Default for MotionThresholds {
    fn default() -> Self {
        Self {
            still_m: 0.008,
            still_px: 3.0,
            same_area_ratio: 1.15,
            max_gap_m: 0.06,
            fast_m: 0.08,
            fast_widths: 0.06,
            min_fast_frames: 3,
            skip_ratio: 1.65,
            steady_ratio: 0.7,
            skip_m: 0.006,
            moving_ratio: 0.6,
            min_skip_share: 0.1,
            min_skips: 3,
        }
    }
}
