//! Settings of a fit. Every field has a default, unknown fields are refused, and
//! [`FitSettings::validate`] reports all faults together.

pub mod defaults;
pub mod ingest;
pub mod layers;
pub mod memory;
mod variation;

use serde::{Deserialize, Serialize};

pub use self::defaults::{Conditions, DeviceKind, Effort};
use crate::{environment::ControlVelocity, ids::TwinId, twin::appearance::MOST_SPLATS};

/// Settings of a fit job.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct FitSettings {
    /// Seed of every random choice; the same seed gives the same twin.
    pub seed: u64,
    /// Effort, which settings that are left open follow.
    pub effort: Effort,
    /// Time that the fit may take [s]; fewer generations and passes are made then. A twin of such a
    /// fit carries their numbers, which depend on the machine.
    pub within_s: Option<f64>,
    /// A twin of the server, `twins/{uuid}`, that is refined: the fit begins with its graph and its
    /// parameters in place of those of a search.
    pub start_from: Option<String>,
    /// Bending triplets, and rods that twist where the capture allows them.
    pub bending: bool,
    /// Also fit the same nodes without bending and report it beside.
    pub compare_axial: bool,
    /// Construction of the graph.
    pub graph: GraphSettings,
    /// Substeps per frame.
    pub substeps: Substeps,
    /// Velocity of control points in dashpots.
    pub control_velocity: ControlVelocity,
    /// Contact between the nodes of one object.
    pub self_contact: bool,
    /// Contact of the skin, not of the nodes alone, with ground and colliders. If left open, it depends
    /// on the object and on the device.
    pub skin_contact: Option<bool>,
    /// The loss.
    pub loss: LossSettings,
    /// Zeroth-order stage.
    pub search: SearchSettings,
    /// First-order stage.
    pub refine: RefineSettings,
    /// The look of the twin, from the images of a raw recording.
    pub appearance: AppearanceSettings,
    /// The twin's planner's twin.
    pub planner: PlannerSettings,
}

/// Sampling of nodes, and the connections between them.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct GraphSettings {
    /// Fraction r of the capture's points kept as nodes, in (0, 1].
    pub sampling_ratio: f64,
    /// Choice of these among the points.
    pub sampling: Sampling,
    /// Upper bound on the number of nodes; lowers the ratio where it is exceeded. If left open, it
    /// depends on effort and device.
    pub max_nodes: Option<usize>,
    /// Keep interior nodes; without them the graph is its surface only. If left open, they are kept.
    pub interior: Option<bool>,
    /// Spring radius at full sampling [m]; scaled up as nodes get sparser, unless that is switched
    /// off. If left open, it follows the spacing of the capture's points.
    pub radius_m: Option<f64>,
    /// Scaling of the spring radius with the spacing of the nodes. Without it a graph of fewer nodes
    /// has fewer springs at each.
    pub radius_scales: bool,
    /// Most springs that a node opens. If left open, it depends on the object and on the device.
    pub max_neighbours: Option<usize>,
    /// Radius of control springs [m].
    pub control_radius_m: f64,
    /// Most springs that a control point opens.
    pub control_neighbours: usize,
    /// Most triplets per surface node.
    pub max_triplets: usize,
    /// Choice of the reference arm of a node's triplets.
    pub triplet_reference: TripletReference,
    /// Rods that twist between two clamps of a cable with known edges.
    pub twist: bool,
}

/// Choice of the nodes among a capture's points.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Sampling {
    /// Each as far as possible from those before it.
    #[default]
    Spread,
    /// At random, with clusters and gaps.
    Random,
}

/// Choice of the reference neighbour r(j) of a centre j.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum TripletReference {
    /// The nearest surface neighbour.
    Nearest,
    /// The farthest surface neighbour.
    Farthest,
    /// The neighbour most nearly opposite to the mean of the others.
    MostOpposite,
    /// No single reference: the most nearly straight pairs, each neighbour at most once.
    OppositePairs,
}

/// A mean of several sequences' losses.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum SequenceMean {
    /// Their sum, divided by their number: what is measured in the end.
    Arithmetic,
    /// The exponential of the mean of their logarithms, to which a few lost sequences matter less.
    Geometric,
}

/// Substeps per frame.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Substeps {
    /// The number of the stability estimate, times a margin.
    Auto {
        /// Stable dt over used dt, above 1.
        #[serde(default = "default_safety")]
        safety: f64,
        /// Upper limit; candidates that would need more count as unstable. If left open, it depends
        /// on the kind of object.
        #[serde(default)]
        max: Option<u32>,
    },
    /// Exactly this many; refused where unstable.
    Fixed(u32),
}

