//! Runs a finely divided model on a backend and returns its trajectory.

use std::sync::Arc;

use bendtwin_core::{
    CancelToken, Contact, Environment, Graph, NodeKind, Params, Pin, Point, Timing,
    environment::ControlVelocity,
};
use bendtwin_engine::{
    Backend, Model, Objective,
    backend::{Instance, Outputs},
    model::State,
    stable_substeps,
};

use crate::Error;

/// Shorter steps than stability asks for, for accuracy.
const SAFETY: f64 = 1.1;

/// The material of a simulated body, per unit node mass.
#[derive(Clone, Debug, Default)]
pub(super) struct Material {
    /// Stiffness of each spring [N per unit strain].
    pub(super) stiffness: Vec<f32>,
    /// Dashpot of each spring [N s/m].
    pub(super) dashpot: Vec<f32>,
    /// Bending triplets, stiffness [N m/rad] and damping [N m s/rad] of each.
    pub(super) triplets: Vec<[u32; 3]>,
    pub(super) bend_stiffness: f32,
    pub(super) bend_damping: f32,
    /// Velocity decay [1/s].
    pub(super) drag: f32,
    pub(super) ground_restitution: f32,
    pub(super) ground_friction: f32,
}

/// A body whose held nodes follow given trajectories.
pub(super) struct Specimen<'a> {
    pub(super) rest: &'a [Point],
    pub(super) springs: &'a [[u32; 2]],
    pub(super) material: &'a Material,
    /// Nodes that are prescribed; control point i is held node i.
    pub(super) held: &'a [u32],
    pub(super) fps: f64,
}

/// Positions of all nodes in all frames, shape [T, N, 3], for each set of held
/// trajectories, shape [T, held, 3].
pub(super) fn simulate(
    specimen: &Specimen<'_>,
    held_paths: Vec<Vec<Point>>,
    backend: &dyn Backend,
) -> Result<Vec<Vec<Point>>, Error> {
    let failed = |e: bendtwin_engine::Error| Error::Simulation(e.to_string());
    let mut model = model(specimen);
    let substeps = f64::from(stable_substeps(&model).needed) * SAFETY;
    model.timing.substeps = (substeps.ceil() as u32).max(1);
    let initial = Arc::new(State::rest(&model.graph));
    let loaded = backend.load(Arc::new(model)).map_err(failed)?;
    let held = specimen.held.len().max(1);
    let batch: Vec<Instance> = held_paths
        .into_iter()
        .map(|path| Instance {
            model: loaded.clone(),
            initial: initial.clone(),
            frames: (path.len() / held).saturating_sub(1),
            controls: Arc::new(path),
            objective: Objective::default(),
            world: Arc::default(),
            motion: Arc::default(),
        })
        .collect();
    let outputs = Outputs { every: 1, initial: true, ..Outputs::default() };
    let rollouts = backend.roll_out(&batch, &outputs, &CancelToken::default()).map_err(failed)?;
    rollouts
        .into_iter()
        .map(|rollout| match rollout.diverged {
            None => Ok(rollout.positions),
            Some(d) => {
                Err(Error::Simulation(format!("node {} diverged in frame {}", d.node, d.frame)))
            }
        })
        .collect()
}

fn model(specimen: &Specimen<'_>) -> Model {
    let (rest, material) = (specimen.rest, specimen.material);
    let n = rest.len();
    let length = |&[a, b]: &[u32; 2]| {
        super::pose::norm(super::pose::sub(rest[b as usize], rest[a as usize]))
    };
    let pins = specimen.held.iter().enumerate().map(|(control, node)| Pin {
        node: *node,
        control: control as u32,
        offset_m: [0.0; 3],
    });
    let graph = Graph {
        rest_positions: rest.to_vec(),
        kinds: vec![NodeKind::Completed; n],
        masses: vec![1.0; n],
        object_ids: vec![0; n],
        observed_points: vec![Graph::NOT_OBSERVED; n],
        control_rest: specimen.held.iter().map(|h| rest[*h as usize]).collect(),
        springs: specimen.springs.to_vec(),
        triplets: material.triplets.clone(),
        pins: pins.collect(),
        ..Graph::default()
    };
    let bends = material.triplets.len();
    let params = Params {
        spring_stiffness: material.stiffness.clone(),
        spring_dashpot: material.dashpot.clone(),
        rest_lengths_m: specimen.springs.iter().map(length).collect(),
        bend_stiffness: vec![material.bend_stiffness; bends],
        bend_damping: vec![material.bend_damping; bends],
        rest_angles_rad: material.triplets.iter().map(|t| angle(rest, t)).collect(),
        drag: material.drag,
        contact: Contact {
            ground_restitution: material.ground_restitution,
            ground_friction: material.ground_friction,
            between_objects: false,
            within_object: false,
            ..Contact::default()
        },
        ..Params::default()
    };
    Model {
        graph: Arc::new(graph),
        skin: Arc::default(),
        params,
        environment: Environment::Z_UP,
        timing: Timing { fps: specimen.fps, substeps: 1 },
        control_velocity: ControlVelocity::True,
    }
}

/// Angle at the middle of a triplet [rad].
fn angle(rest: &[Point], &[i, j, k]: &[u32; 3]) -> f32 {
    let [i, j, k] = [i, j, k].map(|n| rest[n as usize]);
    let (u, w) = (super::pose::sub(i, j), super::pose::sub(k, j));
    let cross = [u[1] * w[2] - u[2] * w[1], u[2] * w[0] - u[0] * w[2], u[0] * w[1] - u[1] * w[0]];
    super::pose::norm(cross).atan2(super::pose::dot(u, w))
}
