//! Objectives of rollouts: both a fit's loss and a planner's cost are weighted terms, each on the
//! node positions at the end of one frame.

use std::sync::Arc;

use bendtwin_core::Point;

use crate::cpu::{
    arithmetic::{Node, quad},
    loss,
};

/// The loss of a distance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PointLoss {
    /// Smooth L1 per coordinate, mean over coordinates: d²/(2 beta) below beta, |d| - beta/2 above.
    SmoothL1 {
        /// Distance at which the loss turns from quadratic to linear [m]; 0 is plain L1.
        beta_m: f32,
    },
    /// Euclidean distance [m].
    Distance,
    /// Squared Euclidean distance [m²].
    SquaredDistance,
}

/// The points of an object that a term is about.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum PointSet {
    /// The nodes; those of the surface where a nearest one is sought.
    #[default]
    Nodes,
    /// The points of the model's skin.
    Skin,
}

/// A term of an objective.
#[derive(Clone, Debug, PartialEq)]
pub enum Term {
    /// Mean over target points of the squared distance [m²] to the nearest point of the surface
    /// (one-sided Chamfer).
    Chamfer {
        /// Points of the surface.
        of: PointSet,
        /// Target points [m], shape [M, 3].
        targets: Vec<Point>,
    },
    /// Mean over pairs of the loss between a point and its target.
    Track {
        /// Set of the points.
        of: PointSet,
        /// Point of each pair, shape [M].
        points: Vec<u32>,
        /// Target of each pair [m], shape [M, 3].
        targets: Vec<Point>,
        /// Loss of a difference.
        loss: PointLoss,
    },
    /// Mean over all nodes of the squared second difference of positions over
    /// three consecutive frames [m²]; zero before the second frame.
    Acceleration,
    /// Mean over springs between two nodes of max(0, |l/l0 - 1| - limit)².
    Strain {
        /// Strain up to which it is zero.
        limit: f32,
    },
    /// Mean over nodes of the squared distance [m²] to a half space, zero within:
    /// max(0, offset - normal · x)².
    Above {
        /// Nodes; `None` means all.
        nodes: Option<Arc<Vec<u32>>>,
        /// Unit normal, into the half space.
        normal: Point,
        /// Distance of its plane from the origin along the normal [m].
        offset_m: f32,
    },
    /// Mean over nodes of the squared distance [m²] to a box along the axes, zero within.
    Within {
        /// Nodes; `None` means all.
        nodes: Option<Arc<Vec<u32>>>,
        /// Least corner [m].
        low: Point,
        /// Greatest corner [m].
        high: Point,
    },
    /// Mean over nodes of max(0, margin - distance)² to a collider of the world [m²].
    Clearance {
        /// Collider.
        collider: u32,
        /// Distance from which on it is zero [m].
        margin_m: f32,
    },
    /// max(0, |f| - limit)² of the mean force f over the frame that ends here [N² at unit node
    /// mass]; zero in frame 0.
    Force {
        /// Source of the force.
        by: ForceBy,
        /// Force up to which it is zero [N at unit node mass].
        limit: f32,
    },
    /// Mean over neighbours in a list of max(0, gap - direction · (x(next) - x))² [m²].
    Order {
        /// Set of the points.
        of: PointSet,
        /// Points in their wanted order, shape [M].
        points: Arc<Vec<u32>>,
        /// Unit vector.
        direction: Point,
        /// Distance along it from a point to the next from which on it is zero [m].
        gap_m: f32,
    },
    /// (turns - wanted turns)² of a chain of points around a line. The turns are the sum over
    /// neighbours of the angle from one to the next about the line, each in -pi..pi, over 2 pi.
    /// Neighbours of which one is within [`LEAST_RADIUS_M`](crate::constants::LEAST_RADIUS_M) of the
    /// line have no angle: it counts as zero.
    Winding {
        /// Set of the points.
        of: PointSet,
        /// Points of the chain, in its order, shape [M].
        points: Arc<Vec<u32>>,
        /// A point on the line [m].
        origin: Point,
        /// Direction of the line, a unit vector; turns are counter-clockwise seen against it.
        direction: Point,
        /// Wanted turns.
        turns: f32,
    },
    /// Mean over target points of 1 - exp(-d² / (2 reach²)), with the distance d to the nearest point
    /// of the surface; 1 without a surface.
    Coverage {
        /// Points of the surface.
        of: PointSet,
        /// Target points [m], shape [M, 3].
        targets: Arc<Vec<Point>>,
        /// Distance at which a target point counts as 39 % uncovered [m].
        reach_m: f32,
    },
}

/// The value of [`Term::Acceleration`] [m²] with the current positions and those one and two frames
/// earlier [m], shape [N, 3] each: for the first frame of a rollout that resumes at another's end
/// and lacks its earlier frames.
pub fn acceleration(now: &[Point], one: &[Point], two: &[Point]) -> f64 {
    let nodes = |points: &[Point]| -> Vec<Node<f32>> {
        points.iter().map(|&p| Node { x: quad(p), v: [0.0; 4] }).collect()
    };
    loss::acceleration(&nodes(now), &nodes(one), &nodes(two))
}

/// Source of a force on the object.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ForceBy {
    /// All control points together.
    Controls,
    /// A control point.
    Control(u32),
    /// A grasp of the world.
    Grasp(u32),
    /// The ground.
    Ground,
    /// A collider of the world.
    Collider(u32),
}

/// A term with its weight and frame.
#[derive(Clone, Debug, PartialEq)]
pub struct WeightedTerm {
    /// Frame of the rollout at whose end the term counts, 1-based: frame `f`
    /// is the state after `f` frames; 0 is the initial state.
    pub frame: usize,
    /// Weight.
    pub weight: f32,
    /// Reported group that the value is added to (see [`Objective::groups`]).
    pub group: usize,
    /// The term.
    pub term: Term,
}

/// A sum of weighted terms. Empty terms (no targets) count as zero.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Objective {
    /// Names of the groups in which values are reported, for example `chamfer` and `track`.
    pub groups: Vec<String>,
    /// Terms, ordered by frame.
    pub terms: Arc<Vec<WeightedTerm>>,
}
