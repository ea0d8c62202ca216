//! Paths of the nodes that grasps hold exactly, as far as they are known without simulating: of the
//! nodes that are held at the start, or taken there, until their grasp opens, and of those that are
//! held at the end, from when it closed. Such nodes pass through anything in their way, so the
//! paths show whether they are carried into an obstacle.

use bendtwin_core::{Graph, Point};
use bendtwin_engine::{
    World,
    backend::Instance,
    model::State,
    world::{Attachment, Grasp, Hold, Phase, Pose, Region},
};

use super::{Surroundings, moved};

/// A node's positions at successive frame boundaries.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Path {
    /// The first of the boundaries.
    pub(crate) from: usize,
    /// Positions [m].
    pub(crate) points: Vec<Point>,
}

impl Surroundings {
    /// True if a grasp holds nodes exactly.
    pub(crate) fn has_pins(&self) -> bool {
        self.world.grasps.iter().any(is_pin)
    }

    /// Paths of the nodes that grasps of an instance hold exactly; `end` is the state after its last
    /// frame, if that is known.
    pub(crate) fn held_paths(&self, instance: &Instance, end: Option<&State>) -> Vec<Path> {
        let (world, motion) = (&self.world, &instance.motion);
        if !self.has_pins() {
            return Vec::new();
        }
        let frames = motion.closed.len() / world.grasps.len();
        let is_open = |f: &usize, g: u32| !motion.closed[f * world.grasps.len() + g as usize];
        let mut paths = Vec::new();
        let mut add = |hold: &Hold, from: usize, to: usize| {
            let grasp = world.grasps.get(hold.grasp as usize).filter(|g| is_pin(g));
            if let Some(grasp) = grasp {
                let poses = motion.poses.iter().skip(grasp.body as usize).step_by(world.bodies);
                let poses = poses.skip(from).take(to + 1 - from);
                paths.push(Path { from, points: poses.map(|p| moved(p, hold.place)).collect() });
            }
        };
        if frames > 0 {
            // It is unknown when a grasp that may slip has released.
            let graph = &instance.model.model().graph;
            let start = held_at_start(world, graph, instance);
            for hold in start.iter().filter(|h| !may_slip(world, h)) {
                add(hold, 0, (0..frames).find(|f| is_open(f, hold.grasp)).unwrap_or(frames));
            }
        }
        for hold in end.iter().flat_map(|state| &state.grasping.holds) {
            let opened = (0..frames).rev().find(|f| is_open(f, hold.grasp));
            if opened.is_some() || may_slip(world, hold) {
                add(hold, opened.map_or(0, |f| f + 1), frames);
            }
        }
        paths
    }
}

fn is_pin(grasp: &Grasp) -> bool {
    grasp.attachment == Attachment::Pin && !matches!(grasp.region, Region::Controls(_))
}

fn may_slip(world: &World, hold: &Hold) -> bool {
    world.grasps.get(hold.grasp as usize).is_some_and(|g| g.max_force.is_finite())
}

/// Nodes that grasps hold when a rollout begins: those of the state whose grasps stay closed, and
/// those that grasps take which close then, each the nodes of its region that nothing else holds.
fn held_at_start(world: &World, graph: &Graph, instance: &Instance) -> Vec<Hold> {
    let (motion, state) = (&instance.motion, &instance.initial);
    let closes = |g: usize| motion.closed.get(g).copied().unwrap_or(false);
    let phase = |g: usize| state.grasping.phases.get(g).copied().unwrap_or_default();
    let known = state.grasping.holds.iter().copied();
    let mut holds: Vec<Hold> = known.filter(|hold| closes(hold.grasp as usize)).collect();
    let mut is_held = vec![false; state.positions.len()];
    let held = holds.iter().map(|hold| hold.node).chain(graph.pins.iter().map(|pin| pin.node));
    for node in held {
        if let Some(is_held) = is_held.get_mut(node as usize) {
            *is_held = true;
        }
    }
    for (g, grasp) in world.grasps.iter().enumerate() {
        if !closes(g) || phase(g) != Phase::Open {
            continue;
        }
        let Some(pose) = motion.poses.get(grasp.body as usize) else { continue };
        for (node, x) in state.positions.iter().enumerate() {
            let place = placed(pose, *x);
            if !is_held[node] && contains(&grasp.region, node as u32, place) {
                is_held[node] = true;
                holds.push(Hold { node: node as u32, grasp: g as u32, place });
            }
        }
    }
    holds
}

/// A point in a body's coordinates.
fn placed(pose: &Pose, x: Point) -> Point {
    let way: Point = std::array::from_fn(|row| x[row] - pose[row][3]);
    std::array::from_fn(|column| (0..3).map(|row| pose[row][column] * way[row]).sum())
}

/// True if a node at this place is in the region.
fn contains(region: &Region, node: u32, place: Point) -> bool {
    match region {
        Region::Sphere { center, radius_m } => {
            let square: f32 = place.iter().zip(center).map(|(x, c)| (x - c).powi(2)).sum();
            square <= radius_m * radius_m
        }
        Region::Box { low, high } => {
            (0..3).all(|axis| low[axis] <= place[axis] && place[axis] <= high[axis])
        }
        Region::Nodes(nodes) => nodes.binary_search(&node).is_ok(),
        Region::Controls(_) => false,
    }
}
