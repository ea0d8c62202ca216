//! Defaults that depend on the kind of object, on the device, and on the effort that a user asks
//! for: settings that are left open take them before a fit begins, and its twin carries the result.
//!
//! A twin predicts at its skin, so that a body needs few nodes (docs/use/accuracy.md has the errors).
//! The search finds the order of magnitude of stiffness and damping, which takes a few generations;
//! what is left is for the refinement.

use serde::{Deserialize, Serialize};

use super::{FitSettings, MAX_SUBSTEPS, SequenceMean, Substeps};
use crate::capture::Subject;

/// Gaussians of a twin whose fit takes its time.
const BEST_GAUSSIANS: u32 = 20_000;
/// Nodes of the planner's twin of a twin whose fit takes its time, and substeps of any: 48 rollouts of
/// 15 frames take some 40 ms on two cores.
const PLANNER_NODES: u32 = 80;
const PLANNER_SUBSTEPS: u32 = 32;
/// Training sequences per step of a refinement, at least.
const LEAST_BATCH: usize = 8;
/// Steps of a pass on a GPU, at most: it computes a quarter of a cable's sequences in hardly more time
/// than eight of them.
const GPU_STEPS: usize = 4;
/// Training sequences per step there are a multiple of this, as those that were measured.
const GPU_BATCH_STEP: usize = 4;

/// Frames that the gradient of a body reaches back there: the pieces between run backward side by
/// side, so that a pass takes half of the time, and twins predict as well as with all frames.
const GPU_REACH: u32 = 16;

/// Effort of a fit, which settings that are left open follow.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Effort {
    /// To see within seconds whether a capture is worth a fit.
    Draft,
    /// To work with.
    #[default]
    Standard,
    /// As good as it gets.
    Best,
}

/// Kind of the device that a fit computes on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DeviceKind {
    /// Cores of the host.
    Cpu,
    /// A graphics processor, which has room for larger graphs.
    Gpu,
}

/// Conditions of a fit beside its settings.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Conditions {
    /// Kind of the captured object.
    pub subject: Subject,
    /// Kind of the device.
    pub device: DeviceKind,
    /// Number of training sequences.
    pub sequences: usize,
    /// The object's mass is known.
    pub is_weighed: bool,
}

/// Values of settings that may be left open.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Defaults {
    max_nodes: usize,
    max_neighbours: usize,
    starts: u32,
    generations: u32,
    population: usize,
    passes: u32,
}

impl Defaults {
    fn of(effort: Effort, conditions: Conditions) -> Self {
        use DeviceKind::{Cpu, Gpu};
        use Effort::{Best, Draft, Standard};
        let of = |max_nodes, max_neighbours, starts, generations, population, passes| Self {
            max_nodes,
            max_neighbours,
            starts,
            generations,
            population,
            passes,
        };
        match (conditions.subject, conditions.device, effort) {
            // A cable has the nodes that were recorded. Its searches are cheap, its optimum is
            // narrow, and its training loss shows which of several starts predicts best.
            (Subject::Cable, _, Draft) => of(usize::MAX, 12, 1, 20, 32, 20),
            (Subject::Cable, _, Standard) => of(usize::MAX, 12, 3, 60, 32, 40),
            (Subject::Cable, _, Best) => of(usize::MAX, 12, 6, 60, 32, 80),
            (Subject::Body, Cpu, Draft) => of(100, 12, 1, 4, 16, 40),
            (Subject::Body, Cpu, Standard) => of(200, 12, 2, 12, 16, 120),
            (Subject::Body, Cpu, Best) => of(600, 30, 4, 12, 32, 300),
            (Subject::Body, Gpu, Draft) => of(300, 30, 1, 8, 32, 60),
            (Subject::Body, Gpu, Standard) => of(600, 30, 3, 12, 32, 300),
            (Subject::Body, Gpu, Best) => of(600, 30, 4, 25, 32, 600),
        }
    }
}

