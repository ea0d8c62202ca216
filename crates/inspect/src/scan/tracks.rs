//! Counts of 2D tracks in one image: on the masks, with depth, not finite.

use bendtwin_capture::raw::{DepthImage, Mask, Tracks};

/// Counts of one frame's tracks.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct TrackCounts {
    /// Tracks that the tracker saw.
    pub(crate) visible: usize,
    /// Visible tracks that are not finite.
    pub(crate) not_finite: usize,
    /// Visible tracks that lie on a mask, if there are masks.
    pub(crate) inside: usize,
    /// Visible tracks that would lie on a mask if x and y were exchanged.
    pub(crate) inside_transposed: usize,
    /// Tracks on the object's mask, and not on the manipulator's, with depth.
    pub(crate) on_object: usize,
    /// Tracks on a mask with depth.
    pub(crate) with_depth: usize,
    /// True if there was a mask to compare with.
    pub(crate) compared: bool,
}

/// Counts the tracks of a frame against its masks and depth.
pub(crate) fn count(
    tracks: &Tracks,
    frame: usize,
    masks: [Option<&Mask>; 2],
    depth: Option<&DepthImage>,
    margin_px: f64,
) -> TrackCounts {
    let from = frame.saturating_mul(tracks.count);
    let range = from..from.saturating_add(tracks.count);
    let (Some(points), Some(visible)) =
        (tracks.points.get(range.clone()), tracks.visible.get(range))
    else {
        return TrackCounts::default();
    };
    let mut counts =
        TrackCounts { compared: masks.iter().any(Option::is_some), ..TrackCounts::default() };
    for (point, _) in points.iter().zip(visible).filter(|(_, v)| **v) {
        counts.visible += 1;
        let [x, y] = point.map(f64::from);
        if !(x.is_finite() && y.is_finite()) {
            counts.not_finite += 1;
            continue;
        }
        counts.inside_transposed += usize::from(is_on(masks, [y, x], margin_px));
        if is_on(masks, [x, y], margin_px) {
            counts.inside += 1;
            let metres = depth.and_then(|d| at(d, [x, y])).unwrap_or(0.0);
            counts.with_depth += usize::from(metres > 0.0);
            let shown = masks.map(|mask| mask.and_then(|m| at(m, [x, y])) == Some(true));
            counts.on_object += usize::from(metres > 0.0 && shown == [true, false]);
        }
    }
    counts
}

fn is_on(masks: [Option<&Mask>; 2], [x, y]: [f64; 2], margin_px: f64) -> bool {
    const AROUND: [[f64; 2]; 5] = [[0.0, 0.0], [-1.0, 0.0], [1.0, 0.0], [0.0, -1.0], [0.0, 1.0]];
    masks.into_iter().flatten().any(|mask| {
        AROUND
            .iter()
            .any(|[dx, dy]| at(mask, [x + dx * margin_px, y + dy * margin_px]) == Some(true))
    })
}

fn at<P: Copy>(image: &bendtwin_capture::raw::Image<P>, [x, y]: [f64; 2]) -> Option<P> {
    let (x, y) = (x.round(), y.round());
    (x >= 0.0 && y >= 0.0).then(|| image.get(x as usize, y as usize))?
}
