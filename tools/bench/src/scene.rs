//! Named bodies to measure with. A scene is a pure function of its name: the same name is the same
//! graph, parameters and motion on every machine.
//!
//! `n500` to `n10000` are ellipsoids 1.5 : 1 : 0.8 filled on a jittered grid of 5 mm and held at
//! one end by 30 control points; `rope` is 3 x 3 x 48 nodes held at both ends by 8. Springs join a
//! node to its nearest 29 within 0.02 m (PhysTwin asks for 30 and gets the node itself among them);
//! a control point has springs to at most 50 nodes within 0.04 m. A frame is 1/30 s in 667
//! substeps, the ground lies a millimetre below. With bending, every surface node has up to 4
//! triplets.

mod body;
mod motion;

use std::{str::FromStr, sync::Arc};

use bendtwin_core::{
    Capture, Contact, Environment, Params, Point, Sequence, Timing,
    capture::Object,
    environment::ControlVelocity,
    settings::{GraphSettings, Sampling, TripletReference},
};
use bendtwin_engine::{Model, enough_substeps};
use bendtwin_graph::{Connectivity, connect, rest_geometry, sample_nodes};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

pub use self::motion::{Motion, Path};
use crate::Error;

/// Frames a second of every scene.
pub const FPS: f64 = 30.0;
/// Substeps a frame of every scene: a substep is 5e-5 s.
pub const SUBSTEPS: u32 = 667;
/// Stiffnesses tried [N per unit strain], PhysTwin's initial one first; the first stable one is
/// taken.
const STIFFNESSES: [f32; 5] = [3e4, 2e4, 1e4, 3e3, 1e3];
/// A spring's stiffness differs from the scene's by up to this share.
const STIFFNESS_SPREAD: f32 = 0.1;
/// Dashpot of every spring [N s/m].
const DASHPOT: f32 = 100.0;
/// Velocity decay [1/s].
const DRAG: f32 = 3.0;
/// Bending stiffness of every triplet [N m/rad].
const BEND_STIFFNESS: f32 = 2.5e-2;
/// Bending damping of every triplet [N m s/rad].
const BEND_DAMPING: f32 = 2.5e-5;
/// Seed of all random numbers of a scene.
const SEED: u64 = 0;

/// The name of a scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum SceneName {
    /// 432 nodes, held at both ends.
    Rope,
    /// 507 nodes.
    N500,
    /// 2,003 nodes.
    N2000,
    /// 5,019 nodes.
    N5000,
    /// 10,001 nodes.
    N10000,
}

impl SceneName {
    /// All scenes, the smallest first.
    pub const ALL: [Self; 5] = [Self::Rope, Self::N500, Self::N2000, Self::N5000, Self::N10000];

    /// Name on the command line.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Rope => "rope",
            Self::N500 => "n500",
            Self::N2000 => "n2000",
            Self::N5000 => "n5000",
            Self::N10000 => "n10000",
        }
    }

    /// Number of nodes.
    pub fn node_count(self) -> usize {
        match self {
            Self::Rope => 432,
            Self::N500 => 507,
            Self::N2000 => 2_003,
            Self::N5000 => 5_019,
            Self::N10000 => 10_001,
        }
    }

    /// Number of control points.
    pub fn control_count(self) -> usize {
        match self {
            Self::Rope => 8,
            _ => 30,
        }
    }
}

impl std::fmt::Display for SceneName {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.pad(self.as_str())
    }
}

impl FromStr for SceneName {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let known = Self::ALL.into_iter().find(|name| name.as_str() == text);
        known.ok_or_else(|| {
            let names = Self::ALL.map(Self::as_str).join(", ");
            format!("there is no scene `{text}`; there is {names}")
        })
    }
}

/// A body, its material and its motion.
#[derive(Clone, Debug)]
pub struct Scene {
    /// Name of the scene.
    pub name: SceneName,
    /// True if it has triplets.
    pub bending: bool,
    /// Graph, parameters and surroundings.
    pub model: Arc<Model>,
    /// Mean stiffness of its springs [N per unit strain].
    pub stiffness: f32,
    /// Motion of its control points.
    pub motion: Motion,
}

