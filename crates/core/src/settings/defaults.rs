//! Defaults of a fit: one table, by kind of object, device and effort. Settings that are left open take
//! their values from it before a fit begins, and its twin carries the result; docs/use/settings.md shows
//! the same table, and a test compares the two.
//!
//! A twin predicts at its skin, so that a body needs few nodes (docs/use/accuracy.md has the errors).
//! The search finds the order of magnitude of stiffness and damping, which takes a few generations;
//! what is left is for the refinement.

use serde::{Deserialize, Serialize};

use super::{FitSettings, SequenceMean, Substeps};
use crate::capture::Subject;

/// Effort of a fit, which settings that are left open follow.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Effort {
    /// For a decision within seconds whether a capture is worth a fit.
    Draft,
    /// For everyday work.
    #[default]
    Standard,
    /// Highest quality.
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

/// Values of one setting, each by effort: draft, standard, best.
struct Row<T> {
    body_on_cpu: [T; 3],
    body_on_gpu: [T; 3],
    /// The same on either device.
    cable: [T; 3],
}

const fn row<T: Copy>(body_on_cpu: [T; 3], body_on_gpu: [T; 3], cable: [T; 3]) -> Row<T> {
    Row { body_on_cpu, body_on_gpu, cable }
}

/// A row whose values depend on the effort alone.
const fn by_effort<T: Copy>(values: [T; 3]) -> Row<T> {
    row(values, values, values)
}

impl<T: Copy> Row<T> {
    fn value(&self, effort: Effort, conditions: Conditions) -> T {
        let by_effort = match (conditions.subject, conditions.device) {
            (Subject::Body, DeviceKind::Cpu) => self.body_on_cpu,
            (Subject::Body, DeviceKind::Gpu) => self.body_on_gpu,
            (Subject::Cable, _) => self.cable,
        };
        by_effort[effort as usize]
    }
}

/// Nodes of a planner's twin where nothing else says how many: with these and [`PLANNER_SUBSTEPS`], 48
/// rollouts of 15 frames take some 40 ms on two cores.
pub const PLANNER_NODES: u32 = 80;
/// Substeps of a planner's twin where nothing else says how many.
pub const PLANNER_SUBSTEPS: u32 = 32;
/// No bound.
const ALL: usize = usize::MAX;
/// Most substeps of a frame where nothing else says how many.
pub(super) const MOST_SUBSTEPS: u32 = 1000;

// The table. Columns: a body on a CPU, a body on a GPU, a cable; in each draft, standard, best.

/// `graph.max_nodes`; a cable has the nodes that were recorded.
const MAX_NODES: Row<usize> = row([100, 200, 600], [300, 600, 600], [ALL; 3]);
/// `graph.max_neighbours`.
const MAX_NEIGHBOURS: Row<usize> = row([12, 12, 30], [30; 3], [12; 3]);
/// `graph.interior`.
const INTERIOR: Row<bool> = by_effort([true; 3]);
/// `skin_contact`; on a CPU it takes 12 to 42 % longer, and drafts predict no better with it. What motion
/// capture records has no skin.
const SKIN_CONTACT: Row<bool> = row([false; 3], [true; 3], [false; 3]);
/// `substeps.auto.max`; the search of a cable would spend its time on stiff candidates, and a body with
/// many nodes needs more.
const SUBSTEPS: Row<u32> = row([MOST_SUBSTEPS; 3], [MOST_SUBSTEPS; 3], [200; 3]);
/// `loss.sequences`.
const SEQUENCES: Row<SequenceMean> =
    row([SequenceMean::Arithmetic; 3], [SequenceMean::Arithmetic; 3], [SequenceMean::Geometric; 3]);
