//! Numbers for the misfit between views, and for its explanations.

use std::ops::Range;

/// Surfels that are compared, and the differences that contradict.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct ConsistencyThresholds {
    /// Surfels of each crop that are compared. Chosen by hand, to save time.
    pub(crate) max_surfels: usize,
    /// Most surfels where there are many cameras, whose pairs grow with the square.
    pub(crate) max_surfels_many_cameras: usize,
    /// With more cameras than this, fewer surfels are compared.
    pub(crate) many_cameras: usize,
    /// Share of surfels with a normal below which the object is a thread, and surfels without are
    /// taken too, 0..=1. Chosen by hand.
    pub(crate) min_normal_share: f64,
    /// Distance outside a mask at which a surfel may appear [px]. Chosen by hand: outlines of masks
    /// are good to a few pixels.
    pub(crate) mask_margin_px: f64,
    /// Depths that differ by more contradict each other entirely [m]. Chosen by hand.
    pub(crate) max_apart_m: f64,
    /// Distance in front of the other camera's surface from which a surfel should have hidden it
    /// [m]; a share of the depth is added. Chosen by hand.
    pub(crate) occlusion_m: f64,
    /// The share of the depth that is added: the noise of depth cameras grows with distance. Chosen
    /// by hand.
    pub(crate) occlusion_depth_share: f64,
    /// Least cosine between a normal and the direction to a camera that faces the surface: 63
    /// degrees. Chosen by hand: depth of surfaces that are seen more obliquely is poor.
    pub(crate) min_facing_cosine: f64,
    /// Least cosine between the two cameras' normals of one surfel, for a correction: 53 degrees.
    /// Chosen by hand.
    pub(crate) min_normal_cosine: f64,
    /// Least correspondences for the six unknowns of a correction. Ten for each.
    pub(crate) min_matches: usize,
    /// Distance at which a correspondence has no weight in the last iteration of a correction [m];
    /// in the first it is `max_apart_m`. Chosen by hand.
    pub(crate) end_reach_m: f64,
    /// Misfit of a mistake over that of a simpler one from which it is preferred. Chosen by hand,
    /// so that noise does not choose.
    pub(crate) better_ratio: f64,
    /// Misfit by which another depth scale must be better than the declared one. Chosen by hand, so
    /// that noise does not choose.
    pub(crate) min_scale_gain: f64,
    /// Factors of depth that may be an error of scale; others are other units.
    pub(crate) same_unit: Range<f64>,
}

impl Default for ConsistencyThresholds {
    fn default() -> Self {
        Self {
            max_surfels: 900,
            max_surfels_many_cameras: 200,
            many_cameras: 6,
            min_normal_share: 0.25,
            mask_margin_px: 3.0,
            max_apart_m: 0.05,
            occlusion_m: 0.012,
            occlusion_depth_share: 0.01,
            min_facing_cosine: 0.45,
            min_normal_cosine: 0.6,
            min_matches: 60,
            end_reach_m: 0.012,
            better_ratio: 0.97,
            min_scale_gain: 1e-3,
            same_unit: 0.5..2.0,
        }
    }
}