impl Scene {
    /// Makes the scene of a name.
    ///
    /// # Errors
    /// If the scene's definition contradicts itself.
    pub fn new(name: SceneName, bending: bool) -> Result<Self, Error> {
        let body = match name {
            SceneName::Rope => body::rope(SEED),
            _ => body::ellipsoid(name.node_count(), name.control_count(), SEED),
        };
        let motion = Motion::new(body.controls.clone());
        let capture = still(&body);
        let sample = sample_nodes(&capture, &graph_settings(), SEED)?;
        let graph = connect(&sample, &Connectivity::from_settings(&graph_settings(), bending));
        let (rest_lengths_m, rest_angles_rad) = rest_geometry(&graph, &sample);
        let (e, t) = (graph.springs.len(), graph.triplets.len());
        let mut rng = ChaCha8Rng::seed_from_u64(SEED);
        let relative: Vec<f32> =
            (0..e).map(|_| 1.0 + STIFFNESS_SPREAD * (2.0 * rng.random::<f32>() - 1.0)).collect();
        let mut model = Model {
            graph: Arc::new(graph),
            skin: Arc::default(),
            params: Params {
                spring_stiffness: Vec::new(),
                spring_dashpot: vec![DASHPOT; e],
                rest_lengths_m,
                bend_stiffness: vec![BEND_STIFFNESS; t],
                bend_damping: vec![BEND_DAMPING; t],
                rest_angles_rad,
                drag: DRAG,
                contact: Contact::default(),
                ..Params::default()
            },
            environment: Environment::Z_UP,
            timing: Timing { fps: FPS, substeps: SUBSTEPS },
            control_velocity: ControlVelocity::True,
        };
        for stiffness in STIFFNESSES {
            model.params.spring_stiffness = relative.iter().map(|r| r * stiffness).collect();
            if enough_substeps(&model, SUBSTEPS).is_ok() {
                return Ok(Self { name, bending, model: Arc::new(model), stiffness, motion });
            }
        }
        Err(Error::Unstable(name.as_str()))
    }

    /// Number of springs to control points; they are the last ones.
    pub fn control_spring_count(&self) -> usize {
        let graph = &self.model.graph;
        let n = graph.node_count() as u32;
        graph.springs.iter().filter(|s| s[1] >= n).count()
    }
}

/// Connections between nodes, as in PhysTwin.
pub(crate) fn graph_settings() -> GraphSettings {
    GraphSettings {
        sampling_ratio: 1.0,
        sampling: Sampling::Spread,
        max_nodes: Some(usize::MAX),
        interior: Some(true),
        radius_m: Some(0.02),
        radius_scales: true,
        max_neighbours: Some(29),
        control_radius_m: 0.04,
        control_neighbours: 50,
        twist: false,
        max_triplets: 4,
        triplet_reference: TripletReference::OppositePairs,
    }
}

/// The body at rest, as a capture of one frame: its nodes become a graph in the same way as those
/// of any other capture.
fn still(body: &body::Body) -> Capture {
    let sequence = Sequence {
        name: "rest".into(),
        frame_count: 1,
        train_frame_count: 1,
        points: body.surface.clone(),
        visible: vec![true; body.surface.len()],
        motion_valid: vec![true; body.surface.len()],
        controls: body.controls.clone(),
        truth_tracks: Vec::new(),
        start_frames: 1,
    };
    capture("rest", body.surface.len(), body.interior.clone(), sequence)
}

/// A capture of one sequence in the scenes' surroundings.
pub(crate) fn capture(
    name: &str,
    point_count: usize,
    interior: Vec<Point>,
    sequence: Sequence,
) -> Capture {
    Capture {
        name: name.to_owned(),
        fps: FPS,
        environment: Environment::Z_UP,
        source_to_world: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        object: Object { point_count, interior, ..Object::default() },
        sequences: vec![sequence],
        others: Vec::new(),
    }
}

#[cfg(test)]
mod tests;