impl Substeps {
    /// The most substeps that a frame may take, by settings without open ones.
    pub fn most(&self) -> u32 {
        match *self {
            Self::Auto { max, .. } => max.unwrap_or(defaults::MOST_SUBSTEPS),
            Self::Fixed(n) => n,
        }
    }
}

fn default_safety() -> f64 {
    1.3
}

/// Weights of the loss terms.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct LossSettings {
    /// Chamfer distance from observed points to the surface, mean squared.
    pub chamfer_weight: f64,
    /// Smooth L1 of tracked points.
    pub track_weight: f64,
    /// Distance at which smooth L1 turns from quadratic to linear [m]; PhysTwin uses 1.
    pub track_beta_m: f64,
    /// Acceleration smoothness, search stage only.
    pub acceleration_weight: f64,
    /// Mean of the losses of several sequences. If left open, it depends on the object.
    pub sequences: Option<SequenceMean>,
}

/// Most members of a twin: other fits of the same object that it keeps.
pub const MOST_MEMBERS: usize = 15;

/// CMA-ES over the global variables.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct SearchSettings {
    /// Number of searches with different seeds, each with its own refinement; the twin is the
    /// one with the lowest training loss, or the one that best predicts the held-back frames. If
    /// left open, it depends on effort, capture and device.
    pub starts: Option<u32>,
    /// Several starts that differ in more than their seeds: in turn with hands that reach farther and
    /// hold more firmly, with axial springs alone, with denser springs, and as set. If left open, they
    /// do not.
    pub vary: Option<bool>,
    /// Share of each sequence's training frames, the last ones, that are held back from several
    /// starts to choose one of them, which is then refined on all; 0: the training loss chooses.
    pub held_back: f64,
    /// Largest number of other starts that the twin keeps as members, of those that fit nearly
    /// equally well: the spread of their predictions shows what the capture leaves open. 0 keeps
    /// none.
    pub members: u32,
    /// Number of generations; 0 skips the stage. If left open, it depends on effort, capture and
    /// device.
    pub generations: Option<u32>,
    /// Candidates per generation; 0 means 4 + 3 ln(variables). If left open, it depends on effort,
    /// capture and device.
    pub population: Option<usize>,
    /// Initial step size in the unit cube.
    pub sigma: f64,
    /// Share of the loss that a candidate is charged per square decade by which damping and bending
    /// are off from where the search starts. If left open, it depends on the object.
    pub prior: Option<f64>,
    /// Search of radius and neighbour counts too.
    pub topology: bool,
    /// Search of the strength of gravity too, from half to twice the capture's. If left open, it
    /// depends on the object.
    pub gravity: Option<bool>,
    /// Number of training frames used, from the first (0: all).
    pub max_frames: usize,
    /// Number of training sequences used, spread evenly over all of them (0: all).
    pub max_sequences: usize,
}

/// Cuts of gradients in time.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum GradientWindow {
    /// A step per frame, gradient cut at each frame's start (PhysTwin).
    Frame,
    /// A step per window of this many frames, gradient cut at the window's start.
    Frames(u32),
    /// A step per pass through all training frames.
    Pass,
}

/// Adam on log-parameters.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct RefineSettings {
    /// Passes over the training frames; 0 skips the stage. If left open, it depends on effort,
    /// capture and device.
    pub passes: Option<u32>,
    /// Learning rate in log space.
    pub learning_rate: f64,
    /// Decay of the first moment.
    pub beta1: f64,
    /// Decay of the second moment.
    pub beta2: f64,
    /// Strength of the pull of parameters towards the search's result, which is one material for
    /// the whole object; 0 for none. If left open, it depends on the object, effort and device.
    pub prior: Option<f64>,
    /// Frames per step, and the reach of its gradients back in time.
    pub window: GradientWindow,
    /// Largest reach of gradients within a window [frames] (0: the whole window); a fit that makes
    /// no gain shortens it further. If left open, it depends on the device.
    pub reach: Option<u32>,
    /// Training sequences per step (0: all); each pass shuffles them again. If left open, their
    /// number follows the device.
    pub batch: Option<usize>,
    /// Fit rest lengths and rest angles too.
    pub rest_shape: bool,
}

/// Most cameras that may be held out.
const MOST_HELD_OUT: usize = 64;

