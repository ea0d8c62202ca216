//! Surroundings of a request as the engine's world: bodies, colliders, grasps, and how they move.
//!
//! Bodies are the grippers, by their numbers, and then the paths of colliders, in their order;
//! there are no bodies if nothing is carried.

mod ended;
mod grasps;
mod holds;
mod hull;
mod shapes;
mod still;

use bendtwin_core::{
    Contact, Environment, Plane, Point, Twin,
    geometry::{length, scaled},
};
use bendtwin_engine::{
    Model, Motion, World,
    world::{Attachment, Collider, Pose, Region, Shape},
};
use bendtwin_proto::v1::{
    self, RollOutRequest, Tensor, collider::Carrier, roll_out_request::Actions as Wire,
    world::GroundChoice,
};

use self::grasps::HoldContext;
pub use self::still::Still;
pub(crate) use self::{
    ended::Ended,
    holds::Path,
    hull::hull,
    shapes::{sides, three},
};
use crate::{
    error::Error,
    request::{actions::Actions, plausible::Obstacles, vary::Factors},
};

/// Friction and restitution of a collider that does not say.
const FRICTION: f32 = 0.5;
const RESTITUTION: f32 = 0.0;
const UP: Point = [0.0, 0.0, 1.0];

/// Surroundings of the object in the rollouts of a request.
#[derive(Debug, Default)]
pub(crate) struct Surroundings {
    gravity: Option<Point>,
    /// Another ground, or none.
    ground: Option<Option<Plane>>,
    ground_friction: Option<f32>,
    ground_restitution: Option<f32>,
    world: World,
    /// Margins of the colliders [m].
    margins: Vec<f32>,
    /// Grippers that are bodies.
    grippers: usize,
    /// Poses along the paths P at frame boundaries, shape [F + 1, P].
    paths: Vec<Pose>,
    /// True for grasps whose springs are as stiff as the substeps allow, for any mass.
    chosen: Vec<bool>,
    /// When grasps are closed.
    closed: Vec<Closed>,
    /// Knot at or before each frame boundary, shape [F + 1].
    knots: Vec<usize>,
}

/// When a grasp is closed, by knots of the actions.
#[derive(Debug)]
enum Closed {
    Always,
    /// Closings for all instances, shape [K], or [1] for all knots.
    Shared(Vec<u32>),
    /// Shape [B, K].
    Each(Vec<u32>),
}

impl Surroundings {
    /// Reads what surrounds the object in a checked request with these actions to a twin, of which
    /// this model is simulated.
    pub(crate) fn read(
        request: &mut RollOutRequest,
        actions: &Actions,
        map: GripperOfControl,
        twin: &Twin,
        model: &Model,
    ) -> Result<Self, Error> {
        let wire = request.world.take().unwrap_or_default();
        let held = HoldContext { twin, model, map };
        let grasps = std::mem::take(&mut request.grasps);
        let carried = wire.colliders.iter().any(|collider| {
            matches!(collider.carrier, Some(Carrier::Gripper(_) | Carrier::Path(_)))
        });
        let is_moving = carried || !grasps.is_empty();
        let grippers = if is_moving { actions.grippers() } else { 0 };
        let boundaries = actions.knots().len();
        let mut surroundings = Self {
            grippers,
            knots: if grasps.is_empty() { Vec::new() } else { actions.knots() },
            ..Self::without_bodies(&wire)
        };
        let mut paths = Vec::new();
        for (index, collider) in wire.colliders.iter().enumerate() {
            let body = match &collider.carrier {
                None | Some(Carrier::Fixed(_)) => None,
                Some(Carrier::Gripper(number)) => Some(*number),
                Some(Carrier::Path(path)) => {
                    let field = format!("world.colliders[{index}].path");
                    let (_, rows) = path.unpack::<f32>(&field)?;
                    paths.push(actions.along(rows.as_chunks::<7>().0));
                    Some((grippers + paths.len() - 1) as u32)
                }
            };
            surroundings.add_collider(collider, index, body)?;
        }
        surroundings.paths =
            (0..boundaries).flat_map(|frame| paths.iter().map(move |path| path[frame])).collect();
        surroundings.world.bodies = grippers + paths.len();
        for (index, grasp) in grasps.into_iter().enumerate() {
            surroundings.chosen.push(grasp.stiffness == 0.0);
            surroundings.closed.push(closed(grasp.closed.clone(), index)?);
            surroundings.world.grasps.push(grasps::read(grasp, index, &held)?);
        }
        if wants_gradients(request) {
            let smoothing = request.gradient.as_ref().map_or(0.0, |g| g.smoothing_m);
            surroundings.world.smoothing_m = smoothing as f32;
        }
        Ok(surroundings)
    }

