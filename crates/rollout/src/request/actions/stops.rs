//! Hands and grippers that stop at the ground. A hand that is driven into the table would pull on what
//! lies there with any force; a robot's stops. So no point of a hand gets deeper below the ground than a
//! request's `plausibility.control_depth_m`. Its points are its control points, the nodes pinned to them
//! and, of a gripper, the middles of its grasps' spheres and boxes. A hand that would get deeper is
//! shifted along the ground's normal, as a rigid body, by the least that suffices:
//!
//! ```text
//! shift = max(0, max over points p of (depth(p) - limit(p)))
//! ```
//!
//! A recorded hand may seem to be in the table. So control points and what is pinned to them may
//! also be as deep as the twin at rest has them below the twin's ground, and as deep as they were a
//! frame earlier.
//!
//! Nothing older than a frame counts, so frames that are executed one after another stop like those
//! of one rollout. Poses carry control points from where a gripper would have them, not from where
//! it is held back; a state has both ([`Start::commanded`]). Nodes that grasps take do not stop a
//! gripper, since they are unknown before a simulation.
//!
//! The motion of a hand along the normal does nothing while the hand is held back, and its gradient is
//! zero: the deepest point gets the negative of d loss / d shift, which is the sum over the hand of
//! n . d loss / d x. If its limit is the depth a frame earlier, that frame gets the opposite.

use bendtwin_core::{Graph, Plane, Point, geometry::dot};
use bendtwin_engine::{backend::Gradient, world::Pose};

use super::{Actions, Kind};
use crate::request::initial::Start;

/// Depth beyond a limit that is rounding: the hand is at the limit [m].
const ROUNDING_M: f32 = 1e-6;

/// The ground and what may meet it.
pub(crate) struct Floor<'a> {
    pub(crate) plane: Plane,
    /// Depth that is allowed [m].
    pub(crate) allowed_m: f32,
    /// The twin's graph, and the ground that it has itself.
    pub(crate) graph: &'a Graph,
    pub(crate) own: Option<Plane>,
    pub(crate) start: &'a Start,
    /// Middles of grasps: the gripper, and the place in its coordinates [m].
    pub(crate) middles: Vec<(usize, Point)>,
}

/// A point that stops its hand.
#[derive(Clone, Copy, Debug)]
struct Probe {
    hand: usize,
    place: Place,
    /// Depth that is always allowed, independent of earlier ones [m].
    limit_m: f32,
}

#[derive(Clone, Copy, Debug)]
enum Place {
    /// Beside a control point [m].
    Control(usize, Point),
    /// In the gripper's coordinates [m].
    Gripper(Point),
}

/// Shift of a hand at a frame boundary.
#[derive(Clone, Copy, Debug, Default)]
struct Shift {
    /// [m]
    by: f32,
    /// The point that holds it back.
    probe: usize,
    /// True if its limit is the depth a frame earlier.
    follows: bool,
}

/// The most that a hand is held back [m], and the frame of that.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Stopped {
    pub(crate) shift_m: f32,
    pub(crate) frame: usize,
}

/// Shifts of hands in a rollout.
#[derive(Debug, Default)]
pub(crate) struct Stops {
    normal: Point,
    /// Shape [F + 1, hands]; empty if no hand is held back.
    shifts: Vec<Shift>,
    hands: usize,
    probes: Vec<Probe>,
    /// Grippers carry the control points, from where the state has them.
    carries: bool,
}

impl Floor<'_> {
    fn depth(&self, x: Point) -> f32 {
        below(self.plane, x)
    }

    /// The points of hands, given those of the control points.
    fn probes(&self, hands: &[usize]) -> Vec<Probe> {
        let own = (0..hands.len()).map(|c| (c, [0.0; 3]));
        let pinned = self.graph.pins.iter().map(|pin| (pin.control as usize, pin.offset_m));
        let of_control = own.chain(pinned).filter_map(|(c, offset)| {
            let rest = moved(*self.graph.control_rest.get(c)?, 1.0, offset);
            let limit_m =
                self.own.map_or(self.allowed_m, |own| below(own, rest).max(self.allowed_m));
            Some(Probe { hand: *hands.get(c)?, place: Place::Control(c, offset), limit_m })
        });
        let middles = self.middles.iter().map(|&(hand, place)| Probe {
            hand,
            place: Place::Gripper(place),
            limit_m: self.allowed_m,
        });
        of_control.chain(middles).collect()
    }
}

impl Probe {
    /// Place in a frame with these control points and grippers.
    fn at(&self, controls: &[Point], grippers: &[Pose]) -> Point {
        match self.place {
            Place::Control(c, offset) => moved(controls[c], 1.0, offset),
            Place::Gripper(place) => grippers[self.hand]
                .map(|[x, y, z, at]| x * place[0] + y * place[1] + z * place[2] + at),
        }
    }

    /// True if the probe may be as deep as a frame earlier.
    fn remembers(&self) -> bool {
        matches!(self.place, Place::Control(..))
    }
}

