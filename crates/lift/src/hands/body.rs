//! A hand as a rigid body: its shape from all frames, its pose in each.

use bendtwin_core::{Point, settings::ingest::ControlSettings};

use super::MIN_TRACKS;
use crate::{
    evidence::HandEvidence,
    rigid::{self, Rigid, distance},
    tracks::Tracks,
};

/// Residuals of lifted tracks below this are noise [m].
const NOISE_M: f64 = 1e-3;
/// Number of times that shape and poses are fitted to each other.
const ROUNDS: usize = 3;

/// A fitted hand.
pub(super) struct Body<'a> {
    tracks: &'a Tracks,
    settings: &'a ControlSettings,
    /// Places of the tracks on the body [m], shape [N].
    shape: Vec<Point>,
    /// Shape [T].
    poses: Vec<Rigid>,
    filled_frames: usize,
    /// Longest run of frames that were filled in.
    longest_gap: usize,
    /// Median residual of each track [m], shape [N].
    residuals_m: Vec<f64>,
    residual_m: f64,
    residual_p95_m: f64,
}

impl<'a> Body<'a> {
    /// Fits a hand's tracks; `None` if its pose is known in no frame.
    pub(super) fn fit(tracks: &'a Tracks, settings: &'a ControlSettings) -> Option<Self> {
        let mut shape = tracks.points_at(0).to_vec();
        let mut poses = poses_of(tracks, &shape);
        for _ in 1..ROUNDS {
            shape = shape_of(tracks, &poses, &shape);
            poses = poses_of(tracks, &shape);
        }
        let filled_frames = poses.iter().filter(|p| p.is_none()).count();
        let (poses, longest_gap) = fill(poses, &shape)?;
        let mut body = Self {
            tracks,
            settings,
            shape,
            poses,
            filled_frames,
            longest_gap,
            residuals_m: Vec::new(),
            residual_m: 0.0,
            residual_p95_m: 0.0,
        };
        let mut all = Vec::new();
        for i in 0..tracks.count {
            let mut own: Vec<f64> = (0..tracks.frames)
                .filter(|f| tracks.is_seen(*f, i))
                .map(|f| distance(body.poses[f].apply(body.shape[i]), tracks.at(f, i)))
                .collect();
            all.extend_from_slice(&own);
            own.sort_by(f64::total_cmp);
            body.residuals_m.push(own.get(own.len() / 2).copied().unwrap_or(f64::INFINITY));
        }
        all.sort_by(f64::total_cmp);
        body.residual_m = all.get(all.len() / 2).copied().unwrap_or(0.0);
        body.residual_p95_m = all.get(all.len() * 95 / 100).copied().unwrap_or(0.0);
        Some(body)
    }

    pub(super) fn longest_gap(&self) -> usize {
        self.longest_gap
    }

    pub(super) fn is_rigid(&self) -> bool {
        self.residual_m <= self.settings.rigid_m
    }

    pub(super) fn residual_m(&self) -> f64 {
        self.residual_m
    }

    pub(super) fn evidence(&self) -> HandEvidence {
        HandEvidence {
            residual_m: self.residual_m,
            residual_p95_m: self.residual_p95_m,
            rigid: self.is_rigid(),
            filled_frames: self.filled_frames,
            ..HandEvidence::default()
        }
    }

    /// Tracks that move rigidly with the body, those seen most often first; never none.
    pub(super) fn rigid_tracks(&self) -> Vec<usize> {
        let survival = self.tracks.survival();
        let limit = 3.0 * self.residual_m.max(NOISE_M);
        let mut rigid: Vec<usize> =
            (0..self.tracks.count).filter(|i| self.residuals_m[*i] <= limit).collect();
        rigid.sort_by_key(|i| (std::cmp::Reverse(survival[*i]), *i));
        // Seen at least half as often as the best: the places of rarely seen ones are badly known.
        let most = rigid.first().map_or(0, |i| survival[*i]);
        rigid.retain(|i| 2 * survival[*i] >= most);
        rigid
    }

    /// Rigid tracks without a gap longer than the settings allow.
    pub(super) fn surviving(&self) -> Vec<usize> {
        let short =
            |i: &usize| longest_gap(self.tracks, *i) <= self.settings.max_gap_frames as usize;
        let mut surviving = self.rigid_tracks();
        surviving.retain(short);
        surviving
    }

    /// The place of a track in the first frame [m].
    pub(super) fn start(&self, track: usize) -> Point {
        self.poses[0].apply(self.shape[track])
    }

