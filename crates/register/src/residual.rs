//! The distances that remain between a state and an observation.

use bendtwin_core::geometry::median;

/// Median distance from the observation that every twin may have [m].
const LEAST_EXPECTED_M: f64 = 0.005;

/// Distances between observed points and the twin: of tracks to their places, of a cloud to the
/// surface between the points of the skin.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Residual {
    /// Median [mm].
    pub median_mm: f64,
    /// Mean [mm].
    pub mean_mm: f64,
    /// 95th percentile [mm].
    pub p95_mm: f64,
}

/// Shares of an observation and of the twin that explain each other.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Explained {
    /// Share of the observed points that are within reach of the twin, 0..=1.
    pub points: f64,
    /// Share of the skin that could have been seen and has an observed point within reach, 0..=1.
    /// Tracks say nothing of the rest of the surface: there it is small for few points.
    pub surface: f64,
    /// The reach [mm].
    pub within_mm: f64,
}

impl Residual {
    /// Residual of distances [m]; zeros without distances.
    pub(crate) fn of(distances_m: &[f64]) -> Self {
        let mut sorted = distances_m.to_vec();
        let n = sorted.len();
        if n == 0 {
            return Self::default();
        }
        let mean_mm = 1e3 * sorted.iter().sum::<f64>() / n as f64;
        let median_mm = 1e3 * median(&mut sorted).unwrap_or(0.0);
        sorted.sort_by(f64::total_cmp);
        let p95_mm = 1e3 * sorted[(19 * n / 20).min(n - 1)];
        Self { median_mm, mean_mm, p95_mm }
    }
}

/// Share of the points that may be out of reach of a twin that explains them.
const TOLERATED: f64 = 0.5;

/// Median distance up to which a twin with nodes so far apart explains points with this noise [m]: half
/// the distance between neighbouring nodes, 5 mm, or the noise, whichever is most.
pub(crate) fn expected_m(spacing_m: f64, noise_m: f64) -> f64 {
    (0.5 * spacing_m).max(LEAST_EXPECTED_M).max(noise_m)
}

/// Misfit of distances [m], at most 1 if they are explained: the median over the expected distance
/// or, if larger, the share of points beyond that and beyond three deviations over [`TOLERATED`].
pub(crate) fn misfit(distances_m: &[f64], spacing_m: f64, noise_m: f64) -> f64 {
    let expected_m = expected_m(spacing_m, noise_m);
    let median_m = median(&mut distances_m.to_vec()).unwrap_or(f64::INFINITY);
    let astray = 1.0 - share_within(distances_m, expected_m.max(3.0 * noise_m));
    (median_m / expected_m).max(astray / TOLERATED)
}

/// Share of distances up to `within_m`.
pub(crate) fn share_within(distances_m: &[f64], within_m: f64) -> f64 {
    let near = distances_m.iter().filter(|d| **d <= within_m).count();
    near as f64 / distances_m.len().max(1) as f64
}
