//! Grouping of tracks into hands: tracks of one hand are near each other and stay so.

use bendtwin_core::{DisjointSets, settings::ingest::ControlSettings};

use crate::{grid::Grid, rigid::distance, tracks::Tracks};

/// Largest change of the distance between two tracks of one hand, as a share of the gap between its
/// parts.
const MAX_STRETCH: f64 = 0.6;

/// Groups of tracks, the largest first; within a group in the order of the tracks.
pub(super) fn clusters(tracks: &Tracks, settings: &ControlSettings) -> Vec<Vec<usize>> {
    let mut sets = DisjointSets::new(tracks.count);
    let grid = Grid::of(tracks.points_at(0).iter().copied(), settings.hand_gap_m);
    for i in 0..tracks.count {
        for (_, j) in grid.within(tracks.at(0, i), settings.hand_gap_m) {
            let (a, b) = (sets.find(i as u32), sets.find(j as u32));
            if a != b && stay_together(tracks, i, j, MAX_STRETCH * settings.hand_gap_m) {
                sets.union(a, b);
            }
        }
    }
    let mut groups: Vec<Vec<usize>> = vec![Vec::new(); tracks.count];
    for (i, group) in sets.names().into_iter().enumerate() {
        groups[group as usize].push(i);
    }
    groups.retain(|g| !g.is_empty());
    groups.sort_by_key(|g| (std::cmp::Reverse(g.len()), g[0]));
    groups
}

/// True if the distance of two tracks is constant, except in a tenth of the frames.
fn stay_together(tracks: &Tracks, i: usize, j: usize, max_stretch_m: f64) -> bool {
    let start = distance(tracks.at(0, i), tracks.at(0, j));
    let both = (0..tracks.frames).filter(|f| tracks.is_seen(*f, i) && tracks.is_seen(*f, j));
    let (mut shared, mut apart) = (0, 0);
    for frame in both {
        shared += 1;
        let now = distance(tracks.at(frame, i), tracks.at(frame, j));
        apart += usize::from((now - start).abs() > max_stretch_m);
    }
    10 * apart <= shared
}
