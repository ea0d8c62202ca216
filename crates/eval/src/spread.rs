//! The spread of the predictions of several fits, beside the error of the twin that they belong to.

use bendtwin_core::{
    Graph, Point, Sequence, Twin,
    geometry::{length, sub},
    quality::SpreadScore,
    twin::spread,
};

use crate::Trajectory;

/// Multiple of the expected error that [`SpreadScore::within`] is about.
const WITHIN: f64 = 2.0;

/// Most points of a skin that are measured, evenly chosen: more would say the same.
const MOST_POINTS: usize = 2000;

/// Spread and error of a point in a frame [m].
type Pair = [f32; 2];

/// Spreads and errors of the points of several sequences.
#[derive(Default)]
pub(crate) struct SpreadErrors {
    train: Vec<Pair>,
    future: Vec<Pair>,
    fits: usize,
}

impl SpreadErrors {
    /// Adds a sequence: the prediction of a twin's nodes, and those of its members. Frames from
    /// `train_frames` on count as future.
    pub(crate) fn add(
        &mut self,
        twin: &Twin,
        sequence: &Sequence,
        own: &Trajectory,
        members: &[&Trajectory],
        train_frames: usize,
    ) {
        self.fits = self.fits.max(1 + members.len());
        let tracked: Vec<usize> = (0..twin.skin.len())
            .filter(|&point| twin.skin.observed_points[point] != Graph::NOT_OBSERVED)
            .collect();
        let apart = tracked.len().div_ceil(MOST_POINTS).max(1);
        let tracked: Vec<usize> = tracked.into_iter().step_by(apart).collect();
        let skin = twin.skin.select(&tracked);
        for frame in sequence.start_frame() + 1..sequence.frame_count {
            let at = |path: &Trajectory| path.at(frame).map(|nodes| skin.positions(nodes));
            let Some(predicted) = at(own) else { return };
            let others: Option<Vec<Vec<Point>>> = members.iter().map(|path| at(path)).collect();
            let Some(others) = others else { return };
            let others: Vec<&[Point]> = others.iter().map(Vec::as_slice).collect();
            let spreads = spread(&predicted, &others);
            let (points, visible) = (sequence.points_at(frame), sequence.visible_at(frame));
            let pairs = (0..skin.len()).filter_map(|i| {
                let observed = skin.observed_points[i] as usize;
                let seen = visible.get(observed) == Some(&true);
                let error = length(sub(predicted[i], *points.get(observed)?)) as f32;
                (seen && error.is_finite() && spreads[i].is_finite()).then_some([spreads[i], error])
            });
            if frame < train_frames { self.train.extend(pairs) } else { self.future.extend(pairs) }
        }
    }

    /// The score of all points; none if nothing was measured.
    pub(crate) fn score(&self) -> Option<SpreadScore> {
        let pairs = if self.future.is_empty() { &self.train } else { &self.future };
        let count = pairs.len() as f64;
        if self.fits < 2 || pairs.is_empty() {
            return None;
        }
        let mean = |part: usize| pairs.iter().map(|p| f64::from(p[part])).sum::<f64>() / count;
        let mut score = SpreadScore {
            fits: self.fits as u32,
            mean_m: mean(0),
            error_m: mean(1),
            within: 0.0,
            rank_correlation: rank_correlation(pairs),
        };
        let factor = score.factor().unwrap_or(0.0);
        let fits = |p: &&Pair| f64::from(p[1]) <= WITHIN * factor * f64::from(p[0]);
        score.within = pairs.iter().filter(fits).count() as f64 / count;
        Some(score)
    }
}

/// Spearman's correlation: that of the ranks; equal numbers share their mean rank.
fn rank_correlation(pairs: &[Pair]) -> Option<f64> {
    let (a, b) = (ranks(pairs, 0), ranks(pairs, 1));
    let mean = (pairs.len() as f64 - 1.0) / 2.0;
    let products = |x: &[f64], y: &[f64]| -> f64 {
        x.iter().zip(y).map(|(x, y)| (x - mean) * (y - mean)).sum()
    };
    let correlation = products(&a, &b) / (products(&a, &a) * products(&b, &b)).sqrt();
    Some(correlation).filter(|c| c.is_finite())
}

fn ranks(pairs: &[Pair], part: usize) -> Vec<f64> {
    let mut order: Vec<usize> = (0..pairs.len()).collect();
    order.sort_by(|a, b| pairs[*a][part].total_cmp(&pairs[*b][part]));
    let mut ranks = vec![0.0; pairs.len()];
    let mut first = 0;
    while first < order.len() {
        let value = pairs[order[first]][part];
        let equal = order[first..].iter().take_while(|i| pairs[**i][part] == value).count();
        let rank = first as f64 + (equal as f64 - 1.0) / 2.0;
        order[first..first + equal].iter().for_each(|i| ranks[*i] = rank);
        first += equal;
    }
    ranks
}

#[cfg(test)]
mod tests;
