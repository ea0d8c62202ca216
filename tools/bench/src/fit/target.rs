//! Target of a timed fit: a capture of the scene's body with a softer, uneven material.

use std::sync::Arc;

use bendtwin_core::{CancelToken, Capture, NodeKind, Sequence};
use bendtwin_engine::{
    Backend, Model,
    backend::{Instance, Outputs},
    model::State,
};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::{
    Error,
    scene::{self, Scene},
};

/// Mean stiffness of the hidden springs [N per unit strain]: soft enough that the body deforms
/// visibly.
const STIFFNESS: f32 = 500.0;
/// Springs at one end are harder and at the other softer by this share.
const UNEVEN: f32 = 0.5;
/// Dashpot of the hidden springs [N s/m].
const DASHPOT: f32 = 10.0;
/// Share of points and frames whose motion is trusted. The rest counts in the Chamfer distance
/// only, which a fit leaves out where every point is tracked.
const TRUSTED: f64 = 0.8;

/// A capture of `frames` frames of the scene's motion: the surface tracked, the interior known at
/// the start.
pub(super) fn capture(
    scene: &Scene,
    frames: usize,
    backend: &dyn Backend,
    cancel: &CancelToken,
) -> Result<Capture, Error> {
    let graph = &scene.model.graph;
    let surface = graph.surface_count();
    let steps = frames.max(2) - 1;
    let controls = scene.motion.path(0, steps);
    let instance = Instance {
        model: backend.load(Arc::new(hidden(scene)))?,
        initial: Arc::new(State::rest(graph)),
        controls: Arc::new(controls.clone()),
        frames: steps,
        objective: bendtwin_engine::Objective::default(),
        world: Arc::default(),
        motion: Arc::default(),
    };
    let outputs = Outputs {
        every: 1,
        initial: true,
        nodes: Some(Arc::new((0..surface as u32).collect())),
        ..Outputs::default()
    };
    let mut points = Vec::new();
    for rollout in backend.roll_out(&[instance], &outputs, cancel)? {
        if let Some(d) = rollout.diverged {
            let scene = scene.name.as_str();
            return Err(Error::Diverged { scene, frame: d.frame, node: d.node });
        }
        points = rollout.positions;
    }
    let mut rng = ChaCha8Rng::seed_from_u64(0);
    let sequence = Sequence {
        name: "one".into(),
        frame_count: steps + 1,
        train_frame_count: steps + 1,
        visible: vec![true; points.len()],
        motion_valid: points.iter().map(|_| rng.random_bool(TRUSTED)).collect(),
        points,
        controls,
        truth_tracks: Vec::new(),
        start_frames: 1,
    };
    let kinds = graph.rest_positions.iter().zip(&graph.kinds);
    let interior = kinds.filter(|(_, k)| **k == NodeKind::Interior).map(|(p, _)| *p).collect();
    Ok(scene::capture(scene.name.as_str(), surface, interior, sequence))
}

/// The scene with the material that the fit looks for.
fn hidden(scene: &Scene) -> Model {
    let mut model = Model::clone(&scene.model);
    let graph = &model.graph;
    let reach = graph.rest_positions.iter().map(|p| p[0].abs()).fold(f32::MIN_POSITIVE, f32::max);
    let middle =
        |s: &[u32; 2]| 0.5 * (graph.rest_endpoint(s[0])[0] + graph.rest_endpoint(s[1])[0]) / reach;
    let stiffness = |s: &[u32; 2]| STIFFNESS * (1.0 + UNEVEN * middle(s).clamp(-1.0, 1.0));
    model.params.spring_stiffness = graph.springs.iter().map(stiffness).collect();
    model.params.spring_dashpot.fill(DASHPOT);
    model
}