    /// Gravity and ground of a checked world, without its colliders.
    pub(crate) fn without_bodies(wire: &v1::World) -> Self {
        Self {
            gravity: (!wire.gravity.is_empty()).then(|| three(&wire.gravity)),
            ground: wire.ground_choice.as_ref().and_then(ground),
            ground_friction: wire.ground_friction,
            ground_restitution: wire.ground_restitution,
            ..Self::default()
        }
    }

    /// Adds the `index`-th collider of a checked request, carried by a body or by none.
    fn add_collider(
        &mut self,
        wire: &v1::Collider,
        index: usize,
        body: Option<u32>,
    ) -> Result<(), Error> {
        self.margins.push(wire.margin_m);
        self.world.colliders.push(Collider {
            body,
            shape: shapes::read(wire, index)?,
            friction: wire.friction.unwrap_or(FRICTION),
            restitution: wire.restitution.unwrap_or(RESTITUTION),
        });
        Ok(())
    }

    /// The environment that takes the place of a model's own, if it differs.
    pub(crate) fn environment(&self, own: Environment) -> Option<Environment> {
        let environment = Environment {
            gravity: self.gravity.unwrap_or(own.gravity),
            ground: self.ground.unwrap_or(own.ground),
        };
        (environment != own).then_some(environment)
    }

    /// Sets the contact parameters that the request gives.
    pub(crate) fn touch(&self, contact: &mut Contact) {
        if let Some(friction) = self.ground_friction {
            contact.ground_friction = friction;
        }
        if let Some(restitution) = self.ground_restitution {
            contact.ground_restitution = restitution;
        }
    }

    /// The world around an object with these factors.
    pub(crate) fn world(&self, factors: Factors) -> World {
        let mut world = self.world.clone();
        for collider in &mut world.colliders {
            collider.friction = factors.friction_of(collider.friction);
        }
        for (grasp, is_chosen) in world.grasps.iter_mut().zip(&self.chosen) {
            grasp.max_force /= factors.mass;
            if let Attachment::Spring { stiffness, damping } = &mut grasp.attachment
                && !is_chosen
            {
                *stiffness /= factors.mass;
                *damping /= factors.mass;
            }
        }
        world
    }

    /// Motion of all that is carried, of an instance.
    pub(crate) fn motion(&self, instance: usize, actions: &Actions) -> Motion {
        if self.world.bodies == 0 {
            return Motion::default();
        }
        let grippers = if self.grippers > 0 { actions.bodies(instance) } else { Vec::new() };
        let paths = self.world.bodies - self.grippers;
        let rows = self.paths.len().checked_div(paths);
        let poses = match rows {
            None => grippers,
            Some(rows) => {
                let row = |frame: usize| {
                    let own = grippers.iter().skip(frame * self.grippers).take(self.grippers);
                    own.chain(&self.paths[frame * paths..(frame + 1) * paths]).copied()
                };
                (0..rows).flat_map(row).collect()
            }
        };
        // During a frame that holds which the knot at or before its start says.
        let frames = self.knots.len().saturating_sub(1);
        let knots = self.knots.iter().take(frames);
        let closed = knots.flat_map(|knot| {
            let count = actions.shape().knots;
            self.closed.iter().map(move |closed| closed.at(instance, *knot, count))
        });
        Motion { poses, closed: closed.collect(), rolls: Vec::new() }
    }

    /// Obstacles that stand still, in an environment.
    pub(crate) fn obstacles(&self, environment: &Environment) -> Obstacles {
        let colliders = self.world.colliders.iter().zip(&self.margins);
        let fixed = colliders.filter(|(collider, _)| collider.body.is_none());
        let shapes = fixed.map(|(collider, margin)| (collider.shape.clone(), *margin));
        Obstacles { ground: environment.ground, shapes: shapes.collect() }
    }

