//! Objectives of rollouts: a fit's loss and a planner's cost alike are weighted terms, each on the
//! node positions at the end of one frame.

use std::sync::Arc;

use bendtwin_core::Point;

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

/// One term of an objective.
#[derive(Clone, Debug, PartialEq)]
pub enum Term {
    /// Mean over target points of the squared distance [m²] to the nearest
    /// surface node (one-sided Chamfer).
    Chamfer {
        /// Target points [m], shape [M, 3].
        targets: Vec<Point>,
    },
    /// Mean over pairs of the loss between a node and its target.
    Track {
        /// Node of each pair, shape [M].
        nodes: Vec<u32>,
        /// Target of each pair [m], shape [M, 3].
        targets: Vec<Point>,
        /// Loss of a difference.
        loss: PointLoss,
    },
    /// Mean over all nodes of the squared second difference of positions over
    /// three consecutive frames [m²]; zero before the second frame.
    Acceleration,
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
