//! Hands that stop at the ground. A hand that is driven into the table would pull on what lies there
//! with any force; a robot's stops. So no point of a hand gets deeper below the ground than a
//! request's `plausibility.control_depth_m` (a recorded hand may seem to be some millimetres in the
//! table), or than that beyond where it began. The points of a hand are its control points, the nodes
//! pinned to them and, of a gripper, the middles of its grasps and the nodes that it holds from the
//! start on. A hand that would get deeper is shifted along the ground's normal, as a rigid body, by
//! the least that suffices:
//!
//! ```text
//! shift = max(0, max over points p of (offset - n . x_p - began_p - allowed))
//! ```
//!
//! The motion of a hand along the normal does nothing while the hand is held back, and its gradient is
//! zero: the deepest point gets the negative of d loss / d shift, which is the sum over the hand of
//! n . d loss / d x.
//!
//! A gripper's control points move with it from where the initial state has them. So they are not
//! shifted by as much as the gripper is at the start of the rollout: the state of a stopped hand that a
//! rollout resumes from has that shift behind it.

use bendtwin_core::{Graph, Plane, Point, geometry::dot};
use bendtwin_engine::{backend::Gradient, world::Pose};

use super::{Actions, Kind};

/// A point that a gripper carries.
#[derive(Clone, Copy, Debug)]
pub(in crate::rollout) struct Carried {
    pub(in crate::rollout) gripper: usize,
    /// In the gripper's coordinates [m].
    pub(in crate::rollout) place: Point,
    /// Where it begins in the world, if it may be in the ground there [m].
    pub(in crate::rollout) began: Option<Point>,
    /// The frame boundary from which it is not carried any more.
    pub(in crate::rollout) until: usize,
}

/// The ground and what may meet it.
pub(in crate::rollout) struct Floor<'a> {
    pub(in crate::rollout) plane: Plane,
    /// Depth that is allowed [m].
    pub(in crate::rollout) allowed_m: f32,
    pub(in crate::rollout) graph: &'a Graph,
    /// Control points of the initial state [m], shape [C].
    pub(in crate::rollout) start: &'a [Point],
    pub(in crate::rollout) carried: Vec<Carried>,
}

/// The point that holds a hand back.
#[derive(Clone, Copy, Debug)]
enum Deepest {
    Control(usize),
    Carried(usize),
}

/// How far a hand is held back at a frame boundary.
#[derive(Clone, Copy, Debug, Default)]
struct Shift {
    /// [m]
    by: f32,
    deepest: Option<Deepest>,
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
    places: Vec<Carried>,
    /// Grippers carry the control points.
    carries: bool,
}

impl Floor<'_> {
    /// How much deeper a point is than it may be [m]; not positive where it is not.
    fn excess(&self, x: Point, began: f32) -> f32 {
        self.depth(x) - began - self.allowed_m
    }

    fn depth(&self, x: Point) -> f32 {
        self.plane.offset_m - dot(self.plane.normal, x)
    }

    /// Control points and what is pinned to them: the control point, the offset from it [m], and how
    /// deep it began [m].
    fn prescribed(&self) -> Vec<(usize, Point, f32)> {
        let began = |x: Point| self.depth(x).max(0.0);
        let own = self.start.iter().enumerate().map(|(c, x)| (c, [0.0; 3], began(*x)));
        let pinned = self.graph.pins.iter().filter_map(|pin| {
            let c = pin.control as usize;
            let x = moved(*self.start.get(c)?, 1.0, pin.offset_m);
            Some((c, pin.offset_m, began(x)))
        });
        own.chain(pinned).collect()
    }
}