    /// A point on the axis of a capsule that stands still [m], and the direction of the axis; none of other
    /// colliders, or of a capsule without a length.
    pub(crate) fn axis(&self, collider: usize) -> Option<[Point; 2]> {
        let collider = self.world.colliders.get(collider)?;
        match (collider.body, &collider.shape) {
            (None, Shape::Capsule { from, to, .. }) if from != to => {
                Some([*from, unit(std::array::from_fn(|k| to[k] - from[k]))])
            }
            _ => None,
        }
    }

    /// Middles of the spheres and boxes of grasps: the gripper, and the place in its coordinates [m].
    pub(crate) fn places(&self) -> Vec<(usize, Point)> {
        let grasps = self.world.grasps.iter();
        grasps.filter_map(|g| Some((g.body as usize, middle(&g.region)?))).collect()
    }

    /// Middles of the grippers at frame boundaries [m], frame by frame.
    pub(crate) fn middles(&self, motion: &Motion) -> Vec<Point> {
        let middles = self.places();
        if middles.is_empty() {
            return Vec::new();
        }
        let frames = motion.poses.chunks_exact(self.world.bodies);
        frames.flat_map(|poses| middles.iter().map(|(body, p)| moved(&poses[*body], *p))).collect()
    }
}

/// Middle of a sphere or box.
fn middle(region: &Region) -> Option<Point> {
    match region {
        Region::Sphere { center, .. } => Some(*center),
        Region::Box { low, high } => Some(std::array::from_fn(|i| f32::midpoint(low[i], high[i]))),
        Region::Nodes(_) | Region::Controls(_) => None,
    }
}

/// Gripper of each control point, shape [C]; none where there are no grippers.
pub(crate) type GripperOfControl = Option<Vec<u32>>;

/// The grippers that carry control points in a checked request.
pub(crate) fn gripper_of_control(
    wire: Option<&Wire>,
    controls: usize,
) -> Result<GripperOfControl, Error> {
    let Some(Wire::Poses(poses)) = wire else { return Ok(None) };
    match poses.gripper_of_control.as_ref().filter(|t| !t.is_absent()) {
        None => Ok(Some(vec![0; controls])),
        Some(map) => Ok(Some(map.unpack("poses.gripper_of_control")?.1)),
    }
}

impl Closed {
    fn at(&self, instance: usize, knot: usize, knots: usize) -> bool {
        match self {
            Self::Always => true,
            Self::Shared(values) => values[knot.min(values.len() - 1)] != 0,
            Self::Each(values) => values[instance * knots + knot] != 0,
        }
    }
}

fn closed(wire: Option<Tensor>, index: usize) -> Result<Closed, Error> {
    let Some(tensor) = wire.filter(|t| !t.is_absent()) else { return Ok(Closed::Always) };
    let (shape, values) = tensor.unpack(&format!("grasps[{index}].closed"))?;
    Ok(if shape.len() == 1 { Closed::Shared(values) } else { Closed::Each(values) })
}

/// The ground that a request chooses; none if it leaves the twin's own.
fn ground(choice: &GroundChoice) -> Option<Option<Plane>> {
    match choice {
        GroundChoice::NoGround(is_gone) => is_gone.then_some(None),
        GroundChoice::Ground(v1::Plane { normal, offset_m }) => {
            let normal = if normal.is_empty() { UP } else { unit(three(normal)) };
            Some(Some(Plane { normal, offset_m: *offset_m }))
        }
    }
}

fn wants_gradients(request: &RollOutRequest) -> bool {
    request.returns.as_ref().is_some_and(|returns| {
        returns.control_gradients
            || returns.action_gradients
            || returns.initial_gradients
            || returns.gradient_norms
    })
}

/// The unit vector along one that is not zero.
pub(crate) fn unit(direction: Point) -> Point {
    scaled(direction, 1.0 / length(direction).max(f32::MIN_POSITIVE))
}

fn moved(pose: &Pose, p: Point) -> Point {
    pose.map(|[x, y, z, at]| x * p[0] + y * p[1] + z * p[2] + at)
}

#[cfg(test)]
mod tests;
