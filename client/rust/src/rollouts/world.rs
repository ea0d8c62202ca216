//! The surroundings of an object in a rollout: ground, gravity, colliders and grasps. Shapes are in
//! metres, in the coordinates of what carries them; what is wrong with them is left to the server to
//! refuse.

use bendtwin_core::Point;
use bendtwin_proto::v1::{
    self, Tensor,
    collider::{self, Carrier},
    grasp::{Attachment, CaptureHand, Region},
    world::GroundChoice,
};

/// A pose: x, y, z [m], quaternion x, y, z, w.
pub type WirePose = [f32; 7];

/// A shape of a collider.
#[derive(Clone, Debug, PartialEq)]
pub struct Shape(pub(crate) collider::Shape);

impl Shape {
    /// A ball [m].
    pub fn sphere(center: Point, radius_m: f32) -> Self {
        Self(collider::Shape::Sphere(v1::Sphere { center: center.to_vec(), radius_m }))
    }

    /// Points nearer than the radius to a segment [m].
    pub fn capsule(from: Point, to: Point, radius_m: f32) -> Self {
        let (from, to) = (from.to_vec(), to.to_vec());
        Self(collider::Shape::Capsule(v1::Capsule { from, to, radius_m }))
    }

    /// A box along the axes, by its least and greatest corner [m].
    pub fn cuboid(low: Point, high: Point) -> Self {
        let (low, high) = (low.to_vec(), high.to_vec());
        Self(collider::Shape::Cuboid(v1::Cuboid { low, high }))
    }

    /// The convex hull of points [m].
    pub fn convex(points: &[Point]) -> Self {
        let points = Some(Tensor::pack_points(&[points.len()], points));
        Self(collider::Shape::ConvexMesh(v1::ConvexMesh { points }))
    }
}

/// A rigid obstacle, which stands still unless something carries it.
#[derive(Clone, Debug, PartialEq)]
pub struct Collider(v1::Collider);

impl Collider {
    /// An obstacle of this shape.
    pub fn new(shape: Shape) -> Self {
        Self(v1::Collider { shape: Some(shape.0), ..v1::Collider::default() })
    }

    /// Coulomb friction, 0..=2, and restitution, 0..=1.
    #[must_use]
    pub fn surface(mut self, friction: f32, restitution: f32) -> Self {
        (self.0.friction, self.0.restitution) = (Some(friction), Some(restitution));
        self
    }

    /// Distance that nodes keep from the shape [m].
    #[must_use]
    pub fn margin(mut self, margin_m: f32) -> Self {
        self.0.margin_m = margin_m;
        self
    }

    /// Pose of the shape on what carries it.
    #[must_use]
    pub fn at(mut self, pose: WirePose) -> Self {
        self.0.pose = pose.to_vec();
        self
    }

    /// Carried by a gripper.
    #[must_use]
    pub fn on_gripper(mut self, gripper: u32) -> Self {
        self.0.carrier = Some(Carrier::Gripper(gripper));
        self
    }

    /// Moves along poses at the knots of the actions, shape [K].
    #[must_use]
    pub fn along(mut self, path: &[WirePose]) -> Self {
        let path = Tensor::pack(&[path.len(), 7], path.as_flattened());
        self.0.carrier = Some(Carrier::Path(path));
        self
    }
}

/// Surroundings of the object; the rest is as in the twin.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct World(pub(crate) v1::World);

impl World {
    /// Adds a collider.
    #[must_use]
    pub fn collider(mut self, collider: Collider) -> Self {
        self.0.colliders.push(collider.0);
        self
    }

    /// Gravity [m/s²].
    #[must_use]
    pub fn gravity(mut self, gravity: Point) -> Self {
        self.0.gravity = gravity.to_vec();
        self
    }

    /// A ground below points with `normal · x >= offset_m`, for a normal of length 1.
    #[must_use]
    pub fn ground(mut self, normal: Point, offset_m: f32) -> Self {
        let plane = v1::Plane { normal: normal.to_vec(), offset_m };
        self.0.ground_choice = Some(GroundChoice::Ground(plane));
        self
    }

    /// No ground.
    #[must_use]
    pub fn without_ground(mut self) -> Self {
        self.0.ground_choice = Some(GroundChoice::NoGround(true));
        self
    }

    /// Coulomb friction of the ground, 0..=2, and its restitution, 0..=1.
    #[must_use]
    pub fn ground_surface(mut self, friction: f32, restitution: f32) -> Self {
        (self.0.ground_friction, self.0.ground_restitution) = (Some(friction), Some(restitution));
        self
    }
}

