//! Choice of the team that simulates an instance: its blocks, their shape, and the instances run
//! concurrently. Made by a model of the time of a substep, and reported.

use bendtwin_core::Graph;
use bendtwin_engine::{Error, Model};

use crate::{
    device::{
        Capabilities,
        specialization::{Source, Specialization, WorldParts},
        team::{BLOCK_THREADS, TEAM_THREADS, Team, TeamShape},
    },
    plan::{
        layout::Layout,
        layouts::{Cut, Layouts},
        resident::{has_contact, has_skin_contact},
    },
};

/// Purpose of a team.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Purpose {
    /// Frames forward.
    Forward,
    /// Frames forward onto tape.
    Tape,
    /// A frame backward.
    Backward,
}

impl Purpose {
    /// The kernel for it.
    pub(crate) fn kernel(self) -> &'static str {
        match self {
            Self::Forward | Self::Tape => "advance_frames",
            Self::Backward => "back_frame",
        }
    }
}

/// Inputs to the choice of a team beside the model and its surroundings.
#[derive(Clone, Copy)]
pub(crate) struct Shapes<'a> {
    /// Layouts of the model's graph.
    pub(crate) layouts: &'a Layouts,
    /// All springs have the same dashpot.
    pub(crate) uniform_dashpot: bool,
    /// Forces this kind of team, in place of the best.
    pub(crate) team: Option<Team>,
}

/// Launch of a team for a model: the kernel's specialization, and its memory.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LaunchPlan {
    pub(crate) team: Team,
    pub(crate) specialization: Specialization,
    pub(crate) shared_bytes: u32,
    /// Float4s that a block needs in global memory.
    pub(crate) spill_stride: u32,
    /// Estimated microseconds of a substep of the whole batch.
    pub(crate) substep_us: f64,
}

/// Result of fitting a team into a device's memory.
pub(crate) enum Fit {
    /// The team can run.
    Fits(LaunchPlan),
    /// A block would need more shared memory than it can have.
    TooLarge {
        /// Shared memory that the block would need [bytes].
        bytes: u64,
    },
}

/// Microseconds of a substep that do not shrink with more blocks: latencies of a node's update and
/// of barriers.
const BLOCK_US: f64 = 0.1;
const CLUSTER_US: f64 = 0.62;
const GRID_US: f64 = 2.2;
const GRID_BACK_US: f64 = 3.3;
/// Time of a half-spring on one multiprocessor, forward and backward.
const HALF_SPRING_US: f64 = 0.265e-3;
const HALF_SPRING_BACK_US: f64 = 0.64e-3;
/// Extra time of a backward pass whose sums are all in memory, as a share.
const SUMS_IN_MEMORY: f64 = 0.3;
/// Time of an end of a triplet, in half-springs.
const TRIPLET_END: f64 = 1.5;
/// Float4s of a local node forward.
const STATES: u64 = 3;
/// Registers of a multiprocessor, and those that a thread needs beside its half-springs and sums.
const REGISTERS: u32 = 65_536;
const WORKING_REGISTERS: u32 = 72;
const WORKING_REGISTERS_BACKWARD: u32 = 86;
/// And those for what surrounds the object.
const WORLD_REGISTERS: u32 = 32;

/// The best team, among those that fit the device, for a batch of instances of one graph, `alike`
/// of which share their parameters.
pub(crate) fn choose(
    capabilities: &Capabilities,
    shapes: &Shapes<'_>,
    model: &Model,
    purpose: Purpose,
    world: WorldParts,
    batch: usize,
    alike: usize,
) -> Result<LaunchPlan, Error> {
    let mut candidates = match shapes.team {
        Some(team) => vec![(BLOCK_US, for_purpose(team, purpose))],
        None => candidates(capabilities, &model.graph, purpose, batch, alike),
    };
    if !model.graph.rods.is_empty() {
        // A rod's twist depends on all of its nodes: they stay in one block.
        let chosen = shapes.team.is_some();
        candidates.iter_mut().filter(|_| chosen).for_each(|(_, t)| t.keep_together());
        candidates.retain(|(_, t)| t.shape == TeamShape::Block);
    }
    if has_contact(model) {
        candidates.iter_mut().for_each(|(_, t)| t.instances = 1);
    }
    candidates.sort_by(|a, b| a.0.total_cmp(&b.0));
    let chosen = shapes.team.is_some();
    let wasteful = |f: &LaunchPlan| !chosen && f.team.instances > 1 && f.specialization.spills();
    let mut least = u64::MAX;
    let mut best: Option<LaunchPlan> = None;
    for (substep_us, team) in candidates {
        if best.is_some_and(|b| b.substep_us <= substep_us) {
            break;
        }
        match fit(capabilities, shapes, model, purpose, world, team)? {
            // Interleaved instances pay for what does not fit several times.
            Fit::Fits(plan) if wasteful(&plan) => {}
            Fit::Fits(plan) => {
                let plan = LaunchPlan { substep_us: substep_us * plan.substep_us, ..plan };
                if best.is_none_or(|b| plan.substep_us < b.substep_us) {
                    best = Some(plan);
                }
            }
            Fit::TooLarge { bytes } => least = least.min(bytes),
        }
    }
    best.ok_or_else(|| {
        Error::InvalidModel(format!(
            "a block would need {least} bytes of shared memory, it can have {}: use a coarser twin",
            capabilities.shared_bytes
        ))
    })
}