    /// A place in the first frame that moves with the body, in every frame, shape [T].
    pub(super) fn carried(&self, start: Point) -> Vec<Point> {
        let place = self.poses[0].inverse().apply(start);
        self.poses.iter().map(|p| p.apply(place)).collect()
    }

    /// A control point in every frame, shape [T].
    pub(super) fn trajectory(&self, track: usize) -> Vec<Point> {
        let rigid: Vec<Point> = self.poses.iter().map(|p| p.apply(self.shape[track])).collect();
        if self.is_rigid() {
            return rigid;
        }
        // What is seen counts; between sightings the body's motion plus the drift from it, which
        // changes evenly.
        let mut own = rigid.clone();
        let mut last = 0;
        let drift = |f: usize| -> [f32; 3] {
            let at = self.tracks.at(f, track);
            std::array::from_fn(|i| at[i] - rigid[f][i])
        };
        for frame in (0..self.tracks.frames).filter(|f| self.tracks.is_seen(*f, track)) {
            let (a, b) = (drift(last), drift(frame));
            for between in last..=frame {
                let share = (between - last) as f32 / (frame - last).max(1) as f32;
                own[between] =
                    std::array::from_fn(|i| rigid[between][i] + a[i] + share * (b[i] - a[i]));
            }
            last = frame;
        }
        let end = drift(last);
        for frame in last..self.tracks.frames {
            own[frame] = std::array::from_fn(|i| rigid[frame][i] + end[i]);
        }
        own
    }
}

fn poses_of(tracks: &Tracks, shape: &[Point]) -> Vec<Option<Rigid>> {
    let pose = |frame: usize| {
        let seen = (0..tracks.count).filter(|i| tracks.is_seen(frame, *i));
        let pairs: Vec<_> = seen.map(|i| (shape[i], tracks.at(frame, i))).collect();
        if pairs.len() < MIN_TRACKS {
            return None;
        }
        rigid::fit(&pairs, NOISE_M).map(|f| f.motion)
    };
    (0..tracks.frames).map(pose).collect()
}

/// Each track's place on the body: the median over the frames in which it is seen.
fn shape_of(tracks: &Tracks, poses: &[Option<Rigid>], before: &[Point]) -> Vec<Point> {
    let back: Vec<Option<Rigid>> = poses.iter().map(|p| p.as_ref().map(Rigid::inverse)).collect();
    let place = |i: usize| {
        let seen = (0..tracks.frames).filter(|f| tracks.is_seen(*f, i));
        let places: Vec<Point> =
            seen.filter_map(|f| back[f].as_ref().map(|b| b.apply(tracks.at(f, i)))).collect();
        if places.is_empty() {
            return before[i];
        }
        std::array::from_fn(|axis| {
            let mut values: Vec<f32> = places.iter().map(|p| p[axis]).collect();
            let middle = values.len() / 2;
            *values.select_nth_unstable_by(middle, f32::total_cmp).1
        })
    };
    (0..tracks.count).map(place).collect()
}

/// Puts poses into gaps: between the poses around, or the nearest one; and the length of the longest
/// gap. `None` if there is no pose.
pub(super) fn fill(poses: Vec<Option<Rigid>>, shape: &[Point]) -> Option<(Vec<Rigid>, usize)> {
    let mut longest = 0;
    let count = shape.len().max(1) as f32;
    let pivot = std::array::from_fn(|i| shape.iter().map(|p| p[i]).sum::<f32>() / count);
    let mut filled: Vec<Rigid> = Vec::with_capacity(poses.len());
    let mut frame = 0;
    while frame < poses.len() {
        if let Some(pose) = poses[frame] {
            filled.push(pose);
            frame += 1;
            continue;
        }
        let gap = poses[frame..].iter().take_while(|p| p.is_none()).count();
        let (before, after) = (filled.last().copied(), poses.get(frame + gap).copied().flatten());
        let first = before.or(after)?;
        longest = longest.max(gap);
        let next = after.unwrap_or(first);
        for step in 1..=gap {
            let share = step as f64 / (gap + 1) as f64;
            filled.push(first.between(&next, share, pivot));
        }
        frame += gap;
    }
    Some((filled, longest))
}

fn longest_gap(tracks: &Tracks, track: usize) -> usize {
    let (mut longest, mut current) = (0, 0);
    for frame in 0..tracks.frames {
        current = if tracks.is_seen(frame, track) { 0 } else { current + 1 };
        longest = longest.max(current);
    }
    longest
}