/// `search.starts`; searches of a cable are cheap, its optimum is narrow, and its training loss shows
/// which of several starts predicts best.
const STARTS: Row<u32> = row([1, 2, 4], [1, 2, 4], [1, 3, 6]);
/// `search.vary`.
const VARY: Row<bool> = by_effort([false; 3]);
/// `search.generations`.
const GENERATIONS: Row<u32> = row([4, 12, 12], [8, 12, 25], [20, 60, 60]);
/// `search.population`.
const POPULATION: Row<usize> = row([16, 16, 32], [32; 3], [32; 3]);
/// `search.prior`.
const SEARCH_PRIOR: Row<f64> = row([0.4; 3], [0.4; 3], [0.0; 3]);
/// `search.gravity`, which pays in motion capture, where nothing else corrects a frame rate that is not
/// quite true. With a known mass it would make every force in newtons wrong by as much: the weight is
/// what the scale of forces comes from.
const GRAVITY: Row<bool> = row([false; 3], [false; 3], [true; 3]);
/// `refine.passes`.
const PASSES: Row<u32> = row([40, 120, 300], [60, 300, 600], [20, 40, 80]);
/// `refine.prior`; a draft of a body on a CPU has few nodes and ends early: there the stronger pull
/// predicts better.
const REFINE_PRIOR: Row<f64> = row([0.3, 0.05, 0.05], [0.05; 3], [0.3; 3]);
/// `refine.reach`; on a GPU the pieces of a gradient that reaches back 16 frames run backward side by
/// side, so that a pass takes half of the time, and twins predict as well as with all frames.
const REACH: Row<u32> = row([0; 3], [16; 3], [0; 3]);
/// `appearance.gaussians`.
const GAUSSIANS: Row<u32> = by_effort([0, 0, 20_000]);
/// `planner.nodes`.
const NODES_OF_PLANNER: Row<u32> = by_effort([0, 0, PLANNER_NODES]);
/// `planner.substeps`.
const SUBSTEPS_OF_PLANNER: Row<u32> = by_effort([PLANNER_SUBSTEPS; 3]);

/// Training sequences per step of a refinement, at least.
const LEAST_BATCH: usize = 8;
/// Steps of a pass on a GPU, at most: it computes a quarter of a cable's sequences in hardly more time
/// than eight of them.
const GPU_STEPS: usize = 4;
/// Training sequences per step there are a multiple of this, as those that were measured.
const GPU_BATCH_STEP: usize = 4;

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

/// Point at which the search of a material begins.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SearchOrigin {
    /// Bending stiffness and damping, relative to those that resist like the springs. A cable is held
    /// by its bending, other bodies by their springs.
    pub bend_share: f64,
    /// Dashpot coefficient of springs [N s/m].
    pub dashpot: f64,
}

impl SearchOrigin {
    /// The origin for a kind of object.
    pub fn of(subject: Subject) -> Self {
        match subject {
            Subject::Cable => Self { bend_share: 1.0, dashpot: 20.0 },
            Subject::Body => Self { bend_share: 0.01, dashpot: 100.0 },
        }
    }
}

impl FitSettings {
    /// These settings with defaults in place of those that are left open, apart from
    /// `graph.radius_m`, which follows the spacing of the capture's points.
    #[must_use]
    pub fn filled(&self, conditions: Conditions) -> Self {
        let mut filled = self.clone();
        let fill = Fill { effort: self.effort, conditions };
        fill.with(&mut filled.graph.max_nodes, &MAX_NODES);
        fill.with(&mut filled.graph.max_neighbours, &MAX_NEIGHBOURS);
        fill.with(&mut filled.graph.interior, &INTERIOR);
        fill.with(&mut filled.skin_contact, &SKIN_CONTACT);
        if let Substeps::Auto { max, .. } = &mut filled.substeps {
            fill.with(max, &SUBSTEPS);
        }
        fill.with(&mut filled.loss.sequences, &SEQUENCES);
        fill.with(&mut filled.search.starts, &STARTS);
        fill.with(&mut filled.search.vary, &VARY);
        fill.with(&mut filled.search.generations, &GENERATIONS);
        fill.with(&mut filled.search.population, &POPULATION);
        fill.with(&mut filled.search.prior, &SEARCH_PRIOR);
        if conditions.is_weighed {
            filled.search.gravity.get_or_insert(false);
        }
        fill.with(&mut filled.search.gravity, &GRAVITY);
        fill.with(&mut filled.refine.passes, &PASSES);
        fill.with(&mut filled.refine.prior, &REFINE_PRIOR);
        fill.with(&mut filled.refine.reach, &REACH);
        filled.refine.batch.get_or_insert(batch(conditions));
        fill.with(&mut filled.appearance.gaussians, &GAUSSIANS);
        fill.with(&mut filled.planner.nodes, &NODES_OF_PLANNER);
        fill.with(&mut filled.planner.substeps, &SUBSTEPS_OF_PLANNER);
        filled
    }
}

/// Column of the table.
#[derive(Clone, Copy)]
struct Fill {
    effort: Effort,
    conditions: Conditions,
}

impl Fill {
    /// Fills in a setting that is left open.
    fn with<T: Copy>(self, setting: &mut Option<T>, row: &Row<T>) {
        setting.get_or_insert(row.value(self.effort, self.conditions));
    }
}
