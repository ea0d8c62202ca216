//! Grouping of tracks into hands: tracks of one hand are near each other and stay so.

use bendtwin_core::settings::ingest::ControlSettings;

use crate::{grid::Grid, rigid::distance, tracks::Tracks};

/// Largest change of the distance between two tracks of one hand, as a share of the gap between its
/// parts.
const MAX_STRETCH: f64 = 0.6;

/// Groups of tracks, the largest first; within a group in the order of the tracks.
pub(super) fn clusters(tracks: &Tracks, settings: &ControlSettings) -> Vec<Vec<usize>> {
    let mut parent: Vec<usize> = (0..tracks.count).collect();
    let grid = Grid::of(tracks.points_at(0).iter().copied(), settings.hand_gap_m);
    for i in 0..tracks.count {
        for (_, j) in grid.within(tracks.at(0, i), settings.hand_gap_m) {
            let (a, b) = (root(&mut parent, i), root(&mut parent, j));
            if a != b && stay_together(tracks, i, j, MAX_STRETCH * settings.hand_gap_m) {
                parent[a.max(b)] = a.min(b);
            }
        }
    }
    let mut groups: Vec<Vec<usize>> = vec![Vec::new(); tracks.count];
    for i in 0..tracks.count {
        let root = root(&mut parent, i);
        groups[root].push(i);
    }
    groups.retain(|g| !g.is_empty());
    groups.sort_by_key(|g| (std::cmp::Reverse(g.len()), g[0]));
    groups
}

fn root(parent: &mut [usize], mut i: usize) -> usize {
    while parent[i] != i {
        parent[i] = parent[parent[i]];
        i = parent[i];
    }
    i
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