impl Actions {
    /// Holds back the hands of an instance: shifts `controls`, shape [F + 1, C], and the poses of
    /// grippers, the first of each row of `poses`, shape [F + 1, B] or empty.
    pub(crate) fn stop(
        &self,
        controls: &mut [Point],
        poses: &mut [Pose],
        floor: &Floor<'_>,
    ) -> Stops {
        let frames = self.schedule.places().len().max(1);
        let (width, bodies) = (controls.len() / frames, poses.len() / frames);
        let carries = matches!(self.kind, Kind::Poses(_));
        let grippers = if bodies == 0 { 0 } else { self.grippers() };
        let hands = self.hands.iter().max().map_or(0, |last| last + 1).max(grippers);
        let probes = floor.probes(&self.hands);
        let mut shifts = vec![Shift::default(); frames * hands];
        let begun = floor.start.here();
        let depth_at = |row: &[Point], probe: &Probe| match probe.remembers() {
            true => floor.depth(probe.at(row, &[])),
            false => f32::NEG_INFINITY,
        };
        let mut before: Vec<f32> = probes.iter().map(|probe| depth_at(begun, probe)).collect();
        for (frame, shifts) in shifts.chunks_mut(hands.max(1)).enumerate() {
            let row = &mut controls[frame * width..(frame + 1) * width];
            let poses = &mut poses[frame * bodies..][..grippers];
            for (index, (probe, before)) in probes.iter().zip(&before).enumerate() {
                let follows = *before > probe.limit_m + ROUNDING_M;
                let limit = if follows { *before } else { probe.limit_m };
                let by = floor.depth(probe.at(row, poses)) - limit;
                let shift = &mut shifts[probe.hand];
                if by > shift.by {
                    *shift = Shift { by, probe: index, follows };
                }
            }
            let held_back = |hand: usize| Some(shifts[hand].by).filter(|by| *by > 0.0);
            for (x, hand) in row.iter_mut().zip(&self.hands) {
                if let Some(by) = held_back(*hand) {
                    *x = moved(*x, by, floor.plane.normal);
                }
            }
            for (gripper, pose) in poses.iter_mut().enumerate() {
                if let Some(by) = held_back(gripper) {
                    (0..3).for_each(|i| pose[i][3] += by * floor.plane.normal[i]);
                }
            }
            if carries && frame == 0 {
                row.copy_from_slice(&floor.start.controls);
            }
            before = probes.iter().map(|probe| depth_at(row, probe)).collect();
        }
        if shifts.iter().all(|shift| shift.by == 0.0) {
            return Stops::default();
        }
        Stops { normal: floor.plane.normal, shifts, hands, probes, carries }
    }
}

impl Stops {
    /// The most that a hand is held back.
    pub(crate) fn most(&self) -> Stopped {
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
    pub(crate) fn back(&self, actions: &Actions, by: &mut Gradient) {
        let frames = self.shifts.len().checked_div(self.hands).unwrap_or(0);
        let width = by.controls.len().checked_div(frames).unwrap_or(0);
        let bodies = by.poses.len().checked_div(frames).unwrap_or(0);
        let grippers = if bodies == 0 { 0 } else { actions.grippers() };
        let along = |g: Point| f64::from(dot(self.normal, g));
        for frame in (0..frames).rev() {
            let mut sums = vec![0.0f64; self.hands];
            // What grippers carry begins where the state has it.
            let from = if self.carries && frame == 0 { width } else { 0 };
            let row = by.controls.get(frame * width..(frame + 1) * width).unwrap_or_default();
            for (g, hand) in row.iter().zip(&actions.hands).skip(from) {
                sums[*hand] += along(*g);
            }
            for (g, sum) in by.poses.iter().skip(frame * bodies).take(grippers).zip(&mut sums) {
                *sum += along(g.map(|row| row[3]));
            }
            for (hand, sum) in sums.into_iter().enumerate() {
                let shift = self.shifts[frame * self.hands + hand];
                let Some(probe) = self.probes.get(shift.probe).filter(|_| shift.by > 0.0) else {
                    continue;
                };
                match probe.place {
                    Place::Control(c, _) => {
                        let mut add = |frame: usize, t: f64| {
                            if let Some(g) = by.controls.get_mut(frame * width + c) {
                                *g = moved(*g, t as f32, self.normal);
                            }
                        };
                        add(frame, -sum);
                        if shift.follows && frame > 0 {
                            add(frame - 1, sum);
                        }
                    }
                    Place::Gripper([x, y, z]) => {
                        if let Some(g) = by.poses.get_mut(frame * bodies + hand) {
                            for (row, n) in g.iter_mut().zip(self.normal) {
                                let place = [x, y, z, 1.0];
                                *row = std::array::from_fn(|j| row[j] - sum as f32 * n * place[j]);
                            }
                        }
                    }
                }
            }
        }
    }
}

/// Depth below a plane [m].
fn below(plane: Plane, x: Point) -> f32 {
    plane.offset_m - dot(plane.normal, x)
}

/// x + t v
fn moved(x: Point, t: f32, v: Point) -> Point {
    std::array::from_fn(|i| x[i] + t * v[i])
}

#[cfg(test)]
mod tests;
