//! Checks of a camera's points against the masks and depth of the other cameras.

use bendtwin_capture::raw::Region;
use bendtwin_core::Point;

use crate::{appearance::PosedView, track::Track};

/// Distance to which a mask's outline can be trusted [px].
const MASK_MARGIN_PX: usize = 3;

/// If another camera contradicts more than this share of points when they are seeded, one of the
/// two stands elsewhere than its calibration says, or shows another moment.
const MAX_CONTRADICTED_SHARE: f64 = 0.3;

/// Cameras against which each camera's points are checked.
#[derive(Clone, Debug)]
pub(crate) struct CrossChecks {
    /// Pairs of a camera and another that is that its points are not checked against.
    excluded: Vec<(usize, usize)>,
    cameras: usize,
}

impl CrossChecks {
    /// Every camera is checked against all others.
    pub(crate) fn new(cameras: usize) -> Self {
        Self { excluded: Vec::new(), cameras }
    }

    /// The cameras that the points of `camera` are checked against.
    pub(crate) fn partners(&self, camera: usize) -> impl Iterator<Item = usize> {
        (0..self.cameras).filter(move |&c| c != camera && !self.excluded.contains(&(camera, c)))
    }

    /// The cameras that they are not checked against.
    pub(crate) fn excluded_for(&self, camera: usize) -> Vec<usize> {
        self.excluded.iter().filter(|pair| pair.0 == camera).map(|pair| pair.1).collect()
    }

    /// Checks the points of a camera that were just seeded against all others; those that
    /// contradict too many are excluded from then on.
    pub(crate) fn screen(
        &mut self,
        camera: usize,
        tracks: &[Track],
        now: &[Option<PosedView<'_>>],
        tolerance_m: f64,
    ) {
        let mine: Vec<&Track> =
            tracks.iter().filter(|t| t.camera == camera && t.region == Region::Object).collect();
        for other in (0..self.cameras).filter(|&c| c != camera) {
            let Some(posed) = now[other] else { continue };
            let against =
                mine.iter().filter(|t| contradicts(posed, t.seed_point, tolerance_m)).count();
            if against as f64 > MAX_CONTRADICTED_SHARE * mine.len() as f64 {
                self.excluded.push((camera, other));
            }
        }
    }
}

/// True if `other` shows the background, or something farther away, where it would have to show a
/// point at `point`: nothing hides it, yet it is not seen. Places outside the image decide nothing.
pub(crate) fn contradicts(other: PosedView<'_>, point: Point, tolerance_m: f64) -> bool {
    let Some((at, depth)) = other.camera.project(point, other.frame) else { return false };
    let [width, height] = other.view.size();
    let inside =
        at[0] >= 0.0 && at[1] >= 0.0 && at[0] <= width as f64 - 1.0 && at[1] <= height as f64 - 1.0;
    if !inside {
        return false;
    }
    let seen = other.view.nearest_depth_near(at, MASK_MARGIN_PX).map(f64::from);
    if other.view.shows_near(at, MASK_MARGIN_PX) {
        // All that is seen about there is farther away than the point.
        seen.is_some_and(|seen| seen > depth + tolerance_m)
    } else {
        // It would stand before the background, unless something without a mask hides it.
        seen.is_none_or(|seen| seen > depth - tolerance_m)
    }
}
