//! Motion that no robot makes and no material survives: what is flagged in replies, and refused if
//! the request says so.

use bendtwin_core::{
    Plane, Point,
    geometry::{dot, length, scaled, sub},
};
use bendtwin_engine::{backend::Rollout, world::Shape};
use bendtwin_proto::v1::{Plausibility as Wire, roll_out_response::Implausible};

use super::{error::Error, world::Path};

/// Limits of what is plausible.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Plausibility {
    start_gap_m: f64,
    control_speed_m_s: f64,
    strain: f64,
    control_depth_m: f64,
    /// Implausible motion is an error.
    pub(super) is_refused: bool,
}

/// Extremes of an instance's actions.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Extremes {
    /// Between the initial state's control points and row 0 of the actions [m].
    pub(super) start_gap_m: f32,
    /// Of the fastest control point [m/s], and its frame.
    speed: (f32, usize),
    /// Of what is prescribed and deepest in an obstacle [m], and its frame.
    pub(super) depth: (f32, usize),
}

/// Positions that are prescribed to an instance.
#[derive(Clone, Copy, Debug)]
pub(super) struct Prescribed<'a> {
    /// Control points at frame boundaries [m], shape [F + 1, C].
    pub(super) controls: &'a [Point],
    /// Middles of grasps [m], as many at each frame boundary.
    pub(super) middles: &'a [Point],
    /// Nodes that grasps hold.
    pub(super) held: &'a [Path],
}

/// Obstacles that stand still.
#[derive(Clone, Debug, Default)]
pub(super) struct Obstacles {
    pub(super) ground: Option<Plane>,
    /// Shapes in the world without their margin, which is given beside them [m].
    pub(super) shapes: Vec<(Shape, f32)>,
}

impl Default for Plausibility {
    fn default() -> Self {
        Self {
            start_gap_m: 0.005,
            control_speed_m_s: 5.0,
            strain: 1.0,
            control_depth_m: 0.005,
            is_refused: false,
        }
    }
}

impl Plausibility {
    /// The limits of a checked request.
    pub(super) fn read(wire: Option<Wire>) -> Self {
        let (default, wire) = (Self::default(), wire.unwrap_or_default());
        Self {
            start_gap_m: wire.start_gap_m.unwrap_or(default.start_gap_m),
            control_speed_m_s: wire.control_speed_m_s.unwrap_or(default.control_speed_m_s),
            strain: wire.strain.unwrap_or(default.strain),
            control_depth_m: wire.control_depth_m.unwrap_or(default.control_depth_m),
            is_refused: wire.refuse,
        }
    }

    /// What an instance does that is not plausible, as far as it is known.
    pub(super) fn judge(
        &self,
        instance: usize,
        extremes: &Extremes,
        rollout: Option<&Rollout>,
    ) -> Vec<Implausible> {
        let strain = rollout.and_then(|r| r.diagnostics).map_or(0.0, |d| d.max_strain);
        let ((speed, fastest), (depth, deepest)) = (extremes.speed, extremes.depth);
        let found = [
            ("START_GAP", extremes.start_gap_m, self.start_gap_m, 0),
            ("CONTROL_SPEED", speed, self.control_speed_m_s, fastest),
            ("STRAIN", strain, self.strain, 0),
            ("CONTROL_IN_OBSTACLE", depth, self.control_depth_m, deepest),
        ];
        let beyond = found.into_iter().filter(|(_, found, limit, _)| f64::from(*found) > *limit);
        beyond
            .map(|(reason, found, limit, frame)| Implausible {
                instance: instance as u32,
                reason: reason.to_owned(),
                found: found.into(),
                limit,
                frame: frame as u32,
            })
            .collect()
    }

    /// Refuses the first of these, if the request says so.
    pub(super) fn refuse(&self, found: &[Implausible]) -> Result<(), Error> {
        match found.first() {
            Some(first) if self.is_refused => Err(Error::Implausible { what: describe(first) }),
            _ => Ok(()),
        }
    }
}

/// Extremes of what is prescribed; the gap at the start is known already.
pub(super) fn extremes(
    start_gap_m: f32,
    of: Prescribed<'_>,
    frames: usize,
    fps: f64,
    obstacles: &Obstacles,
) -> Extremes {
    let Prescribed { controls, middles, held } = of;
    let width = controls.len() / (frames + 1);
    let mut found = Extremes { start_gap_m, ..Extremes::default() };
    let mut speed = 0.0f32;
    for (i, (before, after)) in controls.iter().zip(controls.iter().skip(width)).enumerate() {
        let way = length(sub(*after, *before));
        if way > speed {
            speed = way;
            found.speed = ((f64::from(way) * fps) as f32, i / width + 1);
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
    for points in [controls, middles] {
        let width = points.len() / (frames + 1);
        for (i, point) in points.iter().enumerate() {
            see(obstacles.depth(*point), i / width);
        }
    }
    for path in held {
        // A node that was deep already, as noise may have it, counts by how much deeper it gets.
        let first = path.points.first().map_or(0.0, |p| obstacles.depth(*p).max(0.0));
        for (point, frame) in path.points.iter().zip(path.from..) {
            see(obstacles.depth(*point) - first, frame);
        }
    }
    found
}

impl Obstacles {
    /// Depth of a point in the obstacle that it is deepest in [m]; negative outside all of them.
    fn depth(&self, p: Point) -> f32 {
        let ground = self.ground.map(|plane| plane.offset_m - dot(plane.normal, p));
        let shapes = self.shapes.iter().map(|(shape, margin)| -distance(shape, p) - margin);
        shapes.chain(ground).fold(f32::NEG_INFINITY, f32::max)
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
    let Implausible { instance, reason, found, limit, frame } = what;
    match reason.as_str() {
        "START_GAP" => format!(
            "row 0 of the actions of instance {instance} is {:.1} mm from the control points of the initial state (limit {:.1} mm): start the actions where the state is, or raise plausibility.start_gap_m",
            1e3 * found,
            1e3 * limit
        ),
        "CONTROL_SPEED" => format!(
            "a control point of instance {instance} moves at {found:.1} m/s in frame {frame} (limit {limit}): give it more frames, or raise plausibility.control_speed_m_s"
        ),
        "STRAIN" => format!(
            "the material of instance {instance} is strained by {found:.2} (limit {limit}): pull less, or raise plausibility.strain"
        ),
        _ => format!(
            "a control point, grasp or held node of instance {instance} is {:.1} mm deep in the ground or a collider in frame {frame} (limit {:.1} mm): lift its path, or raise plausibility.control_depth_m",
            1e3 * found,
            1e3 * limit
        ),
    }
}

#[cfg(test)]
mod tests;
