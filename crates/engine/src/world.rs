//! The surroundings of an object in a rollout: rigid bodies on prescribed paths, the colliders and
//! grasps that they carry, and how a contact is computed.
//!
//! **Bodies.** A body is a rigid, kinematic frame of reference: a gripper, a moving tool. Its poses
//! are given at frame boundaries, as those of control points are; within a frame the entries of its
//! pose matrix are interpolated linearly, so that a point of the body moves on a straight line with
//! constant velocity, as a control point does. For rotations of 10° a frame a body is thereby up to
//! 0.4 % too small in the middle of a frame.

use std::sync::Arc;

use bendtwin_core::Point;

use crate::Model;

/// Pose of a rigid body: rows of the matrix [R | p], so that a point `x` of the body is at
/// `R x + p` [m]. Gradients by a pose have the same shape, entry by entry.
pub type Pose = [[f32; 4]; 3];

/// The pose of a body that coincides with the world.
pub const IDENTITY: Pose = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];

/// Most bodies, colliders and grasps of a world, each.
pub const MAX_PARTS: usize = 32;
/// Most faces of a convex collider.
pub const MAX_FACES: usize = 128;

/// A half space `normal · x <= offset_m`, bounded by a face of a convex shape.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Face {
    /// Unit normal, outward.
    pub normal: Point,
    /// Distance of the face from the origin along the normal [m].
    pub offset_m: f32,
}

/// A shape in the coordinates of the body that carries it.
#[derive(Clone, Debug, PartialEq)]
pub enum Shape {
    /// Points nearer than `radius_m` to the segment from `from` to `to`; a sphere where the two are
    /// equal.
    Capsule {
        /// Start of the axis [m].
        from: Point,
        /// The other end [m].
        to: Point,
        /// Radius [m].
        radius_m: f32,
    },
    /// The common part of half spaces: a box, a convex mesh. The distance of a point outside is that
    /// to the plane that is farthest, so near edges it is less than the Euclidean one; its sign is
    /// exact.
    Convex(Arc<Vec<Face>>),
}

/// A rigid obstacle that nodes cannot enter.
#[derive(Clone, Debug, PartialEq)]
pub struct Collider {
    /// The body that carries it; `None` stands in the world.
    pub body: Option<u32>,
    /// The shape, including the margin that nodes are to keep.
    pub shape: Shape,
    /// Coulomb friction, 0..=2.
    pub friction: f32,
    /// Restitution, 0..=1.
    pub restitution: f32,
}

/// The part of space, or of the object, that a grasp takes hold of when it closes.
#[derive(Clone, Debug, PartialEq)]
pub enum Region {
    /// Nodes in a sphere around a point of the body.
    Sphere {
        /// Centre in the body's coordinates [m].
        center: Point,
        /// Radius [m].
        radius_m: f32,
    },
    /// Nodes in a box along the body's axes.
    Box {
        /// Least corner in the body's coordinates [m].
        low: Point,
        /// Greatest corner [m].
        high: Point,
    },
    /// These nodes, at any place.
    Nodes(Arc<Vec<u32>>),
    /// The twin's own control points with these numbers, by the springs and pins that the twin has
    /// for them. While the grasp is open these springs exert no force and these pins hold nothing.
    /// Once open it stays open. Control points in no grasp always hold.
    Controls(Arc<Vec<u32>>),
}

/// The way in which a grasp holds a node. [`Region::Controls`] hold as the twin does.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Attachment {
    /// The node moves with the body exactly.
    Pin,
    /// A spring of rest length zero between the node and its place on the body, with a dashpot:
    /// f = -stiffness (x - place) - damping (v - v_place).
    Spring {
        /// Stiffness [N/m at unit node mass].
        stiffness: f32,
        /// Damping [N s/m at unit node mass].
        damping: f32,
    },
}

