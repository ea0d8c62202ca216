//! The metrics, frame by frame and in total, at the points of a [`Surface`].
//!
//! - **Chamfer** (one-sided): mean over visible observed points of the distance to the nearest
//!   surface point, in the L1 norm as PhysTwin's script has it, and Euclidean.
//! - **Track**: mean Euclidean distance between clean tracks and the surface points nearest to them
//!   in the start frame. Motion capture is its own clean track: every point against its own node.
//! - **Coordinate** (motion capture, DEFORM's): mean |difference| per coordinate over all points.
//!   In total it is summed over predicted frames and divided by the number of frames of the
//!   sequence, start frames included.
//! - **Padded RMS** (motion capture of cables with branches, DEFT's): root of the mean squared
//!   difference per coordinate over all branches, each filled up with zeros to the longest
//!   ([`crate::branches`]). In total the squares are summed over predicted frames and divided by
//!   the number of frames, start frames included, before the root is taken.

use bendtwin_core::{Capture, Point, Sequence, quality::ErrorSummary};

use crate::{
    Trajectory,
    branches::Branches,
    distance::{chamfer, euclidean, is_finite, nearest},
    surface::Surface,
};

/// The observations of a sequence that predictions are compared with.
pub(crate) struct Reference<'a> {
    sequence: &'a Sequence,
    /// Frames that count as training frames.
    train_frame_count: usize,
    surface_count: usize,
    /// Clean tracks: (surface point, track).
    tracks: Vec<(usize, usize)>,
    /// Predicted points with those that they are, if every point has one and the capture is motion
    /// capture.
    coordinates: Option<Vec<(usize, usize)>>,
    branches: Option<Branches>,
}

impl<'a> Reference<'a> {
    /// The reference for points that are at `start` in the start frame, shape [P, 3].
    pub(crate) fn new(
        capture: &Capture,
        sequence: &'a Sequence,
        points: &Surface,
        start: &[Point],
    ) -> Self {
        let surface_count = points.count;
        let surface = &start[..surface_count.min(start.len())];
        let own = own_points(&points.observed_points, capture.object.point_count);
        let is_mocap = !capture.object.edges.is_empty() || !capture.object.pins.is_empty();
        let coordinates = own.filter(|_| is_mocap);
        let branches = Branches::new(&capture.object.edges, capture.object.point_count);
        let truth = sequence.truth_at(sequence.start_frame());
        let known = truth.iter().enumerate().filter(|(_, p)| is_finite(p));
        let tracks = known.filter_map(|(k, p)| Some((nearest(*p, surface)?, k))).collect();
        let train_frame_count = sequence.train_frame_count;
        Self { sequence, train_frame_count, surface_count, tracks, coordinates, branches }
    }

    /// The errors with all frames as future ones: the twin was fitted without them.
    pub(crate) fn unseen(self) -> Self {
        Self { train_frame_count: 0, ..self }
    }

    /// Frames before this one count as training frames.
    pub(crate) fn train_frame_count(&self) -> usize {
        self.train_frame_count
    }

    /// Errors of predicted positions in a frame, shape [P, 3].
    pub(crate) fn measure(&self, frame: usize, predicted: &[Point]) -> ErrorSummary {
        let (points, visible) = (self.sequence.points_at(frame), self.sequence.visible_at(frame));
        let seen = |p: &usize| visible[*p] && is_finite(&points[*p]);
        let observed: Vec<Point> = (0..points.len()).filter(seen).map(|p| points[p]).collect();
        let distances = chamfer(&observed, &predicted[..self.surface_count]);
        ErrorSummary {
            chamfer_l1_m: distances.map(|d| d.l1_m),
            chamfer_l2_m: distances.map(|d| d.l2_m),
            ..self.measure_pairs(frame, predicted)
        }
    }

    /// The errors of [`Reference::measure`] between points that are known to be the same, without the
    /// search for nearest points.
    pub(crate) fn measure_pairs(&self, frame: usize, predicted: &[Point]) -> ErrorSummary {
        let (points, visible) = (self.sequence.points_at(frame), self.sequence.visible_at(frame));
        let seen = |p: &usize| visible[*p] && is_finite(&points[*p]);
        let truth = self.sequence.truth_at(frame);
        let pairs = self.tracks.iter().filter(|(_, k)| is_finite(&truth[*k]));
        let mut track_m = mean(pairs.map(|&(n, k)| euclidean(predicted[n], truth[k])));
        let (mut coordinate_m, mut padded_rms_m) = (None, None);
        if let Some(own) = &self.coordinates {
            let own = || own.iter().filter(|(_, p)| seen(p));
            let difference = |&(n, p): &(usize, usize)| {
                let (a, b): (Point, Point) = (predicted[n], points[p]);
                a.iter().zip(b).map(|(x, y)| f64::from((x - y).abs())).sum::<f64>() / 3.0
            };
            coordinate_m = mean(own().map(difference));
            if let Some(branches) = &self.branches {
                let square = |&(n, p): &(usize, usize)| {
                    (branches.memberships[p], euclidean(predicted[n], points[p]).powi(2) / 3.0)
                };
                padded_rms_m = weighted_mean(own().map(square)).map(|x| x / branches.padding);
                padded_rms_m = padded_rms_m.map(f64::sqrt);
            }
            if self.tracks.is_empty() {
                track_m = mean(own().map(|&(n, p)| euclidean(predicted[n], points[p])));
            }
        }
        ErrorSummary { track_m, coordinate_m, padded_rms_m, ..ErrorSummary::default() }
    }
}