/// A hold of a gripper on the object.
#[derive(Clone, Debug, PartialEq)]
pub struct Grasp(pub(crate) v1::Grasp);

impl Grasp {
    /// Takes the nodes in a sphere in the coordinates of a gripper [m].
    pub fn sphere(gripper: u32, center: Point, radius_m: f32) -> Self {
        let sphere = v1::Sphere { center: center.to_vec(), radius_m };
        Self::new(gripper, Region::Sphere(sphere))
    }

    /// Takes the nodes in a box in the coordinates of a gripper [m].
    pub fn cuboid(gripper: u32, low: Point, high: Point) -> Self {
        let (low, high) = (low.to_vec(), high.to_vec());
        Self::new(gripper, Region::Cuboid(v1::Cuboid { low, high }))
    }

    /// Takes these nodes.
    pub fn nodes(gripper: u32, nodes: &[u32]) -> Self {
        Self::new(gripper, Region::Nodes(Tensor::pack(&[nodes.len()], nodes)))
    }

    /// The twin's own control points of a hand of its capture.
    pub fn hand(gripper: u32, hand: u32) -> Self {
        Self::new(gripper, Region::Hand(CaptureHand { hand }))
    }

    /// Holds by springs [N/m a node] and dashpots [N s/m] instead of exactly; 0 chooses what the
    /// twin's substeps allow.
    #[must_use]
    pub fn springs(mut self, stiffness: f32, damping: f32) -> Self {
        self.0.attachment = Attachment::Springs.into();
        (self.0.stiffness, self.0.damping) = (stiffness, damping);
        self
    }

    /// Closed from each knot of the actions on, or open, of all instances, shape [K].
    #[must_use]
    pub fn closed(mut self, closed: &[bool]) -> Self {
        let values: Vec<u32> = closed.iter().map(|is| u32::from(*is)).collect();
        self.0.closed = Some(Tensor::pack(&[values.len()], &values));
        self
    }

    /// Releases above this force, mean over a frame [N].
    #[must_use]
    pub fn max_force(mut self, newtons: f64) -> Self {
        self.0.max_force_n = Some(newtons);
        self
    }

    fn new(gripper: u32, region: Region) -> Self {
        Self(v1::Grasp { gripper, region: Some(region), ..v1::Grasp::default() })
    }
}

/// Parameters as factors of the twin's own, by instance, or by member of an ensemble; empty: 1.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Vary {
    /// Axial stiffness.
    pub stiffness: Vec<f32>,
    /// Dashpots, drag, and damping of bending and twist.
    pub damping: Vec<f32>,
    /// Stiffness of bending and twist.
    pub bending: Vec<f32>,
    /// Friction with ground, colliders and other nodes.
    pub friction: Vec<f32>,
    /// Mass of all nodes.
    pub mass: Vec<f32>,
    /// No factor: the restitution of the ground, 0 to 1, in the place of the twin's and the world's.
    pub ground_restitution: Vec<f32>,
    /// No factor: the restitution between nodes, 0 to 1, in the place of the twin's.
    pub object_restitution: Vec<f32>,
}

impl From<Vary> for v1::Vary {
    fn from(vary: Vary) -> Self {
        let packed =
            |values: &[f32]| (!values.is_empty()).then(|| Tensor::pack(&[values.len()], values));
        Self {
            stiffness: packed(&vary.stiffness),
            damping: packed(&vary.damping),
            bending: packed(&vary.bending),
            friction: packed(&vary.friction),
            mass: packed(&vary.mass),
            ground_restitution: packed(&vary.ground_restitution),
            object_restitution: packed(&vary.object_restitution),
            fits: false,
        }
    }
}

/// A statistic of the costs of the members of an ensemble, or of their motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Statistic {
    /// Their mean.
    Mean,
    /// The worst.
    Worst,
    /// The mean of a share of the worst, above 0 and at most 1.
    Cvar(f64),
    /// The mean motion of the members, to which arrays then belong, and its costs: fits of a twin
    /// have weights of one over the square of their loss, any others equal ones.
    MeanPrediction,
}

impl Statistic {
    pub(super) fn of(self, members: u32) -> v1::Ensemble {
        use v1::ensemble::Statistic as Wire;
        let (statistic, share) = match self {
            Self::Mean => (Wire::Mean, 0.0),
            Self::Worst => (Wire::Worst, 0.0),
            Self::Cvar(share) => (Wire::Cvar, share),
            Self::MeanPrediction => (Wire::MeanPrediction, 0.0),
        };
        v1::Ensemble { members, statistic: statistic.into(), share }
    }
}
