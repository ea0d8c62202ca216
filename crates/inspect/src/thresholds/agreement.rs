//! Numbers for the judge of agreement between cameras.

/// Cameras that disagree, and the mistakes and corrections that explain it.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct AgreementThresholds {
    /// Frames in which cameras are compared: those with the least motion. Chosen by hand.
    pub(crate) compared_frames: usize,
    /// Misfit from which mistakes are tried, 0..=1. Healthy recordings have at most 0.017.
    pub(crate) min_suspicious_misfit: f64,
    /// Stride over surfels while mistakes are tried. Chosen by hand, to save time: every third is
    /// enough to rank them.
    pub(crate) screening_stride: usize,
    /// Share of the misfit that may remain if a mistake explains it, 0..=1. Chosen by hand.
    pub(crate) max_explained_ratio: f64,
    /// Misfit that may remain if a mistake explains it, 0..=1. Chosen by hand.
    pub(crate) max_explained_misfit: f64,
    /// Misfit that may remain if a depth scale explains it, 0..=1: then the cameras must agree about
    /// as healthy ones do. The scales of `tests/broken` leave at most 0.04, `toy_lift` has 0.04.
    pub(crate) max_scaled_misfit: f64,
    /// Misfit that a mistake or a depth scale leaves over that of the best rigid correction. One
    /// number against six: chosen by hand, a little above 1.
    pub(crate) max_rigid_ratio: f64,
    /// Shift of what a camera sees by its correction from which the camera is off [m]. Surfaces of
    /// healthy recordings lie at most 3.8 mm apart, those of the public capture `toy_lift` 1.6 mm,
    /// and no correction of them gains anything.
    pub(crate) min_off_m: f64,
    /// Share of the misfit that a correction may leave; one that leaves more gains nothing, 0..=1.
    /// Chosen by hand.
    pub(crate) max_corrected_ratio: f64,
    /// Shift from which a camera spoils a fit [m]. Chosen by hand.
    pub(crate) bad_off_m: f64,
    /// Cameras that are flagged one after another; if there were more, none could be trusted.
    /// Chosen by hand.
    pub(crate) max_flagged: usize,
    /// Misfit of a pair that is too much even if no correction is found, 0..=1. Chosen by hand;
    /// pairs of healthy recordings have at most 0.017.
    pub(crate) max_misfit: f64,
    /// Distance between the surfaces of a pair that is too much even if no correction is found [m].
    /// Chosen by hand; in healthy recordings it is at most 3.8 mm.
    pub(crate) max_disagreement_m: f64,
    /// Misfit of a pair from which the report marks it, 0..=1. Chosen by hand.
    pub(crate) fair_misfit: f64,
    /// Distance between the surfaces of a pair from which the report marks it [m]: half of
    /// `max_disagreement_m`.
    pub(crate) fair_disagreement_m: f64,
    /// Surfels that a pair must share before the distance of its surfaces counts. Chosen by hand.
    pub(crate) min_compared: usize,
    /// Misfit from which a camera without a correction is looked for among the others, 0..=1: half
    /// of `max_misfit`.
    pub(crate) min_inconsistent_misfit: f64,
    /// Share of the misfit that may remain without such a camera, 0..=1. Chosen by hand.
    pub(crate) max_without_ratio: f64,
    /// Relative error of a depth scale that is no fault. In healthy recordings at most 3 % are
    /// measured; the data sheet of the RealSense D435 promises errors below 2 % at 2 m.
    pub(crate) max_scale_error: f64,
    /// Relative error of a depth scale from which it is an error. Chosen by hand.
    pub(crate) bad_scale_error: f64,
    /// Decades by which units differ at least: powers of ten, and the inches of a metre.
    pub(crate) min_unit_log10: f64,
    /// Difference to a power of ten, or to the inches of a metre, within which a factor is that of
    /// a unit [decades]: 4.7 %. Chosen by hand, above the precision with which factors are
    /// measured.
    pub(crate) unit_log10_tolerance: f64,
}

impl Default for AgreementThresholds {
    fn default() -> Self {
        Self {
            compared_frames: 4,
            min_suspicious_misfit: 0.06,
            screening_stride: 3,
            max_explained_ratio: 0.4,
            max_explained_misfit: 0.2,
            max_scaled_misfit: 0.08,
            max_rigid_ratio: 1.15,
            min_off_m: 0.005,
            max_corrected_ratio: 0.8,
            bad_off_m: 0.025,
            max_flagged: 4,
            max_misfit: 0.3,
            max_disagreement_m: 0.012,
            fair_misfit: 0.12,
            fair_disagreement_m: 0.006,
            min_compared: 51,
            min_inconsistent_misfit: 0.15,
            max_without_ratio: 0.35,
            max_scale_error: 0.035,
            bad_scale_error: 0.04,
            min_unit_log10: 0.5,
            unit_log10_tolerance: 0.02,
        }
    }
}
