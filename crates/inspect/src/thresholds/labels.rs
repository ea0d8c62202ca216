//! Numbers for the judge of exchanged masks.

/// Masks of object and hand that are exchanged.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct LabelThresholds {
    /// Surfels that two cameras must share before their labels are compared. Chosen by hand.
    pub(crate) min_surfels: usize,
    /// Share of the shared surfels to which two cameras may give different labels, 0..=1. The
    /// majority decides.
    pub(crate) max_different_share: f64,
    /// Size of the hand over that of the object from which the hand is taken for the object, in all
    /// cameras. Chosen by hand.
    pub(crate) min_size_ratio: f64,
    /// Height of the object's lowest point over that of the hand's, from which the same [m]. Chosen
    /// by hand.
    pub(crate) min_height_m: f64,
}

impl Default for LabelThresholds {
    fn default() -> Self {
        Self { min_surfels: 40, max_different_share: 0.5, min_size_ratio: 1.6, min_height_m: 0.02 }
    }
}
