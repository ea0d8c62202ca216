//! Motion that no robot makes and no material survives: what is flagged in replies, and refused if
//! the request says so.

use bendtwin_contract::rollout::ImplausibleReason as Reason;
use bendtwin_core::{
    Plane, Point,
    geometry::{dot, length, scaled, sub},
};
use bendtwin_engine::{backend::Rollout, world::Shape};
use bendtwin_proto::v1::{Plausibility as Wire, roll_out_response::Implausible};

use crate::{error::Error, request::actions::Stopped, world::Path};

/// Force [N] and torque [N m] at unit mass.
type Wrench = [f32; 6];

/// Limits of plausible motion.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Plausibility(Wire);

/// Extremes of an instance's actions, and of the forces of its grasps.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Extremes {
    /// Between the initial state's control points and row 0 of the actions [m].
    pub(crate) start_gap_m: f32,
    /// Speed of the fastest control point [m/s], and its frame.
    speed: (f32, usize),
    /// Greatest depth of a prescribed point in an obstacle [m], and its frame; for control points,
    /// beyond their depth in the initial state.
    pub(crate) depth: (f32, usize),
    /// The most that a hand was held back at the ground [m].
    pub(crate) stopped_m: f32,
    /// Largest mean force of each grasp over a frame [N], and the frame; empty if they are not measured.
    pub(crate) grasp_forces: Vec<(f32, usize)>,
}

impl Extremes {
    /// The extremes with a hand that would have been deeper in the ground than `allowed_m`, by the
    /// distance that it was held back.
    pub(crate) fn with(mut self, stopped: Stopped, allowed_m: f32) -> Self {
        let asked = stopped.shift_m + allowed_m;
        self.stopped_m = stopped.shift_m;
        if stopped.shift_m > 0.0 && asked > self.depth.0 {
            self.depth = (asked, stopped.frame);
        }
        self
    }

    /// Takes in the forces of grasps, of which there are `grasps`, over the frames after the first `from`;
    /// `unit` is in newtons.
    pub(crate) fn see_forces(&mut self, forces: &[Wrench], grasps: usize, from: usize, unit: f32) {
        self.grasp_forces.resize(grasps, (0.0, 0));
        for (frame, row) in forces.chunks_exact(grasps.max(1)).enumerate() {
            for (most, [x, y, z, ..]) in self.grasp_forces.iter_mut().zip(row) {
                let force = unit * length([*x, *y, *z]);
                if force > most.0 {
                    *most = (force, from + frame + 1);
                }
            }
        }
    }
}

/// Positions that are prescribed to an instance.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Prescribed<'a> {
    /// Control points of the initial state [m], shape [C].
    pub(crate) start: &'a [Point],
    /// Control points at frame boundaries [m], shape [F + 1, C].
    pub(crate) controls: &'a [Point],
    /// Middles of grasps [m], as many at each frame boundary.
    pub(crate) middles: &'a [Point],
    /// Nodes that grasps hold.
    pub(crate) held: &'a [Path],
}

/// Obstacles that stand still.
#[derive(Clone, Debug, Default)]
pub(crate) struct Obstacles {
    pub(crate) ground: Option<Plane>,
    /// Shapes in the world without their margin, which is given beside them [m].
    pub(crate) shapes: Vec<(Shape, f32)>,
}

impl Plausibility {
    /// The limits of a checked request.
    pub(crate) fn read(wire: Option<Wire>) -> Self {
        Self(wire.unwrap_or_default())
    }

    /// Depth below the ground that hands may have beyond that with which they began [m].
    pub(crate) fn allowed_depth_m(&self) -> f32 {
        let reason = Reason::ControlInObstacle;
        reason.limit_or_default(&self.0) as f32
    }

    /// True if there is a limit of the forces of grasps.
    pub(crate) fn limits_grasp_force(&self) -> bool {
        Reason::GraspForce.limit_or_default(&self.0) < f64::INFINITY
    }

    /// True if implausible motion is an error.
    pub(crate) fn is_refused(&self) -> bool {
        self.0.refuse
    }

    /// Implausible motion of an instance, as far as it is known.
    pub(crate) fn judge(
        &self,
        instance: usize,
        extremes: &Extremes,
        rollout: Option<&Rollout>,
    ) -> Vec<Implausible> {
        let strain = rollout.and_then(|r| r.diagnostics).map_or(0.0, |d| d.max_strain);
        let grasps = extremes.grasp_forces.iter().zip(0u32..);
        let found = [
            (Reason::StartGap, (extremes.start_gap_m, 0), None),
            (Reason::ControlSpeed, extremes.speed, None),
            (Reason::Strain, (strain, 0), None),
            (Reason::ControlInObstacle, extremes.depth, None),
        ];
        let forces = grasps.map(|(force, grasp)| (Reason::GraspForce, *force, Some(grasp)));
        let beyond = |(reason, (found, frame), grasp): (Reason, (f32, usize), Option<u32>)| {
            let limit = reason.limit_or_default(&self.0);
            (f64::from(found) > limit).then(|| Implausible {
                instance: instance as u32,
                reason: reason.as_str().to_owned(),
                found: found.into(),
                limit,
                frame: frame as u32,
                grasp,
            })
        };
        found.into_iter().chain(forces).filter_map(beyond).collect()
    }