impl Actions {
    /// Holds back the hands of an instance: shifts `controls`, shape [F + 1, C], and the poses of
    /// grippers, the first of each row of `poses`, shape [F + 1, B] or empty.
    pub(in crate::rollout) fn stop(
        &self,
        controls: &mut [Point],
        poses: &mut [Pose],
        floor: Floor<'_>,
    ) -> Stops {
        let frames = self.schedule.places().len().max(1);
        let (width, bodies) = (controls.len() / frames, poses.len() / frames);
        let carries = matches!(self.kind, Kind::Poses(_));
        let hands = self.hands.iter().max().map_or(0, |last| last + 1).max(self.grippers());
        let prescribed = floor.prescribed();
        let carried: &[Carried] = if bodies < self.grippers() { &[] } else { &floor.carried };
        let mut shifts = vec![Shift::default(); frames * hands];
        for frame in 0..frames {
            let began: Vec<f32> = shifts[..hands].iter().map(|shift| shift.by).collect();
            let row = &mut shifts[frame * hands..(frame + 1) * hands];
            let mut see = |hand: usize, by: f32, deepest: Deepest| {
                if by > row[hand].by {
                    row[hand] = Shift { by, deepest: Some(deepest) };
                }
            };
            for (k, point) in carried.iter().enumerate().filter(|(_, p)| frame < p.until) {
                let x = at(&poses[frame * bodies + point.gripper], point.place);
                let began = point.began.map_or(0.0, |x| floor.depth(x).max(0.0));
                see(point.gripper, floor.excess(x, began), Deepest::Carried(k));
            }
            // A gripper's control points begin where the state has them.
            if carries && frame == 0 {
                continue;
            }
            for &(c, offset, deep) in &prescribed {
                let hand = self.hands[c];
                let excess = floor.excess(moved(controls[frame * width + c], 1.0, offset), deep);
                if excess > 0.0 {
                    let base = if carries { began[hand] } else { 0.0 };
                    see(hand, base + excess, Deepest::Control(c));
                }
            }
        }
        if shifts.iter().all(|shift| shift.by == 0.0) {
            return Stops::default();
        }
        let normal = floor.plane.normal;
        for (frame, row) in shifts.chunks(hands).enumerate() {
            for (x, hand) in controls[frame * width..].iter_mut().zip(&self.hands) {
                let begun = if carries { shifts[*hand].by } else { 0.0 };
                *x = moved(*x, row[*hand].by - begun, normal);
            }
            let grippers = if bodies < self.grippers() { 0 } else { self.grippers() };
            for (pose, shift) in poses[frame * bodies..].iter_mut().zip(&row[..grippers]) {
                (0..3).for_each(|i| pose[i][3] += shift.by * normal[i]);
            }
        }
        Stops { normal, shifts, hands, places: floor.carried, carries }
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
        if frames == 0 {
            return;
        }
        let (width, bodies) = (by.controls.len() / frames, by.poses.len() / frames);
        let grippers = if bodies < actions.grippers() { 0 } else { actions.grippers() };
        let along = |g: Point| f64::from(dot(self.normal, g));
        let mut begun = vec![0.0f64; self.hands];
        for frame in (0..frames).rev() {
            let mut sums = if frame == 0 { begun.clone() } else { vec![0.0; self.hands] };
            for (g, hand) in by.controls[frame * width..].iter().zip(&actions.hands) {
                let by_shift = along(*g);
                if frame > 0 || !self.carries {
                    sums[*hand] += by_shift;
                }
                if frame > 0 && self.carries {
                    begun[*hand] -= by_shift;
                }
            }
            for (g, sum) in by.poses[frame * bodies..].iter().zip(&mut sums[..grippers]) {
                *sum += along(g.map(|row| row[3]));
            }
            for (hand, sum) in sums.into_iter().enumerate() {
                let shift = self.shifts[frame * self.hands + hand];
                let back = self.normal.map(|n| (-sum * f64::from(n)) as f32);
                match shift.deepest {
                    None => {}
                    Some(Deepest::Control(c)) => {
                        if let Some(g) = by.controls.get_mut(frame * width + c) {
                            *g = moved(*g, 1.0, back);
                        }
                        if self.carries {
                            begun[hand] += sum;
                        }
                    }
                    Some(Deepest::Carried(k)) => {
                        let place = self.places[k].place;
                        if let Some(g) = by.poses.get_mut(frame * bodies + hand) {
                            for (row, back) in g.iter_mut().zip(back) {
                                let by = [place[0], place[1], place[2], 1.0];
                                (0..4).for_each(|i| row[i] += back * by[i]);
                            }
                        }
                    }
                }
            }
        }
    }
}

/// x + t v
fn moved(x: Point, t: f32, v: Point) -> Point {
    std::array::from_fn(|i| x[i] + t * v[i])
}

/// A gripper's point in the world.
fn at(pose: &Pose, p: Point) -> Point {
    pose.map(|[x, y, z, at]| x * p[0] + y * p[1] + z * p[2] + at)
}

#[cfg(test)]
mod tests;