/// Every observed point with its predicted point; `None` if some point has no counterpart.
fn own_points(observed_points: &[u32], point_count: usize) -> Option<Vec<(usize, usize)>> {
    let mut own = vec![None; point_count];
    for (own_point, &p) in observed_points.iter().enumerate() {
        if let Some(slot) = own.get_mut(p as usize) {
            *slot = Some(own_point);
        }
    }
    own.into_iter().enumerate().map(|(p, own)| Some((own?, p))).collect()
}

fn mean(values: impl Iterator<Item = f64>) -> Option<f64> {
    let (sum, n) = values.fold((0.0, 0_usize), |(sum, n), x| (sum + x, n + 1));
    (n > 0).then(|| sum / n as f64)
}

/// Mean of values, each after its weight.
fn weighted_mean(values: impl Iterator<Item = (f64, f64)>) -> Option<f64> {
    let (sum, weight) = values.fold((0.0, 0.0), |(sum, total), (w, x)| (sum + w * x, total + w));
    (weight > 0.0).then(|| sum / weight)
}

/// Means over frames of many sequences.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct ErrorSums {
    chamfer_l1: (f64, f64),
    chamfer_l2: (f64, f64),
    track: (f64, f64),
    coordinate: (f64, f64),
    /// Sums of squares.
    padded: (f64, f64),
}

impl ErrorSums {
    /// Adds the errors of consecutive frames. The sums of the metrics of motion capture are divided
    /// by `divisor_frames`.
    pub(crate) fn add(&mut self, frames: &[ErrorSummary], divisor_frames: usize) {
        for f in frames {
            let add = |to: &mut (f64, f64), x: Option<f64>| {
                if let Some(x) = x {
                    *to = (to.0 + x, to.1 + 1.0);
                }
            };
            add(&mut self.chamfer_l1, f.chamfer_l1_m);
            add(&mut self.chamfer_l2, f.chamfer_l2_m);
            add(&mut self.track, f.track_m);
        }
        let sum_up = |to: &mut (f64, f64), values: Vec<f64>| {
            if !values.is_empty() {
                *to = (to.0 + values.iter().sum::<f64>(), to.1 + divisor_frames as f64);
            }
        };
        sum_up(&mut self.coordinate, frames.iter().filter_map(|f| f.coordinate_m).collect());
        let squares = frames.iter().filter_map(|f| Some(f.padded_rms_m?.powi(2)));
        sum_up(&mut self.padded, squares.collect());
    }

    pub(crate) fn summary(&self) -> ErrorSummary {
        let mean = |(sum, n): (f64, f64)| (n > 0.0).then(|| sum / n);
        ErrorSummary {
            chamfer_l1_m: mean(self.chamfer_l1),
            chamfer_l2_m: mean(self.chamfer_l2),
            track_m: mean(self.track),
            coordinate_m: mean(self.coordinate),
            padded_rms_m: mean(self.padded).map(f64::sqrt),
        }
    }
}

/// Errors of one predictor: training and future frames, and each frame by its distance from the
/// start.
#[derive(Clone, Debug, Default)]
pub(crate) struct PredictorErrors {
    pub(crate) train: ErrorSums,
    pub(crate) future: ErrorSums,
    per_frame: Vec<ErrorSums>,
}

impl PredictorErrors {
    /// Adds a sequence. With `future_only`, training frames do not count.
    pub(crate) fn add(&mut self, reference: &Reference<'_>, prediction: &Trajectory) {
        let s = reference.sequence;
        let first = s.start_frame() + 1;
        let errors: Vec<ErrorSummary> = (first..s.frame_count)
            .filter_map(|f| Some(reference.measure(f, prediction.at(f)?)))
            .collect();
        let (train, future) =
            errors.split_at(reference.train_frame_count.saturating_sub(first).min(errors.len()));
        // A sequence that is not split counts with all of its frames, as in DEFORM's and DEFT's
        // metrics.
        let divisor = |part: &[ErrorSummary]| {
            if part.len() == errors.len() { s.frame_count } else { part.len() }
        };
        self.train.add(train, divisor(train));
        self.future.add(future, divisor(future));
        self.per_frame.resize(self.per_frame.len().max(errors.len()), ErrorSums::default());
        for (sums, error) in self.per_frame.iter_mut().zip(&errors) {
            sums.add(std::slice::from_ref(error), 1);
        }
    }

    pub(crate) fn per_frame(&self) -> Vec<ErrorSummary> {
        self.per_frame.iter().map(ErrorSums::summary).collect()
    }
}

#[cfg(test)]
mod tests;
