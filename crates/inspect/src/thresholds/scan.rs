//! Numbers for measurements of a single image.

/// Masks, depth and tracks of a single image.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct ScanThresholds {
    /// Distance in depth from the middle of a surface from which a point belongs to something else,
    /// if the surface is not larger [m]. Chosen by hand.
    pub(crate) apart_m: f64,
    /// Depth below the ground from which a point is below it not by noise alone [m]. Chosen by
    /// hand, as `ScaleThresholds::below_m`.
    pub(crate) below_ground_m: f64,
    /// Share of the points at either end that do not count for extents and heights, 0..=1: flying
    /// pixels. Chosen by hand.
    pub(crate) outlier_share: f64,
    /// Distance outside a mask at which a track still counts as on it [px]. Chosen by hand:
    /// outlines of masks are good to a few pixels.
    pub(crate) track_margin_px: f64,
    /// Nearest points between hand and object whose median is their distance: one flying pixel
    /// between the two is no contact. Chosen by hand.
    pub(crate) gap_points: usize,
}

impl Default for ScanThresholds {
    fn default() -> Self {
        Self {
            apart_m: 0.15,
            below_ground_m: 0.02,
            outlier_share: 0.02,
            track_margin_px: 2.0,
            gap_points: 3,
        }
    }
}