/// A hold on nodes by a body, which opens and closes at frame boundaries ([`Motion::closed`]).
/// When it closes it takes the nodes of its region that nothing else holds, each where it is. Two
/// neighbouring nodes of a rod in one grasp, or held by control points, are a clamp: the grasp gives
/// the rod its direction there, and turns it. A rod is twisted between its outermost two clamps;
/// without them it has no torque, and its twist is that of its rest.
#[derive(Clone, Debug, PartialEq)]
pub struct Grasp {
    /// The body that carries it.
    pub body: u32,
    /// Region that it takes hold of.
    pub region: Region,
    /// Kind of its holds.
    pub attachment: Attachment,
    /// Mean force over a frame beyond which the grasp releases at the end of that frame [N at unit
    /// node mass]; infinite for never. It stays open until it is commanded to open and to close
    /// again.
    pub max_force: f32,
}

/// Share of the stability criterion `dt² k + 2 dt c <= 4` (see `stability`) that a spring of a grasp
/// may take at a node of unit mass: half of what the margin of a loaded model leaves.
const SPRING_CRITERION: f64 = 0.08;

/// Share that a spring of a grasp takes of what is allowed at the model's substep; at most 1 is
/// stable, independent of the model's own springs.
pub fn spring_share(model: &Model, stiffness: f32, damping: f32) -> f32 {
    let dt = model.timing.dt_s();
    let lightest = model.graph.masses.iter().fold(f32::INFINITY, |m, x| m.min(*x));
    let taken = dt * dt * f64::from(stiffness) + 2.0 * dt * f64::from(damping);
    (taken / (SPRING_CRITERION * f64::from(lightest))) as f32
}

/// The largest stiffness of a grasp's spring without damping [N/m at unit node mass]. With damping,
/// both are allowed where [`spring_share`] is at most 1.
pub fn largest_stiffness(model: &Model) -> f32 {
    spring_share(model, 1.0, 0.0).recip()
}

/// The surroundings of an object that are constant during a rollout.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct World {
    /// Number of bodies B.
    pub bodies: usize,
    /// Colliders, shape [K].
    pub colliders: Vec<Collider>,
    /// Grasps, shape [G].
    pub grasps: Vec<Grasp>,
    /// Width of the layer in which ground and colliders act [m]; 0 for impacts, as fitted. With a
    /// width contact is a smooth force (`cpu/collision/smooth.rs` has the formula), and so are gradients.
    pub smoothing_m: f32,
}

/// The part of the surroundings that changes during a rollout of F frames.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Motion {
    /// Poses of bodies at frame boundaries, shape [F + 1, B].
    pub poses: Vec<Pose>,
    /// True if a grasp is closed during a frame, shape [F, G].
    pub closed: Vec<bool>,
    /// Turn of the near and of the far clamp of each rod about the rod there, by the right hand along
    /// the rod, since the start [rad], shape [F + 1, R, 2]; empty if no clamp turns: a rod that is
    /// turned as one body keeps its twist. The part that the directions of the clamps
    /// have in the twist is known from the nodes, and does not belong here. It counts for a clamp
    /// while control points hold it; how a grasp turns what it holds is known from its body.
    pub rolls: Vec<f32>,
}

/// State of a grasp between two frames.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[repr(u8)]
pub enum Phase {
    /// Holds nothing. The default for [`Region::Controls`], which stand for a hold that has not
    /// been opened yet, is [`Phase::Closed`].
    #[default]
    Open = 0,
    /// Holds the nodes that it took when it closed.
    Closed = 1,
    /// Released because of a force; waits for a command to open.
    Slipped = 2,
}

/// A node in a grasp.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hold {
    /// The node.
    pub node: u32,
    /// The grasp that holds it.
    pub grasp: u32,
    /// Place in the coordinates of the grasp's body [m].
    pub place: Point,
}

/// The grasps as a part of a state.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Grasping {
    /// Phase of each grasp, shape [G]; empty: [`Phase::Closed`] for [`Region::Controls`], open for
    /// all others.
    pub phases: Vec<Phase>,
    /// The nodes in grasps, by node; none twice.
    pub holds: Vec<Hold>,
}
