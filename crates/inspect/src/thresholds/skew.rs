//! Numbers for the judge of skew by motion.

/// Skew and drift between cameras, measured from motion.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct SkewThresholds {
    /// Longest skew that is looked for [s]. Chosen by hand.
    pub(crate) max_skew_s: f64,
    /// Longest skew that is looked for [lengths of the range of frames that is aligned]. Chosen by
    /// hand: the shifted paths must overlap.
    pub(crate) max_skew_share: f64,
    /// Least standard deviation of a path that can be aligned [m]. Chosen by hand, well above the
    /// noise of the middle of a mask.
    pub(crate) min_motion_m: f64,
    /// Least frames that two shifted paths have in common. Chosen by hand.
    pub(crate) min_shared_frames: usize,
    /// Longest gap of a path that is filled in by a straight line [frames]. Chosen by hand: a camera at
    /// a quarter of the rate has gaps of three.
    pub(crate) max_gap_frames: usize,
    /// Share of the variance between two paths that may remain after the shift, 0..=1; if more
    /// remains, there is no skew. Chosen by hand.
    pub(crate) max_remaining_share: f64,
    /// The same of half of a recording, where a shift has to be clearer to be part of a drift.
    pub(crate) max_remaining_share_of_half: f64,
    /// Skew from which there is a warning [frames]. In healthy recordings at most 0.12 frames are
    /// measured.
    pub(crate) max_skew_frames: f64,
    /// Skew from which a fit is meaningless, if it is also more than `bad_skew_frames` [s]. Chosen
    /// by hand.
    pub(crate) bad_skew_s: f64,
    /// Skew from which a fit is meaningless, if it is also more than `bad_skew_s` [frames]. Chosen
    /// by hand.
    pub(crate) bad_skew_frames: f64,
    /// Deviation between two paths without a shift, in at least one half, from which their skew may grow
    /// [m]. Chosen by hand: cameras see different sides of a hand, whose middles differ by half of this.
    pub(crate) min_drift_deviation_m: f64,
    /// Growth of the skew from the first half to the second beyond which clocks drift [frames].
    /// Chosen by hand; in healthy recordings at most 0.27 frames are measured.
    pub(crate) max_drift_frames: f64,
}

impl Default for SkewThresholds {
    fn default() -> Self {
        Self {
            max_skew_s: 1.0,
            max_skew_share: 0.25,
            min_motion_m: 0.012,
            min_shared_frames: 10,
            max_gap_frames: 3,
            max_remaining_share: 0.6,
            max_remaining_share_of_half: 0.3,
            max_skew_frames: 0.8,
            bad_skew_s: 0.1,
            bad_skew_frames: 3.0,
            min_drift_deviation_m: 0.012,
            max_drift_frames: 3.0,
        }
    }
}