/// Colours and Gaussians from the images of a raw recording.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct AppearanceSettings {
    /// Most Gaussians that are trained on the images of the training frames, which the twin's motion
    /// carries; 0: the colours of the skin are all. If left open, it depends on effort.
    pub gaussians: Option<u32>,
    /// Steps of the training, each over one image.
    pub steps: u32,
    /// Gaussians that are round.
    pub isotropic: bool,
    /// Number of training frames used, from the first (0: all).
    pub max_frames: usize,
    /// Cameras, counted from 0, that neither colours nor Gaussians are made from; they are measured
    /// beside the others.
    pub held_out_cameras: Vec<u32>,
}

/// Most nodes of a planner's twin.
pub const MOST_PLANNER_NODES: u32 = 2000;
/// Most substeps of a planner's twin that settings may allow.
pub const MOST_PLANNER_SUBSTEPS: u32 = 1000;

/// A small twin beside the twin, distilled from its motion, that plans are made with.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct PlannerSettings {
    /// Number of nodes; 0 makes none. If left open, it depends on effort.
    pub nodes: Option<u32>,
    /// Largest number of substeps per frame. If left open, [`defaults::PLANNER_SUBSTEPS`].
    pub substeps: Option<u32>,
}

impl Default for FitSettings {
    fn default() -> Self {
        Self {
            seed: 0,
            effort: Effort::Standard,
            within_s: None,
            start_from: None,
            bending: true,
            compare_axial: false,
            graph: GraphSettings::default(),
            substeps: Substeps::Auto { safety: default_safety(), max: None },
            control_velocity: ControlVelocity::True,
            self_contact: false,
            skin_contact: None,
            loss: LossSettings::default(),
            search: SearchSettings::default(),
            refine: RefineSettings::default(),
            appearance: AppearanceSettings::default(),
            planner: PlannerSettings::default(),
        }
    }
}

impl Default for AppearanceSettings {
    fn default() -> Self {
        Self {
            gaussians: None,
            steps: 4000,
            isotropic: false,
            max_frames: 0,
            held_out_cameras: Vec::new(),
        }
    }
}

impl Default for GraphSettings {
    fn default() -> Self {
        Self {
            sampling_ratio: 1.0,
            sampling: Sampling::Spread,
            max_nodes: None,
            interior: None,
            radius_m: None,
            radius_scales: true,
            max_neighbours: None,
            control_radius_m: 0.02,
            control_neighbours: 10,
            max_triplets: 4,
            triplet_reference: TripletReference::OppositePairs,
            twist: true,
        }
    }
}

impl Default for LossSettings {
    fn default() -> Self {
        Self {
            chamfer_weight: 1.0,
            track_weight: 1.0,
            track_beta_m: 0.01,
            acceleration_weight: 0.0,
            sequences: None,
        }
    }
}

impl Default for SearchSettings {
    fn default() -> Self {
        Self {
            starts: None,
            vary: None,
            held_back: 0.0,
            members: 7,
            generations: None,
            population: None,
            sigma: 1.0 / 6.0,
            prior: None,
            topology: false,
            gravity: None,
            max_frames: 0,
            max_sequences: 16,
        }
    }
}

impl Default for RefineSettings {
    fn default() -> Self {
        Self {
            passes: None,
            learning_rate: 0.1,
            beta1: 0.9,
            beta2: 0.99,
            prior: None,
            window: GradientWindow::Pass,
            reach: None,
            batch: None,
            rest_shape: true,
        }
    }
}

impl FitSettings {
    /// Settings close to PhysTwin's scheme as published (docs/use/settings.md lists the differences):
    /// full sampling, 667 substeps, one step per frame.
    pub fn phystwin() -> Self {
        Self {
            bending: false,
            substeps: Substeps::Fixed(667),
            control_velocity: ControlVelocity::Ignored,
            skin_contact: Some(false),
            graph: GraphSettings {
                max_nodes: Some(usize::MAX),
                interior: Some(true),
                radius_m: Some(0.02),
                max_neighbours: Some(30),
                control_radius_m: 0.04,
                control_neighbours: 50,
                ..GraphSettings::default()
            },
            loss: LossSettings { track_beta_m: 1.0, ..LossSettings::default() },
            search: SearchSettings {
                generations: Some(20),
                population: Some(0),
                topology: true,
                vary: Some(false),
                ..SearchSettings::default()
            },
            refine: RefineSettings {
                passes: Some(200),
                batch: Some(8),
                learning_rate: 1e-3,
                window: GradientWindow::Frame,
                prior: Some(0.0),
                reach: Some(0),
                rest_shape: false,
                ..RefineSettings::default()
            },
            ..Self::default()
        }
    }