/// True if some team is certain to fit a model: a single block can hold the states of all nodes,
/// for any graph.
pub(crate) fn fits_one_block(
    capabilities: &Capabilities,
    shapes: &Shapes<'_>,
    model: &Model,
) -> bool {
    let graph = &model.graph;
    let states = 16 * STATES * (graph.node_count() + graph.control_count()) as u64;
    shapes.team.is_none() && states <= u64::from(capabilities.dynamic_shared())
}

/// The team for another purpose.
fn for_purpose(team: Team, purpose: Purpose) -> Team {
    let instances = if purpose == Purpose::Forward { team.instances } else { 1 };
    Team { instances, ..team }
}

/// Teams with the microseconds that a substep of the whole batch takes at least.
fn candidates(
    capabilities: &Capabilities,
    graph: &Graph,
    purpose: Purpose,
    batch: usize,
    alike: usize,
) -> Vec<(f64, Team)> {
    let work = 2.0 * graph.springs.len() as f64 + TRIPLET_END * 3.0 * graph.triplets.len() as f64;
    let (half_spring_us, grid_us) = match purpose {
        Purpose::Backward => (HALF_SPRING_BACK_US, GRID_BACK_US),
        _ => (HALF_SPRING_US, GRID_US),
    };
    let mut found = Vec::new();
    let mut add =
        |shape, blocks: u32, threads: u32, instances: u32, fixed_us: f64, capacity: f64| {
            let teams = (batch as f64 / f64::from(instances)).ceil();
            let own = work / f64::from(blocks);
            let one = fixed_us + own * f64::from(instances) * half_spring_us;
            let rounds = (teams / capacity.max(1.0)).ceil().max(1.0);
            found.push((rounds * one, Team { shape, blocks, threads, instances }));
        };
    let processors = f64::from(capabilities.processors);
    add(TeamShape::Block, 1, BLOCK_THREADS, 1, BLOCK_US, processors);
    if purpose == Purpose::Forward {
        for instances in [2, 4] {
            if alike >= capabilities.processors as usize * instances as usize {
                add(TeamShape::Block, 1, BLOCK_THREADS, instances, BLOCK_US, processors);
            }
        }
    }
    for blocks in [2, 4, 8, 16].into_iter().filter(|&b| b <= capabilities.cluster) {
        // Clusters do not fill the device: their blocks share a part of it.
        let capacity =
            (processors * (1.0 - 0.0078 * f64::from(blocks)) / f64::from(blocks)).floor();
        add(TeamShape::Cluster, blocks, BLOCK_THREADS, 1, CLUSTER_US, capacity);
    }
    let mut blocks = 32;
    while blocks <= capabilities.processors {
        let capacity = (processors / f64::from(blocks)).floor();
        add(TeamShape::Grid, blocks, TEAM_THREADS, 1, grid_us, capacity);
        blocks *= 2;
    }
    add(TeamShape::Grid, capabilities.processors, TEAM_THREADS, 1, grid_us, 1.0);
    found
}

