//! From one frame to the next: pyramidal Lucas-Kanade, there and back.

use super::{
    align::{Alignment, Warp, align},
    layer::Layer,
    patch::Patch,
};
use crate::FlowSettings;

/// The place that a point moved to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct FlowMatch {
    /// Column and row in the new frame.
    pub(crate) at: [f64; 2],
    /// Distance to its start after tracking there and back [px].
    pub(crate) forward_backward_px: f64,
}

/// Largest motion of a patch on one level [pixels of the level].
const MAX_SHIFT: f32 = 6.0;

/// Follows the point at `at` of `before` into `after`. Each of `guesses`, pixels of the new frame,
/// is tried on the two finest levels and then through the whole pyramid, until one returns to its
/// start.
pub(crate) fn follow(
    before: &Layer,
    after: &Layer,
    at: [f64; 2],
    guesses: &[[f64; 2]],
    settings: &FlowSettings,
) -> Option<FlowMatch> {
    let window = settings.window_px;
    let levels = before.levels.len().min(after.levels.len());
    for depth in [levels.min(2), levels] {
        for guess in guesses {
            let Some(there) = descend(before, after, at, *guess, window, depth) else { continue };
            // Back with the guess reversed: starting from the answer would prove nothing.
            let back = [0, 1].map(|i| there.at[i] + at[i] - guess[i]);
            let Some(back) = descend(after, before, there.at, back, window, depth) else {
                continue;
            };
            let miss = (back.at[0] - at[0]).hypot(back.at[1] - at[1]);
            let alike = f64::from(there.correlation) >= settings.min_correlation;
            if alike && miss <= settings.max_forward_backward_px {
                return Some(FlowMatch { at: there.at, forward_backward_px: miss });
            }
        }
    }
    None
}

/// From the coarsest of `levels` levels to the finest, which alone has to succeed.
fn descend(
    before: &Layer,
    after: &Layer,
    at: [f64; 2],
    guess: [f64; 2],
    window: usize,
    levels: usize,
) -> Option<Alignment> {
    let mut start = guess;
    let mut found = None;
    for level in (0..levels).rev() {
        let patch = Patch::cut(&before.levels[level], at, window);
        found = align(&patch, &Warp::translation(&patch), &after.levels[level], start, MAX_SHIFT);
        if let Some(found) = &found {
            start = found.at;
        }
    }
    found
}
