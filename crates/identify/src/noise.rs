//! The residual of the training frames as noise: how large it is, and how many independent observations
//! it leaves. A model that is wrong by a little is wrong by about the same in the next frame and at the
//! neighbouring point, so that thousands of coordinates say as much as some tens.

use bendtwin_core::{
    Point,
    geometry::{sub, wide},
};

/// Least standard deviation of a coordinate [m]: what a depth camera leaves.
const LEAST_M: f64 = 0.001;
/// Correlation below which two frames count as independent.
const LEAST_CORRELATION: f64 = 0.05;
/// Frames that the correlation of points is measured over.
const MOST_FRAMES: usize = 40;

/// The residual of a recording.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Noise {
    /// Standard deviation of a coordinate [m].
    pub(crate) sd_m: f64,
    /// Frames that count as one.
    pub(crate) frames: f64,
    /// Points that would be independent.
    pub(crate) points: f64,
}

/// Residuals of points in a frame [m]; none where a point was not seen.
pub(crate) type Residuals = Vec<Option<[f64; 3]>>;

/// The residual of a point.
pub(crate) fn residual(predicted: Point, observed: Point) -> [f64; 3] {
    sub(wide(predicted), wide(observed))
}

impl Noise {
    /// Noise of residuals frame by frame, of the same points in each; `None` without residuals.
    pub(crate) fn of(frames: &[Residuals]) -> Option<Self> {
        let all = || frames.iter().flatten().flatten().flatten();
        let count = all().count();
        if count == 0 {
            return None;
        }
        let variance = all().map(|x| x * x).sum::<f64>() / count as f64;
        // A fit that is nearer than a camera sees has the camera's noise beside its own.
        let white = (LEAST_M * LEAST_M - variance).max(0.0);
        Some(Self {
            sd_m: (variance + white).sqrt(),
            frames: correlation_time(frames, white),
            points: independent_points(frames, white),
        })
    }

    /// Weight of a coordinate where `samples` frames of `points` points stand for `frames` frames: one over
    /// its variance, less what correlation takes.
    pub(crate) fn weight(&self, frames: usize, samples: usize, points: usize) -> f64 {
        let in_time = (frames as f64 / self.frames).max(1.0) / samples.max(1) as f64;
        let in_space = (self.points / points.max(1) as f64).min(1.0);
        in_time * in_space / (self.sd_m * self.sd_m)
    }

    /// Independent observations of a recording of `frames` frames.
    pub(crate) fn observations(&self, frames: usize) -> f64 {
        3.0 * self.points * (frames as f64 / self.frames).max(1.0)
    }
}

/// Integrated time of the residuals' autocorrelation about zero [frames], 1 or more: an offset that
/// lasts counts once. `white` is the variance of independent noise beside them [m²].
fn correlation_time(frames: &[Residuals], white: f64) -> f64 {
    let length = frames.len();
    let product = |lag: usize| {
        let (mut sum, mut count) = (0.0, 0);
        for (now, later) in frames.iter().zip(&frames[lag..]) {
            for (a, b) in now.iter().zip(later) {
                if let (Some(a), Some(b)) = (a, b) {
                    sum += a.iter().zip(b).map(|(x, y)| x * y).sum::<f64>();
                    count += 1;
                }
            }
        }
        sum / f64::from(count.max(1))
    };
    let square = product(0) + 3.0 * white;
    if square <= 0.0 {
        return 1.0;
    }
    let correlations = (1..length).map(|lag| product(lag) / square);
    let lasting = correlations.take_while(|c| *c > LEAST_CORRELATION);
    let time = 1.0 + 2.0 * lasting.sum::<f64>();
    time.min(length as f64)
}

/// Number of independent points: the participation ratio of the eigenvalues of the residuals'
/// covariance over points, tr² / tr(C²), with noise of the variance `white` beside them [m²].
fn independent_points(frames: &[Residuals], white: f64) -> f64 {
    let stride = frames.len().div_ceil(MOST_FRAMES).max(1);
    let chosen: Vec<&Residuals> = frames.iter().step_by(stride).collect();
    let along = |frame: &Residuals, axis: usize| -> Vec<f64> {
        frame.iter().map(|r| r.map_or(0.0, |r| r[axis])).collect()
    };
    let rows: Vec<Vec<f64>> =
        chosen.iter().flat_map(|f| (0..3).map(|axis| along(f, axis))).collect();
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(x, y)| x * y).sum::<f64>();
    let count = rows.first().map_or(0, Vec::len) as f64;
    let noise = white * rows.len() as f64;
    let of_residuals: f64 = rows.iter().map(|r| dot(r, r)).sum();
    let trace = of_residuals + count * noise;
    let squares: f64 = rows.iter().flat_map(|a| rows.iter().map(|b| dot(a, b).powi(2))).sum();
    let squares = squares + 2.0 * noise * of_residuals + count * noise * noise;
    if squares > 0.0 { trace * trace / squares } else { 1.0 }
}

#[cfg(test)]
mod tests;
