//! Score of lifted tracks: their distance from clean ones.

use bendtwin_core::Sequence;
use serde::{Deserialize, Serialize};

use crate::rigid::distance;

/// A sequence's tracked points beside its clean tracks.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Score {
    /// Tracked points of the sequence.
    pub points: usize,
    /// Clean tracks that were compared.
    pub truth_tracks: usize,
    /// Median distance of a clean track from the tracked point that stands for it, in the first
    /// frame [m].
    pub start_m: f64,
    /// Pairs of clean track and frame that were compared: those in which the tracked point is seen.
    pub compared: usize,
    /// Median distance over these [m].
    pub median_m: f64,
    /// 90th percentile of it [m].
    pub p90_m: f64,
    /// 99th percentile of it [m].
    pub p99_m: f64,
}

/// Compares each clean track with the tracked point that is nearest to it in the first frame, over
/// the frames in which that point is seen. `None` without clean tracks, or if no point is seen in
/// the first frame.
pub fn score(sequence: &Sequence) -> Option<Score> {
    if sequence.frame_count == 0 || sequence.truth_count() == 0 {
        return None;
    }
    let seen = sequence.visible_at(0);
    let (mut starts, mut distances) = (Vec::new(), Vec::new());
    for (track, start) in sequence.truth_at(0).iter().enumerate() {
        if !start.iter().all(|x| x.is_finite()) {
            continue;
        }
        let points = sequence.points_at(0).iter().enumerate().filter(|(i, _)| seen[*i]);
        let near = points.map(|(i, p)| (distance(*p, *start), i));
        let (off, point) = near.min_by(|a, b| a.0.total_cmp(&b.0))?;
        starts.push(off);
        for frame in 0..sequence.frame_count {
            let truth = sequence.truth_at(frame)[track];
            if sequence.visible_at(frame)[point] && truth.iter().all(|x| x.is_finite()) {
                distances.push(distance(sequence.points_at(frame)[point], truth));
            }
        }
    }
    starts.sort_by(f64::total_cmp);
    distances.sort_by(f64::total_cmp);
    let at = |values: &[f64], share: usize| {
        values.get((values.len() * share / 100).min(values.len().checked_sub(1)?)).copied()
    };
    Some(Score {
        points: seen.len(),
        truth_tracks: starts.len(),
        start_m: at(&starts, 50)?,
        compared: distances.len(),
        median_m: at(&distances, 50)?,
        p90_m: at(&distances, 90)?,
        p99_m: at(&distances, 99)?,
    })
}

#[cfg(test)]
mod tests;
