//! What other cameras say about a point in space.

use bendtwin_capture::raw::Region;
use bendtwin_core::Point;

use crate::{appearance::Glimpse, track::Track};

/// A mask's outline is believed to this many pixels.
const OUTLINE_PX: usize = 3;

/// More than this share of points contradicted when they are seeded: a camera stands elsewhere than its calibration says,
/// or shows another moment.
const UNFIT: f64 = 0.3;

/// Which cameras are asked about the points of which.
#[derive(Clone, Debug)]
pub(crate) struct Witnesses {
    /// Pairs of a camera and another that is unfit to judge its points.
    unfit: Vec<(usize, usize)>,
    cameras: usize,
}

impl Witnesses {
    /// All others.
    pub(crate) fn new(cameras: usize) -> Self {
        Self { unfit: Vec::new(), cameras }
    }

    /// The cameras that are asked about the points of `camera`.
    pub(crate) fn of(&self, camera: usize) -> impl Iterator<Item = usize> {
        (0..self.cameras).filter(move |&c| c != camera && !self.unfit.contains(&(camera, c)))
    }

    /// The cameras that are not asked about them.
    pub(crate) fn unfit_for(&self, camera: usize) -> Vec<usize> {
        self.unfit.iter().filter(|pair| pair.0 == camera).map(|pair| pair.1).collect()
    }

    /// Asks all others about the points of a camera that were just seeded; from then on those that contradict too many are
    /// not asked again.
    pub(crate) fn examine(
        &mut self,
        camera: usize,
        tracks: &[Track],
        now: &[Option<Glimpse<'_>>],
        tolerance_m: f64,
    ) {
        let mine: Vec<&Track> =
            tracks.iter().filter(|t| t.camera == camera && t.region == Region::Object).collect();
        for other in (0..self.cameras).filter(|&c| c != camera) {
            let Some(glimpse) = now[other] else { continue };
            let against = mine.iter().filter(|t| contradicts(glimpse, t.home, tolerance_m)).count();
            if against as f64 > UNFIT * mine.len() as f64 {
                self.unfit.push((camera, other));
            }
        }
    }
}

/// Whether `other` would have to see the background, or something farther away, if there were a point at `point`: nothing
/// hides it, yet it is not seen. Places outside the image say nothing.
pub(crate) fn contradicts(other: Glimpse<'_>, point: Point, tolerance_m: f64) -> bool {
    let Some((at, depth)) = other.camera.project(point, other.frame) else { return false };
    let [width, height] = other.view.size();
    let inside =
        at[0] >= 0.0 && at[1] >= 0.0 && at[0] <= width as f64 - 1.0 && at[1] <= height as f64 - 1.0;
    if !inside {
        return false;
    }
    let seen = other.view.nearest_depth_near(at, OUTLINE_PX).map(f64::from);
    if other.view.shows_near(at, OUTLINE_PX) {
        // All that is seen about there is farther away than the point.
        seen.is_some_and(|seen| seen > depth + tolerance_m)
    } else {
        // It would stand before the background, unless something that nobody masked hides it.
        seen.is_none_or(|seen| seen > depth - tolerance_m)
    }
}
