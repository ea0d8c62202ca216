//! What other cameras say about a point in space.

use bendtwin_core::Point;

use crate::appearance::Glimpse;

/// A mask's outline is believed to this many pixels.
const OUTLINE_PX: usize = 3;

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