/// Plan of a team for a model, if its memory fits the device. Its `substep_us` is a factor to the
/// estimate of [`candidates`].
pub(crate) fn fit(
    capabilities: &Capabilities,
    shapes: &Shapes<'_>,
    model: &Model,
    purpose: Purpose,
    world: WorldParts,
    team: Team,
) -> Result<Fit, Error> {
    let layout = match shapes.layouts.of(Cut::of(&team)) {
        Ok(layout) => layout,
        // Too many local nodes for this cut: another may do.
        Err(Error::InvalidModel(_)) => return Ok(Fit::TooLarge { bytes: u64::MAX }),
        Err(e) => return Err(e),
    };
    let room = u64::from(capabilities.dynamic_shared());
    let states = 16 * state_float4s(&layout, purpose, team.instances);
    if states > room {
        return Ok(Fit::TooLarge { bytes: states });
    }
    let mut specialization = specialization(&layout, shapes, model, purpose, world, team);
    let mut used = states;
    let bend = bend_float4s(&layout, purpose, team.instances);
    specialization.bend_in_shared = used + 16 * bend <= room;
    if specialization.bend_in_shared {
        used += 16 * bend;
    }
    let pair_bytes = if specialization.uniform_dashpot { 20 } else { 28 };
    let pairs = match purpose {
        Purpose::Backward => layout.max_all_pairs,
        _ if world.forces => layout.max_all_pairs,
        _ => layout.max_pairs,
    };
    let half_springs = (u64::from(pairs) * pair_bytes).next_multiple_of(16);
    let in_registers = purpose != Purpose::Backward
        && !world.forces
        && specialization.held >= layout.max_row_pairs;
    specialization.half_springs_in_shared = !in_registers && used + half_springs <= room;
    if specialization.half_springs_in_shared {
        used += half_springs;
    }
    let spill_stride = if specialization.bend_in_shared { 0 } else { bend as u32 };
    let shared_bytes = used as u32;
    let substep_us = match purpose {
        Purpose::Backward => 1.0 + SUMS_IN_MEMORY * share_in_memory(&layout, &specialization),
        _ => 1.0,
    };
    Ok(Fit::Fits(LaunchPlan { team, specialization, shared_bytes, spill_stride, substep_us }))
}

/// Share of the springs' sums that are not in registers.
fn share_in_memory(layout: &Layout, specialization: &Specialization) -> f64 {
    let rows: u32 = layout.shares.iter().map(|s| s.rows).sum();
    let mean = f64::from(layout.sum_pairs) / f64::from(rows.max(1));
    ((mean - f64::from(specialization.held_sums)) / mean.max(1.0)).clamp(0.0, 1.0)
}

fn state_float4s(layout: &Layout, purpose: Purpose, instances: u32) -> u64 {
    let stride = u64::from(layout.stride());
    match purpose {
        Purpose::Backward => 5 * stride + 2 * u64::from(layout.control_base),
        _ => STATES * stride * u64::from(instances),
    }
}

/// Float4s of what a block's triplets leave for their ends.
fn bend_float4s(layout: &Layout, purpose: Purpose, instances: u32) -> u64 {
    let triplets = u64::from(layout.max_triplets);
    // Vectors of three floats, forward those of 32 triplets together.
    let vectors = match purpose {
        Purpose::Backward => triplets * 4,
        _ => triplets.next_multiple_of(32) * 3 * u64::from(instances),
    };
    (vectors * 3).div_ceil(4)
}

fn specialization(
    layout: &Layout,
    shapes: &Shapes<'_>,
    model: &Model,
    purpose: Purpose,
    world: WorldParts,
    team: Team,
) -> Specialization {
    let one_row = layout.max_rows * 32 <= team.threads;
    // Graphs that differ a little share a kernel. Registers are handed out to four warps at a time
    // anyway.
    let threads = if one_row { (layout.max_rows * 32).next_multiple_of(128) } else { team.threads };
    let threads = threads.clamp(64, team.threads.max(64));
    let even = |pairs: u32| pairs.next_multiple_of(2);
    let registers = (REGISTERS / threads.next_multiple_of(128) / 8 * 8).min(248);
    let uniform_dashpot = shapes.uniform_dashpot;
    let more = if world == WorldParts::default() { 0 } else { WORLD_REGISTERS };
    let (held, held_sums) = match purpose {
        Purpose::Backward => {
            let room = registers.saturating_sub(WORKING_REGISTERS_BACKWARD + more) / 6;
            let sums = if one_row { room.min(even(layout.max_sum_pairs)) } else { 0 };
            (sums, sums)
        }
        _ if one_row && team.instances == 1 => {
            let a_pair = if uniform_dashpot { 5 } else { 7 };
            let room = registers.saturating_sub(WORKING_REGISTERS + more) / a_pair;
            (room.min(even(layout.max_row_pairs)), 0)
        }
        _ => (0, 0),
    };
    Specialization {
        source: match purpose {
            Purpose::Backward => Source::Adjoint,
            _ => Source::Integrate,
        },
        shape: team.shape,
        blocks: team.blocks,
        instances: team.instances,
        lanes: layout.lanes,
        threads,
        one_row,
        held,
        held_always: held.min(layout.min_row_pairs) / 2 * 2,
        held_sums,
        uniform_dashpot,
        bending: !(model.graph.triplets.is_empty() && model.graph.rods.is_empty()),
        rods: model.graph.rods.len() as u32,
        ground: model.environment.ground.is_some(),
        contact: has_contact(model),
        skin_contact: has_skin_contact(model),
        tape: purpose == Purpose::Tape,
        world,
        half_springs_in_shared: false,
        bend_in_shared: false,
    }
}
