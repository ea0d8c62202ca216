//! The metrics, frame by frame and in total.
//!
//! - **Chamfer** (one-sided): mean over visible observed points of the distance to the nearest surface node, in
//!   the L1 norm as PhysTwin's script has it, and Euclidean.
//! - **Track**: mean Euclidean distance between clean tracks and the surface nodes nearest to them in the start
//!   frame. Motion capture is its own clean track: every point against its own node.
//! - **Coordinate** (motion capture, DEFORM's): mean |difference| per coordinate over all points. In total it is
//!   summed over predicted frames and divided by the number of frames of the sequence, start frames included.

use bendtwin_core::{Capture, Graph, Point, Sequence, quality::ErrorSummary};

use crate::{
    Trajectory,
    distance::{chamfer, euclidean, is_finite, nearest},
};

/// What of a sequence predictions are compared with.
pub(crate) struct Yardstick<'a> {
    sequence: &'a Sequence,
    surface_count: usize,
    /// Clean tracks: (node, track).
    tracks: Vec<(usize, usize)>,
    /// Points with their own nodes, if every point has one and the capture is motion capture.
    coordinates: Option<Vec<(usize, usize)>>,
}

impl<'a> Yardstick<'a> {
    /// For nodes that stand at `start` in the start frame, shape [N, 3].
    pub(crate) fn new(
        capture: &Capture,
        sequence: &'a Sequence,
        graph: &Graph,
        start: &[Point],
    ) -> Self {
        let surface_count = graph.surface_count();
        let surface = &start[..surface_count.min(start.len())];
        let own = own_nodes(graph, capture.object.point_count);
        let is_mocap = !capture.object.edges.is_empty() || !capture.object.pins.is_empty();
        let coordinates = own.filter(|_| is_mocap);
        let truth = sequence.truth_at(sequence.start_frame());
        let known = truth.iter().enumerate().filter(|(_, p)| is_finite(p));
        let tracks = known.filter_map(|(k, p)| Some((nearest(*p, surface)?, k))).collect();
        Self { sequence, surface_count, tracks, coordinates }
    }

    /// Errors of predicted node positions in a frame, shape [N, 3].
    pub(crate) fn measure(&self, frame: usize, nodes: &[Point]) -> ErrorSummary {
        let (points, visible) = (self.sequence.points_at(frame), self.sequence.visible_at(frame));
        let seen = |p: &usize| visible[*p] && is_finite(&points[*p]);
        let observed: Vec<Point> = (0..points.len()).filter(seen).map(|p| points[p]).collect();
        let distances = chamfer(&observed, &nodes[..self.surface_count]);
        let truth = self.sequence.truth_at(frame);
        let pairs = self.tracks.iter().filter(|(_, k)| is_finite(&truth[*k]));
        let mut track_m = mean(pairs.map(|&(n, k)| euclidean(nodes[n], truth[k])));
        let mut coordinate_m = None;
        if let Some(own) = &self.coordinates {
            let own = || own.iter().filter(|(_, p)| seen(p));
            let difference = |&(n, p): &(usize, usize)| {
                let (a, b): (Point, Point) = (nodes[n], points[p]);
                a.iter().zip(b).map(|(x, y)| f64::from((x - y).abs())).sum::<f64>() / 3.0
            };
            coordinate_m = mean(own().map(difference));
            if self.tracks.is_empty() {
                track_m = mean(own().map(|&(n, p)| euclidean(nodes[n], points[p])));
            }
        }
        ErrorSummary {
            chamfer_l1_m: distances.map(|d| d.l1_m),
            chamfer_l2_m: distances.map(|d| d.l2_m),
            track_m,
            coordinate_m,
        }
    }
}

/// Every point with the node that it is; `None` if a point has no node.
fn own_nodes(graph: &Graph, point_count: usize) -> Option<Vec<(usize, usize)>> {
    let mut own = vec![None; point_count];
    for (node, &p) in graph.observed_points.iter().enumerate() {
        if let Some(slot) = own.get_mut(p as usize) {
            *slot = Some(node);
        }
    }
    own.into_iter().enumerate().map(|(p, node)| Some((node?, p))).collect()
}

fn mean(values: impl Iterator<Item = f64>) -> Option<f64> {
    let (sum, n) = values.fold((0.0, 0_usize), |(sum, n), x| (sum + x, n + 1));
    (n > 0).then(|| sum / n as f64)
}

/// Means over frames of many sequences.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Totals {
    chamfer_l1: (f64, f64),
    chamfer_l2: (f64, f64),
    track: (f64, f64),
    coordinate: (f64, f64),
}

impl Totals {
    /// Adds the errors of consecutive frames; `divisor_frames` is what the coordinate sum is divided by.
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
        let coordinates: Vec<f64> = frames.iter().filter_map(|f| f.coordinate_m).collect();
        if !coordinates.is_empty() {
            self.coordinate.0 += coordinates.iter().sum::<f64>();
            self.coordinate.1 += divisor_frames as f64;
        }
    }

    pub(crate) fn summary(&self) -> ErrorSummary {
        let mean = |(sum, n): (f64, f64)| (n > 0.0).then(|| sum / n);
        ErrorSummary {
            chamfer_l1_m: mean(self.chamfer_l1),
            chamfer_l2_m: mean(self.chamfer_l2),
            track_m: mean(self.track),
            coordinate_m: mean(self.coordinate),
        }
    }
}

/// Errors of one predictor: training and future frames, and each frame by its distance from the start.
#[derive(Clone, Debug, Default)]
pub(crate) struct Account {
    pub(crate) train: Totals,
    pub(crate) future: Totals,
    per_frame: Vec<Totals>,
}

impl Account {
    /// Adds a sequence. With `future_only`, training frames do not count.
    pub(crate) fn add(&mut self, yardstick: &Yardstick<'_>, prediction: &Trajectory) {
        let s = yardstick.sequence;
        let first = s.start_frame() + 1;
        let errors: Vec<ErrorSummary> = (first..s.frame_count)
            .filter_map(|f| Some(yardstick.measure(f, prediction.at(f)?)))
            .collect();
        let (train, future) =
            errors.split_at(s.train_frame_count.saturating_sub(first).min(errors.len()));
        // A sequence that is not split counts with all of its frames, as in DEFORM's metric.
        let divisor = |part: &[ErrorSummary]| {
            if part.len() == errors.len() { s.frame_count } else { part.len() }
        };
        self.train.add(train, divisor(train));
        self.future.add(future, divisor(future));
        self.per_frame.resize(self.per_frame.len().max(errors.len()), Totals::default());
        for (totals, error) in self.per_frame.iter_mut().zip(&errors) {
            totals.add(std::slice::from_ref(error), 1);
        }
    }

    pub(crate) fn per_frame(&self) -> Vec<ErrorSummary> {
        self.per_frame.iter().map(Totals::summary).collect()
    }
}

#[cfg(test)]
mod tests;
