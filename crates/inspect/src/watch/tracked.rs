//! How 2D tracks lie in one image.

use bendtwin_capture::raw::{DepthImage, Mask, Tracks};

/// A track may miss a mask's rim by this [px].
const RIM_PX: f64 = 2.0;

/// Counts of one frame's tracks.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Tracked {
    /// Tracks that the tracker saw.
    pub(crate) visible: usize,
    /// Of these, how many are not finite.
    pub(crate) not_finite: usize,
    /// Of the visible, how many lie on a mask, if there are masks.
    pub(crate) inside: usize,
    /// How many would lie on a mask if x and y were exchanged.
    pub(crate) inside_transposed: usize,
    /// Of those inside, how many have depth.
    pub(crate) with_depth: usize,
    /// Whether there was a mask to compare with.
    pub(crate) compared: bool,
}

pub(crate) fn look(
    tracks: &Tracks,
    frame: usize,
    masks: [Option<&Mask>; 2],
    depth: Option<&DepthImage>,
) -> Tracked {
    let from = frame.saturating_mul(tracks.count);
    let range = from..from.saturating_add(tracks.count);
    let (Some(points), Some(visible)) =
        (tracks.points.get(range.clone()), tracks.visible.get(range))
    else {
        return Tracked::default();
    };
    let mut count = Tracked { compared: masks.iter().any(Option::is_some), ..Tracked::default() };
    for (point, _) in points.iter().zip(visible).filter(|(_, v)| **v) {
        count.visible += 1;
        let [x, y] = point.map(f64::from);
        if !(x.is_finite() && y.is_finite()) {
            count.not_finite += 1;
            continue;
        }
        count.inside_transposed += usize::from(is_on(masks, [y, x]));
        if is_on(masks, [x, y]) {
            count.inside += 1;
            let metres = depth.and_then(|d| at(d, [x, y])).unwrap_or(0.0);
            count.with_depth += usize::from(metres > 0.0);
        }
    }
    count
}

fn is_on(masks: [Option<&Mask>; 2], [x, y]: [f64; 2]) -> bool {
    const AROUND: [[f64; 2]; 5] = [[0.0, 0.0], [-1.0, 0.0], [1.0, 0.0], [0.0, -1.0], [0.0, 1.0]];
    masks.into_iter().flatten().any(|mask| {
        AROUND.iter().any(|[dx, dy]| at(mask, [x + dx * RIM_PX, y + dy * RIM_PX]) == Some(true))
    })
}

fn at<P: Copy>(image: &bendtwin_capture::raw::Image<P>, [x, y]: [f64; 2]) -> Option<P> {
    let (x, y) = (x.round(), y.round());
    (x >= 0.0 && y >= 0.0).then(|| image.get(x as usize, y as usize))?
}