/// Values that depend on the kind of object alone.
struct SubjectDefaults {
    /// Mean of the losses of several sequences.
    sequence_mean: SequenceMean,
    /// True if the strength of gravity is searched. It pays in motion capture, where nothing else
    /// corrects a frame rate that is not quite true. With a known mass it would make every force in
    /// newtons wrong by as much: the weight is what the scale of forces comes from.
    searches_gravity: bool,
    /// Pull of the search to where it starts.
    search_prior: f64,
}

impl SubjectDefaults {
    fn of(subject: Subject) -> Self {
        match subject {
            Subject::Cable => Self {
                sequence_mean: SequenceMean::Geometric,
                searches_gravity: true,
                search_prior: 0.0,
            },
            Subject::Body => Self {
                sequence_mean: SequenceMean::Arithmetic,
                searches_gravity: false,
                search_prior: 0.4,
            },
        }
    }
}

/// Pull of the refinement to what the search found. A draft of a body on a CPU has few nodes and ends
/// early: there the stronger pull predicts better.
fn refine_prior(effort: Effort, conditions: Conditions) -> f64 {
    match (conditions.subject, conditions.device, effort) {
        (Subject::Cable, ..) | (Subject::Body, DeviceKind::Cpu, Effort::Draft) => 0.3,
        (Subject::Body, ..) => 0.05,
    }
}

/// Frames that a gradient of a refinement reaches back; 0 for all.
fn reach(conditions: Conditions) -> u32 {
    match (conditions.subject, conditions.device) {
        (Subject::Body, DeviceKind::Gpu) => GPU_REACH,
        (Subject::Cable, _) | (_, DeviceKind::Cpu) => 0,
    }
}

/// Training sequences per step of a refinement.
fn batch(conditions: Conditions) -> usize {
    match conditions.device {
        DeviceKind::Cpu => LEAST_BATCH,
        DeviceKind::Gpu => {
            let quarter = conditions.sequences.div_ceil(GPU_STEPS).max(LEAST_BATCH);
            quarter.checked_next_multiple_of(GPU_BATCH_STEP).unwrap_or(quarter)
        }
    }
}

impl FitSettings {
    /// These settings with defaults in place of those that are left open, apart from
    /// `graph.radius_m`, which follows the spacing of the capture's points.
    #[must_use]
    pub fn filled(&self, conditions: Conditions) -> Self {
        let defaults = Defaults::of(self.effort, conditions);
        let mut filled = self.clone();
        filled.graph.max_nodes.get_or_insert(defaults.max_nodes);
        filled.graph.max_neighbours.get_or_insert(defaults.max_neighbours);
        filled.graph.interior.get_or_insert(true);
        filled.search.starts.get_or_insert(defaults.starts);
        let varies = (conditions.subject, conditions.device) == (Subject::Body, DeviceKind::Gpu);
        filled.search.vary.get_or_insert(varies);
        if let Substeps::Auto { max, .. } = &mut filled.substeps {
            // The search of a cable would spend its time on stiff candidates; a body with many nodes
            // needs more.
            max.get_or_insert(if conditions.subject == Subject::Cable {
                200
            } else {
                MAX_SUBSTEPS
            });
        }
        filled.search.generations.get_or_insert(defaults.generations);
        filled.search.population.get_or_insert(defaults.population);
        filled.refine.passes.get_or_insert(defaults.passes);
        filled.refine.batch.get_or_insert(batch(conditions));
        filled.refine.reach.get_or_insert(reach(conditions));
        let gaussians = if self.effort == Effort::Best { BEST_GAUSSIANS } else { 0 };
        filled.appearance.gaussians.get_or_insert(gaussians);
        let planner = if self.effort == Effort::Best { PLANNER_NODES } else { 0 };
        filled.planner.nodes.get_or_insert(planner);
        filled.planner.substeps.get_or_insert(PLANNER_SUBSTEPS);
        let of_subject = SubjectDefaults::of(conditions.subject);
        filled.search.prior.get_or_insert(of_subject.search_prior);
        filled.refine.prior.get_or_insert(refine_prior(self.effort, conditions));
        let searches_gravity = of_subject.searches_gravity && !conditions.is_weighed;
        filled.search.gravity.get_or_insert(searches_gravity);
        filled.loss.sequences.get_or_insert(of_subject.sequence_mean);
        filled
    }
}