    /// Refuses the first of these, if the request says so.
    pub(crate) fn refuse(&self, found: &[Implausible]) -> Result<(), Error> {
        match found.first() {
            Some(first) if self.is_refused() => Err(Error::Implausible { what: describe(first) }),
            _ => Ok(()),
        }
    }
}

/// Extremes of what is prescribed; the gap at the start is known already.
pub(crate) fn extremes(
    start_gap_m: f32,
    of: Prescribed<'_>,
    frames: usize,
    fps: f64,
    obstacles: &Obstacles,
) -> Extremes {
    let Prescribed { start, controls, middles, held } = of;
    let mut found = Extremes { start_gap_m, ..Extremes::default() };
    // Frame by frame: batches have millions of points, and a division costs more than a point.
    let width = |points: &[Point]| (points.len() / (frames + 1)).max(1);
    let now = controls.chunks_exact(width(controls));
    let mut most = 0.0f32;
    for (frame, (before, after)) in now.clone().zip(now.clone().skip(1)).enumerate() {
        let ways = before.iter().zip(after).map(|(a, b)| sub(*b, *a));
        let square = ways.map(|way| dot(way, way)).fold(0.0, f32::max);
        if square > most {
            most = square;
            found.speed = ((f64::from(square.sqrt()) * fps) as f32, frame + 1);
        }
    }
    if obstacles.ground.is_none() && obstacles.shapes.is_empty() {
        return found;
    }
    let mut see = |depth: f32, frame: usize| {
        if depth > found.depth.0 {
            found.depth = (depth, frame);
        }
    };
    // What was deep already, as a hand at the ground may be in a capture, counts by how much deeper
    // it gets.
    let before = |p: &Point| obstacles.depth(*p).max(0.0);
    let starts: Vec<f32> = start.iter().map(before).collect();
    for (frame, row) in now.enumerate() {
        let depths = row.iter().zip(&starts).map(|(p, first)| obstacles.depth(*p) - first);
        see(depths.fold(0.0, f32::max), frame);
    }
    for (frame, row) in middles.chunks_exact(width(middles)).enumerate() {
        see(row.iter().map(|p| obstacles.depth(*p)).fold(0.0, f32::max), frame);
    }
    for path in held {
        let first = path.points.first().map_or(0.0, before);
        for (point, frame) in path.points.iter().zip(path.from..) {
            see(obstacles.depth(*point) - first, frame);
        }
    }
    found
}

impl Obstacles {
    /// Depth of a point in the obstacle that it is deepest in [m]; negative outside all of them.
    fn depth(&self, p: Point) -> f32 {
        let below = |plane: Plane| plane.offset_m - dot(plane.normal, p);
        let ground = self.ground.map_or(f32::NEG_INFINITY, below);
        let shapes = self.shapes.iter().map(|(shape, margin)| -distance(shape, p) - margin);
        shapes.fold(ground, f32::max)
    }
}

/// Distance of a point to a shape, negative within [m]; of a convex one that to the farthest of its
/// planes.
fn distance(shape: &Shape, p: Point) -> f32 {
    match shape {
        Shape::Capsule { from, to, radius_m } => {
            let (axis, way) = (sub(*to, *from), sub(p, *from));
            let square = dot(axis, axis);
            let share = if square > 0.0 { (dot(way, axis) / square).clamp(0.0, 1.0) } else { 0.0 };
            length(sub(way, scaled(axis, share))) - radius_m
        }
        Shape::Convex(faces) => {
            let planes = faces.iter().map(|face| dot(face.normal, p) - face.offset_m);
            planes.fold(f32::NEG_INFINITY, f32::max)
        }
    }
}

fn describe(what: &Implausible) -> String {
    let Implausible { instance, reason, found, limit, frame, grasp } = what;
    let Some(reason) = Reason::ALL.into_iter().find(|r| r.as_str() == reason) else {
        return format!("instance {instance} is beyond the limit of {limit}");
    };
    let (found_mm, limit_mm) = (1e3 * found, 1e3 * limit);
    let (fault, advice) = match reason {
        Reason::StartGap => (
            format!(
                "row 0 of the actions of instance {instance} is {found_mm:.1} mm from the control points of the initial state (limit {limit_mm:.1} mm)"
            ),
            "start the actions where the state is",
        ),
        Reason::ControlSpeed => (
            format!(
                "a control point of instance {instance} moves at {found:.1} m/s in frame {frame} (limit {limit})"
            ),
            "give it more frames",
        ),
        Reason::Strain => (
            format!(
                "the material of instance {instance} is strained by {found:.2} (limit {limit})"
            ),
            "pull less",
        ),
        Reason::ControlInObstacle => (
            format!(
                "a control point, grasp or held node of instance {instance} is {found_mm:.1} mm deeper in the ground or a collider in frame {frame} than it began (limit {limit_mm:.1} mm)"
            ),
            "lift its path",
        ),
        Reason::GraspForce => (
            format!(
                "grasp {} of instance {instance} exerts {found:.2} N in frame {frame} (limit {limit:.2})",
                grasp.unwrap_or_default()
            ),
            "grasp elsewhere, or move slower",
        ),
    };
    format!("{fault}: {advice}, or raise plausibility.{}", reason.field())
}

#[cfg(test)]
mod tests;
