//! The rope that is moved: a twin with other parameters than the planner's, and where it is now.

use anyhow::Context as _;
use bendtwin_client::{Point, Reply, Rollout, Rollouts, TwinId, TwinModel};
use bendtwin_core::geometry::{add, distance};
use bendtwin_plan::Knots;

use crate::demo::steps::farthest;

/// Frames in which a rope comes to rest.
const SETTLE: u32 = 30;

/// The rope, and where it is now.
pub(super) struct Rope {
    rollouts: Rollouts,
    twin: TwinId,
    /// Control points where the loop began [m].
    start: Vec<Point>,
    /// Nodes [m], their velocities [m/s] and twists of rods [rad].
    pub(super) positions: Vec<Point>,
    velocities: Vec<Point>,
    twists: Vec<f32>,
    /// The node at its free end.
    pub(super) end: u32,
}

/// The twin with other stiffnesses.
pub(super) fn altered(twin: &TwinModel) -> TwinModel {
    let mut altered = twin.clone();
    altered.params.spring_stiffness.iter_mut().for_each(|k| *k *= 1.3);
    altered.params.bend_stiffness.iter_mut().for_each(|k| *k *= 0.6);
    altered
}

impl Rope {
    /// The rope once it has come to rest, held at the control points.
    pub(super) async fn lying_still(
        rollouts: Rollouts,
        twin: TwinId,
        model: &TwinModel,
    ) -> anyhow::Result<Self> {
        let graph = &model.graph;
        let end = farthest(&graph.rest_positions, &graph.control_rest);
        let mut rope = Self {
            rollouts,
            twin,
            start: graph.control_rest.clone(),
            positions: graph.rest_positions.clone(),
            velocities: vec![[0.0; 3]; graph.node_count()],
            twists: Vec::new(),
            end: end.context("the twin has no nodes")? as u32,
        };
        let still = Rollout::of(twin)
            .trajectories([1, 2, rope.start.len()], rope.controls(&[0.0; 6]))
            .frames(SETTLE);
        rope.take(rope.rollouts.run(still.final_state()).await?)?;
        Ok(rope)
    }

    /// Place at which the end of the rope rests after the hands have moved by `moved` [m].
    pub(super) async fn after(&self, moved: Point) -> anyhow::Result<Point> {
        let [x, y, z] = moved.map(f64::from);
        let there = vec![0.0, 0.0, 0.0, x, y, z, x, y, z];
        let request = self.ahead(self.twin, &[there], 2 * SETTLE as usize);
        let reply = self.rollouts.run(request.final_state()).await?;
        let end = reply.final_positions.get(self.end as usize).copied();
        end.context("the reply has no final state")
    }

    /// A batch of plans, offsets of all control points [m], from where the rope is.
    pub(super) fn ahead(&self, twin: TwinId, plans: &[Knots], frames: usize) -> Rollout {
        let knots = plans.first().map_or(0, |plan| plan.len() / 3);
        let positions = plans.iter().flat_map(|plan| self.controls(plan)).collect();
        let shape = [plans.len(), knots, self.start.len()];
        let request = Rollout::of(twin).trajectories(shape, positions).frames(frames as u32);
        let request = request.from_state(&self.positions, &self.velocities);
        if self.twists.is_empty() { request } else { request.twisted(&self.twists) }
    }

    /// Moves the hands along offsets by frame, shape [F + 1, 3].
    pub(super) async fn follow(&mut self, path: &[f64]) -> anyhow::Result<()> {
        let frames = (path.len() / 3).saturating_sub(1);
        let request = self.ahead(self.twin, &[path.to_vec()], frames);
        let reply = self.rollouts.run(request.final_state()).await?;
        self.take(reply)
    }

    pub(super) fn tip(&self) -> Point {
        self.positions.get(self.end as usize).copied().unwrap_or_default()
    }

    pub(super) fn distance_to(&self, goal: Point) -> f64 {
        f64::from(distance(self.tip(), goal))
    }

    fn take(&mut self, reply: Reply) -> anyhow::Result<()> {
        anyhow::ensure!(
            reply.final_positions.len() == self.positions.len(),
            "the reply has no final state"
        );
        self.positions = reply.final_positions;
        self.velocities = reply.final_velocities;
        self.twists = reply.final_twists;
        Ok(())
    }

    fn controls(&self, offsets: &[f64]) -> Vec<Point> {
        let knots = offsets.chunks_exact(3).map(|o| [o[0] as f32, o[1] as f32, o[2] as f32]);
        knots.flat_map(|offset| self.start.iter().map(move |p| add(*p, offset))).collect()
    }
}
