//! Motion checks of tracks: neighbours on a soft body move almost as one rigid piece.
//!
//! For every track and frame a rigid motion is fitted to its neighbours, robustly, and says where
//! the track should be. From the first frame on, a track that is far off has slipped to another
//! spot and does not count as seen. From one frame to the next, one that is off has a motion that
//! is not valid. PhysTwin compares a motion with the mean of its neighbours'; a rigid fit also
//! handles turns.

use bendtwin_core::{CancelToken, Point, settings::ingest::MotionSettings};
use bendtwin_near::PointTree;
use rayon::prelude::*;

use crate::{Error, error::check, rigid, tracks::Tracks};

/// Noise of lifted points; residuals below it say nothing [m].
const NOISE_M: f64 = 1e-3;
/// Deviations above this many times the neighbours' own are outliers.
const OUTLIER_FACTOR: f64 = 3.0;

/// The result of checking all tracks against their neighbours.
pub(crate) struct MotionCheck {
    /// Validity of the motion since the previous frame, shape [T, N].
    pub(crate) valid: Vec<bool>,
    /// Sightings, and those that were given up.
    pub(crate) seen: u64,
    pub(crate) drifted: u64,
    /// Motions between two sightings, and those that are not valid.
    pub(crate) moved: u64,
    pub(crate) unconfirmed: u64,
    /// Median residual from frame to frame [m].
    pub(crate) residual_m: f64,
    /// Sightings given up of each track, shape [N].
    pub(crate) drifts: Vec<usize>,
}

/// Checks all tracks; sightings of drifted ones are taken back.
pub(crate) fn check_motion(
    tracks: &mut Tracks,
    settings: &MotionSettings,
    cancel: &CancelToken,
) -> Result<MotionCheck, Error> {
    let neighbours = neighbours(tracks, settings);
    let count = tracks.count;
    let drifted: Vec<Vec<bool>> = (0..tracks.frames)
        .into_par_iter()
        .map(|frame| {
            let is_drifted = |i: usize| has_drifted(tracks, &neighbours[i], frame, i, settings);
            let mut row = Vec::with_capacity(count);
            for i in 0..count {
                if i % 256 == 0 {
                    check(cancel)?;
                }
                row.push(frame > 0 && tracks.is_seen(frame, i) && is_drifted(i));
            }
            Ok(row)
        })
        .collect::<Result<_, Error>>()?;
    let seen = tracks.seen.iter().filter(|s| **s).count() as u64;
    let mut drifts = vec![0; count];
    for (frame, row) in drifted.iter().enumerate() {
        for (i, _) in row.iter().enumerate().filter(|(_, d)| **d) {
            tracks.seen[frame * count + i] = false;
            drifts[i] += 1;
        }
    }
    let motions: Vec<Vec<TrackMotion>> = (0..tracks.frames)
        .into_par_iter()
        .map(|frame| {
            check(cancel)?;
            Ok((0..count).map(|i| motion(tracks, &neighbours[i], frame, i, settings)).collect())
        })
        .collect::<Result<_, Error>>()?;
    let all = || motions.iter().flatten();
    let mut residuals: Vec<f64> = all().filter_map(|j| j.residual_m).collect();
    residuals.sort_by(f64::total_cmp);
    Ok(MotionCheck {
        valid: all().map(|j| j.valid).collect(),
        seen,
        drifted: drifts.iter().sum::<usize>() as u64,
        moved: all().filter(|j| j.moved).count() as u64,
        unconfirmed: all().filter(|j| j.moved && !j.valid).count() as u64,
        residual_m: residuals.get(residuals.len() / 2).copied().unwrap_or(0.0),
        drifts,
    })
}

#[derive(Clone, Copy, Default)]
struct TrackMotion {
    /// Seen in this frame and the one before.
    moved: bool,
    valid: bool,
    residual_m: Option<f64>,
}

/// Neighbours of each track in the first frame, nearest first.
fn neighbours(tracks: &Tracks, settings: &MotionSettings) -> Vec<Vec<usize>> {
    let points = tracks.points_at(0);
    // Any number of tracks may begin in one place.
    let tree = PointTree::new(points.iter().copied());
    (0..tracks.count)
        .into_par_iter()
        .map(|i| {
            // More than are asked for, since some will be hidden.
            let wanted = 2 * settings.neighbours as usize + 1;
            let found = tree.within(points[i], settings.radius_m, wanted).into_iter();
            found.map(|near| near.number as usize).filter(|j| *j != i).collect()
        })
        .collect()
}

/// The place of a track by the motion of its neighbours, and the residual of that motion [m].
fn expected(
    tracks: &Tracks,
    neighbours: &[usize],
    from: usize,
    to: usize,
    at: Point,
    settings: &MotionSettings,
) -> Option<(Point, f64)> {
    let both = |j: &&usize| tracks.is_seen(from, **j) && tracks.is_seen(to, **j);
    let usable = neighbours.iter().filter(both).take(settings.neighbours as usize);
    let pairs: Vec<_> = usable.map(|j| (tracks.at(from, *j), tracks.at(to, *j))).collect();
    if pairs.len() < settings.min_neighbours as usize {
        return None;
    }
    let fitted = rigid::fit(&pairs, NOISE_M)?;
    Some((fitted.motion.apply(at), fitted.residual_m))
}

fn has_drifted(
    tracks: &Tracks,
    neighbours: &[usize],
    frame: usize,
    track: usize,
    settings: &MotionSettings,
) -> bool {
    let start = tracks.at(0, track);
    let Some((place, spread_m)) = expected(tracks, neighbours, 0, frame, start, settings) else {
        return false;
    };
    rigid::distance(place, tracks.at(frame, track))
        > settings.drift_m.max(OUTLIER_FACTOR * spread_m)
}

fn motion(
    tracks: &Tracks,
    neighbours: &[usize],
    frame: usize,
    track: usize,
    settings: &MotionSettings,
) -> TrackMotion {
    let Some(before) = frame.checked_sub(1) else { return TrackMotion::default() };
    if !(tracks.is_seen(before, track) && tracks.is_seen(frame, track)) {
        return TrackMotion::default();
    }
    let from = tracks.at(before, track);
    let unconfirmed = TrackMotion { moved: true, valid: false, residual_m: None };
    let Some((place, spread_m)) = expected(tracks, neighbours, before, frame, from, settings)
    else {
        return unconfirmed;
    };
    let residual = rigid::distance(place, tracks.at(frame, track));
    let valid = residual <= settings.tolerance_m.max(OUTLIER_FACTOR * spread_m);
    TrackMotion { moved: true, valid, residual_m: Some(residual) }
}

#[cfg(test)]
mod tests;
