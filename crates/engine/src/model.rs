//! A model is the constant half of a simulation; the state is the changing half.

use std::sync::Arc;

use bendtwin_core::{
    Environment, Graph, Params, Plane, Point, Skin, Timing, Twin, environment::ControlVelocity,
};

use crate::{constants::ON_GROUND_M, world::Grasping};

/// The part of a simulation that stays constant during a rollout.
#[derive(Clone, Debug, PartialEq)]
pub struct Model {
    /// Topology and rest geometry; shared by all candidates of a fit.
    pub graph: Arc<Graph>,
    /// Surface points that the nodes carry; empty where no term or output asks for them.
    pub skin: Arc<Skin>,
    /// Fitted numbers.
    pub params: Params,
    /// Gravity and ground.
    pub environment: Environment,
    /// Frame rate and substeps.
    pub timing: Timing,
    /// Velocity of control points in dashpots.
    pub control_velocity: ControlVelocity,
}

impl From<&Twin> for Model {
    fn from(twin: &Twin) -> Self {
        Self {
            graph: Arc::new(twin.graph.clone()),
            skin: Arc::new(twin.skin.clone()),
            params: twin.params.clone(),
            environment: twin.environment,
            timing: twin.timing,
            control_velocity: twin.control_velocity,
        }
    }
}

/// Nodes on a ground: less than 1 mm above it, they or a point of the skin that they bear, if there is
/// a skin that touches.
pub fn ground_contacts(ground: &Plane, skin: Option<&Skin>, positions: &[Point]) -> u32 {
    let is_low = |x: &Point| {
        let height: f32 = x.iter().zip(ground.normal).map(|(x, n)| x * n).sum();
        height - ground.offset_m < ON_GROUND_M as f32
    };
    let mut touching: Vec<bool> = positions.iter().map(is_low).collect();
    if let Some(skin) = skin {
        let points = skin.positions(positions);
        for (p, _) in points.iter().enumerate().filter(|(_, x)| is_low(x)) {
            skin.bearers(p).for_each(|node| touching[node as usize] = true);
        }
    }
    touching.iter().filter(|touches| **touches).count() as u32
}

/// Positions and velocities of all nodes, twists of all rods, and what grasps hold.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct State {
    /// Positions [m], shape [N, 3].
    pub positions: Vec<Point>,
    /// Velocities [m/s], shape [N, 3].
    pub velocities: Vec<Point>,
    /// Twist of each rod relative to an earlier state without twist [rad], shape [R], turns of its
    /// clamps included. A rod that is twisted only in part, since its clamps are not at its ends,
    /// counts as if the same twist per length applied to all of it. May be empty at the start of a
    /// rollout: no rod is twisted. States that a backend returns have all of them.
    pub twists: Vec<f32>,
    /// Phases and holds of grasps. It belongs to the [`World`](crate::World) of the rollout that it came from.
    pub grasping: Grasping,
}

impl State {
    /// The rest shape, neither moving nor twisted.
    pub fn rest(graph: &Graph) -> Self {
        Self {
            positions: graph.rest_positions.clone(),
            velocities: vec![[0.0; 3]; graph.node_count()],
            twists: vec![0.0; graph.rods.len()],
            grasping: Grasping::default(),
        }
    }
}
