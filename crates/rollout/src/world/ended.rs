//! Surroundings of a simulation where it ended, which a correction of its last state respects.

use std::sync::Arc;

use bendtwin_budget::Share;
use bendtwin_core::Environment;
use bendtwin_engine::{
    Motion, World,
    model::State,
    world::{Pose, Region, Shape},
};
use bendtwin_register::{Around, PlacedBody};

use super::Surroundings;

/// Memory of a collider or a grasp, of a face, and of a number of a node or control point [bytes].
const PART: usize = 128;
const FACE: usize = 16;
const NUMBER: usize = 4;

/// Surroundings where a simulation ended.
#[derive(Debug)]
pub(crate) struct Ended {
    world: Arc<World>,
    /// Gravity and ground.
    pub(crate) environment: Environment,
    /// Bodies, the grippers first, shape [B].
    bodies: Vec<Option<PlacedBody>>,
    /// Number of grippers among them.
    grippers: usize,
    /// Memory of the world; none in tests.
    _share: Option<Arc<Share>>,
}

impl Ended {
    /// The surroundings where a motion with `frame_s` a frame has ended.
    pub(crate) fn new(
        world: Arc<World>,
        environment: Environment,
        (motion, frame_s): (&Motion, f64),
        grippers: usize,
        share: Option<Arc<Share>>,
    ) -> Self {
        let rows = motion.poses.len();
        let row = |from_end: usize| motion.poses.iter().skip(rows - from_end * world.bodies);
        let bodies = match rows < 2 * world.bodies {
            true => Vec::new(),
            false => row(1).zip(row(2)).map(|(now, before)| moving(now, before, frame_s)).collect(),
        };
        Self { world, environment, bodies, grippers, _share: share }
    }

    /// Surroundings of a state that the simulation has left, with the first grippers at other
    /// poses.
    pub(crate) fn around(&self, state: &State, grippers: &[Pose]) -> Around {
        let mut bodies = self.bodies.clone();
        for (body, pose) in bodies.iter_mut().take(self.grippers).zip(grippers) {
            *body = Some(PlacedBody { pose: *pose, rate: Pose::default() });
        }
        Around::new(&self.world, &bodies, state)
    }
}

fn moving(now: &Pose, before: &Pose, frame_s: f64) -> Option<PlacedBody> {
    let rate = |row: usize, column: usize| {
        (f64::from(now[row][column] - before[row][column]) / frame_s) as f32
    };
    let rate: [[f32; 4]; 3] =
        std::array::from_fn(|row| std::array::from_fn(|column| rate(row, column)));
    Some(PlacedBody { pose: *now, rate })
}

impl Surroundings {
    /// Memory of what stays of it in a session [bytes].
    pub(crate) fn bytes(&self) -> u64 {
        let colliders = self.world.colliders.iter().map(|collider| match &collider.shape {
            Shape::Capsule { .. } => PART,
            Shape::Convex(faces) => PART + FACE * faces.len(),
        });
        let grasps = self.world.grasps.iter().map(|grasp| match &grasp.region {
            Region::Nodes(numbers) | Region::Controls(numbers) => PART + NUMBER * numbers.len(),
            Region::Sphere { .. } | Region::Box { .. } => PART,
        });
        colliders.chain(grasps).sum::<usize>() as u64
    }

    /// Number of grippers that are bodies.
    pub(crate) fn grippers(&self) -> usize {
        self.grippers
    }
}