    /// Checks every value.
    ///
    /// # Errors
    /// All faults found, one sentence each.
    pub fn validate(&self) -> Result<(), Vec<String>> {
        let mut faults = Vec::new();
        let mut within = |name: &str, value: f64, low: f64, high: f64| {
            if !(value >= low && value <= high) {
                faults.push(format!("{name} is {value}: it must lie in {low}..={high}"));
            }
        };
        within("within_s", self.within_s.unwrap_or(1.0), 1.0, 1e6);
        let g = &self.graph;
        within("graph.sampling_ratio", g.sampling_ratio, 1e-4, 1.0);
        let max_nodes = g.max_nodes.unwrap_or(1).min(1 << 24) as f64;
        within("graph.max_nodes", max_nodes, 1.0, f64::from(1 << 24));
        within("graph.radius_m", g.radius_m.unwrap_or(0.02), 1e-5, 10.0);
        within("graph.max_neighbours", g.max_neighbours.unwrap_or(1) as f64, 1.0, 256.0);
        within("graph.control_radius_m", g.control_radius_m, 0.0, 10.0);
        within("graph.control_neighbours", g.control_neighbours as f64, 0.0, 1024.0);
        within("graph.max_triplets", g.max_triplets as f64, 0.0, 256.0);
        match self.substeps {
            Substeps::Auto { safety, max } => {
                within("substeps.auto.safety", safety, 1.0, 100.0);
                within("substeps.auto.max", f64::from(max.unwrap_or(1)), 1.0, 100_000.0);
            }
            Substeps::Fixed(n) => within("substeps.fixed", f64::from(n), 1.0, 100_000.0),
        }
        let l = &self.loss;
        within("loss.chamfer_weight", l.chamfer_weight, 0.0, 1e9);
        within("loss.track_weight", l.track_weight, 0.0, 1e9);
        within("loss.track_beta_m", l.track_beta_m, 1e-9, 1e3);
        within("loss.acceleration_weight", l.acceleration_weight, 0.0, 1e9);
        within("search.starts", f64::from(self.search.starts.unwrap_or(1)), 1.0, 64.0);
        let generations = self.search.generations.unwrap_or_default();
        within("search.generations", f64::from(generations), 0.0, 10_000.0);
        let population = self.search.population.unwrap_or_default() as f64;
        within("search.population", population, 0.0, 10_000.0);
        within("search.sigma", self.search.sigma, 1e-6, 1.0);
        within("search.held_back", self.search.held_back, 0.0, 0.5);
        within("search.members", f64::from(self.search.members), 0.0, MOST_MEMBERS as f64);
        within("search.prior", self.search.prior.unwrap_or_default(), 0.0, 1000.0);
        let r = &self.refine;
        within("refine.passes", f64::from(r.passes.unwrap_or_default()), 0.0, 100_000.0);
        within("refine.learning_rate", r.learning_rate, 1e-9, 1.0);
        within("refine.beta1", r.beta1, 0.0, 0.999_999);
        within("refine.beta2", r.beta2, 0.0, 0.999_999_9);
        within("refine.prior", r.prior.unwrap_or_default(), 0.0, 1e3);
        within("refine.reach", f64::from(r.reach.unwrap_or_default()), 0.0, 1_000_000.0);
        let a = &self.appearance;
        let (gaussians, most) = (a.gaussians.unwrap_or_default(), MOST_SPLATS as f64);
        within("appearance.gaussians", f64::from(gaussians), 0.0, most);
        within("appearance.steps", f64::from(a.steps), 1.0, 1e6);
        let held_out = a.held_out_cameras.len() as f64;
        within("number of appearance.held_out_cameras", held_out, 0.0, MOST_HELD_OUT as f64);
        let p = &self.planner;
        let nodes = f64::from(p.nodes.unwrap_or_default());
        within("planner.nodes", nodes, 0.0, MOST_PLANNER_NODES.into());
        let substeps = f64::from(p.substeps.unwrap_or(1));
        within("planner.substeps", substeps, 1.0, MOST_PLANNER_SUBSTEPS.into());
        if r.window == GradientWindow::Frames(0) {
            faults.push("refine.window.frames is 0: a window has at least one frame".to_owned());
        }
        if let Some(Err(fault)) = self.start_from.as_ref().map(|name| name.parse::<TwinId>()) {
            faults.push(format!("start_from: {fault}"));
        }
        if faults.is_empty() { Ok(()) } else { Err(faults) }
    }
}

#[cfg(test)]
mod tests;
