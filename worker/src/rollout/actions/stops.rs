//! Hands that stop at the ground. A hand that is driven into the table would pull on what lies there
//! with any force; a robot's stops. So no control point of trajectories, and no node pinned to one,
//! gets deeper below the ground than a request's `plausibility.control_depth_m` (a recorded hand may
//! seem to be some millimetres in the table), or than it began. A hand that would get deeper is
//! shifted along the ground's normal, as a rigid body, by the least that suffices:
//!
//! ```text
//! shift = max(0, max over points p of (depth(p) - max(depth_began(p), allowed)))
//! ```
//!
//! The motion of a hand along the normal does nothing while the hand is held back, and its gradient is
//! zero: the deepest point gets the negative of d loss / d shift, which is the sum over the hand of
//! n . d loss / d x.
//!
//! A stop depends on the trajectory alone, so frames that are executed one after the other stop as those
//! of one rollout do. That would not hold for grippers: their control points move with them from where
//! the state has them, which after a stop is not where the gripper would have them. Grippers in the ground
//! are reported (`CONTROL_IN_OBSTACLE`).

use bendtwin_core::{Graph, Plane, Point, geometry::dot};
use bendtwin_engine::backend::Gradient;

use super::{Actions, Kind};

/// The ground and what may meet it.
pub(in crate::rollout) struct Floor<'a> {
    pub(in crate::rollout) plane: Plane,
    /// Depth that is allowed [m].
    pub(in crate::rollout) allowed_m: f32,
    pub(in crate::rollout) graph: &'a Graph,
    /// Control points of the initial state [m], shape [C].
    pub(in crate::rollout) start: &'a [Point],
}

/// How far a hand is held back at a frame boundary.
#[derive(Clone, Copy, Debug, Default)]
struct Shift {
    /// [m]
    by: f32,
    /// The control point that holds it back.
    deepest: Option<usize>,
}

/// The most that a hand is held back [m], and the frame of that.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(in crate::rollout) struct Stopped {
    pub(in crate::rollout) shift_m: f32,
    pub(in crate::rollout) frame: usize,
}

/// How far hands are held back in a rollout.
#[derive(Debug, Default)]
pub(in crate::rollout) struct Stops {
    normal: Point,
    /// Shape [F + 1, hands]; empty if no hand is held back.
    shifts: Vec<Shift>,
    hands: usize,
}

impl Floor<'_> {
    fn depth(&self, x: Point) -> f32 {
        self.plane.offset_m - dot(self.plane.normal, x)
    }

    /// Control points and what is pinned to them: the control point, the offset from it [m], and how
    /// deep it may get [m].
    fn prescribed(&self) -> Vec<(usize, Point, f32)> {
        let limit = |x: Point| self.depth(x).max(self.allowed_m);
        let own = self.start.iter().enumerate().map(|(c, x)| (c, [0.0; 3], limit(*x)));
        let pinned = self.graph.pins.iter().filter_map(|pin| {
            let c = pin.control as usize;
            let x = moved(*self.start.get(c)?, 1.0, pin.offset_m);
            Some((c, pin.offset_m, limit(x)))
        });
        own.chain(pinned).collect()
    }
}

impl Actions {
    /// Holds back the hands of an instance: shifts `controls`, shape [F + 1, C].
    pub(in crate::rollout) fn stop(&self, controls: &mut [Point], floor: &Floor<'_>) -> Stops {
        if matches!(self.kind, Kind::Poses(_)) {
            return Stops::default();
        }
        let frames = self.schedule.places().len().max(1);
        let width = controls.len() / frames;
        let hands = self.hands.iter().max().map_or(0, |last| last + 1);
        let prescribed = floor.prescribed();
        let mut shifts = vec![Shift::default(); frames * hands];
        for (frame, row) in shifts.chunks_mut(hands.max(1)).enumerate() {
            for &(c, offset, limit) in &prescribed {
                let by = floor.depth(moved(controls[frame * width + c], 1.0, offset)) - limit;
                let shift = &mut row[self.hands[c]];
                if by > shift.by {
                    *shift = Shift { by, deepest: Some(c) };
                }
            }
        }
        if shifts.iter().all(|shift| shift.by == 0.0) {
            return Stops::default();
        }
        let normal = floor.plane.normal;
        for (frame, row) in shifts.chunks(hands).enumerate() {
            for (x, hand) in controls[frame * width..].iter_mut().zip(&self.hands) {
                *x = moved(*x, row[*hand].by, normal);
            }
        }
        Stops { normal, shifts, hands }
    }
}

impl Stops {
    /// The most that a hand is held back.
    pub(in crate::rollout) fn most(&self) -> Stopped {
        let mut most = Stopped::default();
        for (frame, row) in self.shifts.chunks(self.hands.max(1)).enumerate() {
            let by = row.iter().map(|shift| shift.by).fold(0.0, f32::max);
            if by > most.shift_m {
                most = Stopped { shift_m: by, frame };
            }
        }
        most
    }

    /// Turns gradients by where hands are into those by where the actions would have them; `actions`
    /// are those that were stopped.
    pub(in crate::rollout) fn back(&self, actions: &Actions, by: &mut Gradient) {
        let frames = self.shifts.len().checked_div(self.hands).unwrap_or(0);
        let width = by.controls.len().checked_div(frames).unwrap_or(0);
        for frame in 0..frames {
            let row = by.controls.get_mut(frame * width..(frame + 1) * width).unwrap_or_default();
            let mut sums = vec![0.0f64; self.hands];
            for (g, hand) in row.iter().zip(&actions.hands) {
                sums[*hand] += f64::from(dot(self.normal, *g));
            }
            for (hand, sum) in sums.into_iter().enumerate() {
                let deepest = self.shifts[frame * self.hands + hand].deepest;
                if let Some(g) = deepest.and_then(|c| row.get_mut(c)) {
                    *g = moved(*g, -sum as f32, self.normal);
                }
            }
        }
    }
}

/// x + t v
fn moved(x: Point, t: f32, v: Point) -> Point {
    std::array::from_fn(|i| x[i] + t * v[i])
}

#[cfg(test)]
mod tests;
