//! Numbers for the judge of timing.

/// Dropped, repeated, frozen and late frames; times against the frame rate.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct TimingThresholds {
    /// Share of missing, repeated or frozen frames beyond which a fit is meaningless, 0..=1. Chosen
    /// by hand.
    pub(crate) max_lost_share: f64,
    /// Share of the frames that another camera must have before one that ends early has a lower rate,
    /// 0..=1. Chosen by hand.
    pub(crate) min_full_share: f64,
    /// Share of the frames before its end that such a camera must have, 0..=1. Chosen by hand.
    pub(crate) min_dense_share: f64,
    /// Relative deviation from a whole ratio of frames to images up to which these are of a lower rate.
    /// Chosen by hand.
    pub(crate) max_closed_up_error: f64,
    /// Largest such ratio. Chosen by hand.
    pub(crate) max_closed_up: f64,
    /// Missing frames at the end from which a stream counts as cut off rather than as dropping
    /// frames. Chosen by hand.
    pub(crate) min_cut_frames: usize,
    /// Repeated frames that are no finding. Chosen by hand: a single one is harmless.
    pub(crate) max_repeats: usize,
    /// Frames for which all cameras stand still together in a scene that pauses; fewer are repeated
    /// frames. Chosen by hand.
    pub(crate) min_pause_frames: usize,
    /// Frames of a camera from which a rhythm of theirs is no chance. Chosen by hand.
    pub(crate) min_rhythm_frames: usize,
    /// Share of a slower camera's frames that may lie beside its rhythm, 0..=1. Chosen by hand.
    pub(crate) max_off_beat_share: f64,
    /// Share of the frames of its rhythm that a slower camera has at least, 0..=1. Chosen by hand.
    pub(crate) min_kept_share: f64,
    /// Share of frames whose depth may repeat while colour changes, 0..=1. Chosen by hand.
    pub(crate) max_unfrozen_share: f64,
    /// Frames whose depth may repeat while colour changes. Chosen by hand.
    pub(crate) max_unfrozen_frames: usize,
    /// Interval between two frames from which the second is late [nominal intervals]. Half way
    /// between a frame in time and a missing one.
    pub(crate) late_intervals: f64,
    /// Relative difference between measured and declared frame rate. Chosen so that 29.97 passes
    /// for 30 and 24 does not pass for 25.
    pub(crate) max_rate_error: f64,
    /// Skew by times from which there is a warning [frames]. More than half a frame, and another
    /// frame would fit better.
    pub(crate) max_skew_frames: f64,
    /// Skew by times from which a fit is meaningless [frames]. Chosen by hand.
    pub(crate) bad_skew_frames: f64,
}

impl Default for TimingThresholds {
    fn default() -> Self {
        Self {
            max_lost_share: 0.4,
            min_full_share: 0.7,
            min_dense_share: 0.9,
            max_closed_up_error: 0.04,
            max_closed_up: 6.0,
            min_cut_frames: 3,
            max_repeats: 1,
            min_pause_frames: 3,
            min_rhythm_frames: 6,
            max_off_beat_share: 0.05,
            min_kept_share: 0.75,
            max_unfrozen_share: 0.1,
            max_unfrozen_frames: 2,
            late_intervals: 1.5,
            max_rate_error: 0.03,
            max_skew_frames: 0.5,
            bad_skew_frames: 3.0,
        }
    }
}
