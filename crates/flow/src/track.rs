//! A tracked point, and its neighbours.

use bendtwin_capture::raw::Region;
use bendtwin_core::Point;
use nalgebra::Matrix3;

use crate::{
    FlowSettings,
    appearance::Appearance,
    motion::{Motion, Pair, distance, rigid},
};

/// A point that one camera follows.
#[derive(Clone, Debug)]
pub(crate) struct Track {
    /// Index of its camera.
    pub(crate) camera: usize,
    pub(crate) region: Region,
    /// Frame in which it was seeded.
    pub(crate) first_frame: usize,
    /// Place in the world in that frame [m].
    pub(crate) seed_point: Point,
    /// Other tracks seeded near it in the same frame, by any camera.
    pub(crate) neighbours: Vec<u32>,
    /// Appearance when the track was seeded.
    pub(crate) first: Appearance,
    /// Appearance when the first one no longer matched.
    pub(crate) recent: Option<Appearance>,
    /// Rotation of its surroundings since it was seeded.
    pub(crate) rotation: Matrix3<f64>,
    /// Column and row, when it was last seen.
    pub(crate) at: [f64; 2],
    /// Place in the world, when it was last seen [m].
    pub(crate) point: Point,
    /// Motion from frame to frame, when it was last seen [m].
    pub(crate) velocity: [f64; 3],
    /// True if it was seen in its camera's last frame.
    pub(crate) seen: bool,
}

/// Joins each of the tracks from `first` on, all seeded in one frame, with neighbours among them:
/// of those of the same region within the radius, a subset with the same spread.
pub(crate) fn join(tracks: &mut [Track], first: usize, settings: &FlowSettings) {
    let radius = settings.neighbour_radius_m;
    let joined: Vec<Vec<u32>> = (first..tracks.len())
        .map(|i| {
            let here = &tracks[i];
            let mut near: Vec<(f64, usize)> = (first..tracks.len())
                .filter(|&j| j != i && tracks[j].region == here.region)
                .map(|j| (distance(here.seed_point, tracks[j].seed_point), j))
                .filter(|(distance, _)| *distance < radius)
                .collect();
            near.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
            let kept = near.len().min(settings.neighbours);
            (0..kept).map(|k| near[k * near.len() / kept].1 as u32).collect()
        })
        .collect();
    for (track, neighbours) in tracks[first..].iter_mut().zip(joined) {
        track.neighbours = neighbours;
    }
}

/// Least neighbours that can outvote a wrong one.
const MIN_NEIGHBOURS: usize = 4;
/// Number of tracks that stand in for neighbours that are not seen.
const MAX_SUBSTITUTES: usize = 12;

impl Track {
    /// The rigid motion of its neighbours since seeding; `now` has the place of every track that is
    /// seen. If too few of them are, the nearest that are seen stand in for them, so that a place
    /// that was hidden as a whole can be found again.
    pub(crate) fn motion(
        &self,
        tracks: &[Track],
        now: &[Option<Point>],
        settings: &FlowSettings,
    ) -> Option<Motion> {
        let pair = |j: usize| {
            let before = tracks[j].seed_point;
            Some((distance(before, self.seed_point), before, now[j]?))
        };
        let mut pairs: Vec<_> = self.neighbours.iter().filter_map(|&j| pair(j as usize)).collect();
        let mut spread = 0.5 * settings.neighbour_radius_m;
        if pairs.len() < MIN_NEIGHBOURS {
            pairs = (0..tracks.len())
                .filter(|&j| {
                    tracks[j].region == self.region && tracks[j].first_frame == self.first_frame
                })
                .filter(|&j| !std::ptr::eq(self, &tracks[j]))
                .filter_map(pair)
                .collect();
            pairs.sort_by(|a, b| a.0.total_cmp(&b.0));
            pairs.truncate(MAX_SUBSTITUTES);
            spread = spread.max(pairs.first().map_or(0.0, |nearest| nearest.0));
        }
        let weight = |far: f64| (-0.5 * (far / spread).powi(2)).exp();
        let pairs: Vec<Pair> = pairs
            .into_iter()
            .map(|(far, before, after)| Pair { before, after, weight: weight(far) })
            .collect();
        rigid(&pairs, &self.rotation)
    }
}
