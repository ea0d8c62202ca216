//! Scores of simulated instances: values of objectives by piece of a term, and d loss / d positions at frame
//! ends.

use std::sync::Arc;

use bendtwin_engine::{
    Error, Model, Term,
    backend::{Divergence, Instance, Loss},
    objective::WeightedTerm,
};
use cudarc::driver::CudaStream;

use crate::{
    device::{
        args::{
            ObjectiveArgs, Pointer, ScoreArgs, SeedArgs, SeedForcesArgs, SeedPosesArgs,
            SeedRestLengthsArgs,
        },
        kernels,
        launch::MOST_BLOCKS,
        memory::{Buffer, end_of},
        specialization::THREADS,
    },
    plan::{graph::NodeSprings, resident::resident},
    run::{
        objective::{DeviceObjective, Objectives},
        simulation::Simulation,
        skin::{self, Skins},
        world::force_stride,
    },
};

/// Objectives of all instances of a simulation.
pub(crate) struct Scores {
    objectives: Vec<Arc<DeviceObjective>>,
    objective_args: Buffer<ObjectiveArgs>,
    _nearest: Buffer<u32>,
    values: Buffer<f64>,
    value_starts: Vec<usize>,
    seeds: Option<Buffer<f32>>,
    seed_starts: Vec<usize>,
    /// d loss / d forces of instances that have them in their objectives, shape [F, forces].
    force_bars: Buffer<f32>,
    force_starts: Vec<usize>,
    skins: Skins,
    /// Keeps alive what the arguments point to.
    _springs: Vec<Arc<NodeSprings>>,
}

/// Bytes that seeds of an instance take.
pub(crate) fn seed_bytes(instance: &Instance) -> u64 {
    let nodes = instance.model.model().graph.node_count() as u64;
    12 * (instance.frames as u64 + 1) * nodes + skin::bytes_of(instance)
}

/// Refuses gradients of more frames than can be seeded in one launch, before anything is simulated.
pub(crate) fn refuse_too_long(instances: &[Instance]) -> Result<(), Error> {
    let most = MOST_BLOCKS - 1;
    match instances.iter().map(|i| i.frames).find(|&frames| frames > most) {
        Some(frames) => Err(Error::InvalidInput(format!(
            "{frames} frames in one gradient: {most} is the most on this device"
        ))),
        None => Ok(()),
    }
}

/// Memory for d loss / d forces of instances that have them in their objectives, and where each
/// begins.
fn force_bars(
    stream: &Arc<CudaStream>,
    instances: &[Instance],
) -> Result<(Buffer<f32>, Vec<usize>), Error> {
    let mut starts = vec![0];
    for instance in instances {
        let is_force = |t: &WeightedTerm| matches!(t.term, Term::Force { .. });
        let has = instance.objective.terms.iter().any(is_force);
        let count = if has { instance.frames * force_stride(instance) } else { 0 };
        starts.push(end_of(&starts) + count);
    }
    Ok((Buffer::zeros(stream, end_of(&starts))?, starts))
}

impl Scores {
    /// Scores all instances, whose frames have been run and kept. With `cut_every` also computes
    /// the seeds of their adjoints, cut each `cut_every` frames; see [`refuse_too_long`]. `known`
    /// has the objectives that are on the device already.
    pub(crate) fn new(
        simulation: &Simulation<'_>,
        known: &Objectives,
        cut_every: Option<usize>,
    ) -> Result<Self, Error> {
        let (queue, instances) = (simulation.queue, simulation.instances);
        let stream = &queue.stream;
        let objectives = instances
            .iter()
            .map(|i| known.get(stream, &i.objective, i.frames))
            .collect::<Result<Vec<_>, Error>>()?;
        let (mut nearest_starts, mut value_starts, mut seed_starts) = (vec![0], vec![0], vec![0]);
        for (instance, objective) in instances.iter().zip(&objectives) {
            let n = instance.model.model().graph.node_count();
            nearest_starts.push(end_of(&nearest_starts) + objective.target_count);
            value_starts.push(end_of(&value_starts) + objective.order.len());
            seed_starts.push(end_of(&seed_starts) + 3 * n * (instance.frames + 1));
        }
        let nearest = Buffer::empty(stream, end_of(&nearest_starts))?;
        let values = Buffer::empty(stream, end_of(&value_starts))?;
        let seeds = match cut_every {
            Some(_) => Some(Buffer::empty(stream, end_of(&seed_starts))?),
            None => None,
        };
        let (force_bars, force_starts) = match cut_every {
            Some(_) => force_bars(stream, instances)?,
            None => (Buffer::empty(stream, 0)?, vec![0; instances.len() + 1]),
        };
        let skins = Skins::new(queue, instances, &objectives, cut_every.is_some())?;
        let mut objective_args = Vec::with_capacity(instances.len());
        let mut springs = Vec::new();
        for (i, (instance, objective)) in instances.iter().zip(&objectives).enumerate() {
            let graph = &instance.model.model().graph;
            let strains = if objective.has_strains {
                let resident = resident(&instance.model)?;
                let by_node = resident.graph.node_springs(&resident.device)?;
                let strains = ObjectiveArgs {
                    springs: resident.graph.springs.address(),
                    params: resident.params.address(),
                    spring_starts: by_node.starts.address(),
                    node_springs: by_node.springs.address(),
                    spring_count: graph.springs.len() as u32,
                    strained_count: strained(instance.model.model()),
                    ..ObjectiveArgs::default()
                };
                springs.push(by_node);
                strains
            } else {
                ObjectiveArgs::default()
            };
            let own = objective.args(graph.node_count(), graph.surface_count());
            let (skin, point_bars) = skins.of(i);
            objective_args.push(ObjectiveArgs {
                springs: strains.springs,
                params: strains.params,
                spring_starts: strains.spring_starts,
                node_springs: strains.node_springs,
                spring_count: strains.spring_count,
                strained_count: strains.strained_count,
                states: simulation.states_of(i),
                nearest: nearest.at(nearest_starts[i]),
                values: values.at(value_starts[i]),
                seeds: seeds
                    .as_ref()
                    .map_or_else(Pointer::default, |s: &Buffer<f32>| s.at(seed_starts[i])),
                cut_every: cut_every.unwrap_or(0).min(u32::MAX as usize) as u32,
                control_count: graph.control_count() as u32,
                world: simulation.worlds.args(i),
                skin,
                point_bars,
                force_bars: if force_starts[i + 1] > force_starts[i] {
                    force_bars.at(force_starts[i])
                } else {
                    Pointer::default()
                },
                ..own
            });
        }
        let objective_args = Buffer::of(stream, &objective_args)?;
        let this = Self {
            objectives,
            objective_args,
            _nearest: nearest,
            values,
            value_starts,
            seeds,
            seed_starts,
            skins,
            _springs: springs,
            force_bars,
            force_starts,
        };
        this.launch(simulation)?;
        Ok(this)
    }

    fn launch(&self, simulation: &Simulation<'_>) -> Result<(), Error> {
        let (queue, instances) = (simulation.queue, simulation.instances);
        let pieces = self.objectives.iter().map(|o| o.order.len()).max().unwrap_or(0);
        let graph = |i: &Instance| i.model.model().graph.node_count();
        let nodes = instances.iter().map(graph).max().unwrap_or(0);
        let frames = instances.iter().map(|i| i.frames).max().unwrap_or(0);
        for first in (0..instances.len()).step_by(MOST_BLOCKS) {
            let count = MOST_BLOCKS.min(instances.len() - first) as u32;
            let objectives = self.objective_args.at(first);
            let launch = queue.grid(pieces.min(MOST_BLOCKS) as u32, count, 1);
            // SAFETY: the objectives' arrays have room for all pieces, targets, frames and nodes.
            unsafe { kernels::score(&launch, &ScoreArgs { objectives })? };
            if self.seeds.is_none() {
                continue;
            }
            self.skins.seed(queue, objectives, count)?;
            let launch = queue.grid((nodes as u32).div_ceil(THREADS), frames as u32 + 1, count);
            // SAFETY: as above.
            unsafe { kernels::seed(&launch, &SeedArgs { objectives })? };
            if self.force_bars.len() > 0 {
                let launch = queue.grid(count, 1, 1);
                // SAFETY: instances with such terms have forces of all frames, and places for these.
                unsafe { kernels::seed_forces(&launch, &SeedForcesArgs { objectives })? };
            }
        }
        Ok(())
    }

    /// Adds d loss / d rest lengths by the terms themselves to gradients by parameters, whose
    /// addresses are by instance.
    pub(crate) fn add_rest_lengths(
        &self,
        simulation: &Simulation<'_>,
        gradients: &[Pointer<f32>],
    ) -> Result<(), Error> {
        if !self.objectives.iter().any(|o| o.has_strains) {
            return Ok(());
        }
        let queue = simulation.queue;
        let outs = Buffer::of(&queue.stream, gradients)?;
        let springs = simulation.instances.iter().map(|i| i.model.model().graph.springs.len());
        let most = springs.max().unwrap_or(0) as u32;
        for first in (0..gradients.len()).step_by(MOST_BLOCKS) {
            let count = MOST_BLOCKS.min(gradients.len() - first) as u32;
            let args = SeedRestLengthsArgs {
                objectives: self.objective_args.at(first),
                outs: outs.at(first),
            };
            let launch = queue.grid(most.div_ceil(THREADS), count, 1);
            // SAFETY: each gradient has a place for the rest length of every spring of its instance.
            unsafe { kernels::seed_rest_lengths(&launch, &args)? };
        }
        Ok(())
    }

    /// Adds d loss / d poses by the terms themselves to gradients by poses, whose addresses are by
    /// instance.
    pub(crate) fn add_poses(
        &self,
        simulation: &Simulation<'_>,
        gradients: &[Pointer<f32>],
    ) -> Result<(), Error> {
        let depends = |i: &Instance| {
            i.objective.terms.iter().any(|t| matches!(t.term, Term::Clearance { .. }))
        };
        if !simulation.instances.iter().any(depends) {
            return Ok(());
        }
        let queue = simulation.queue;
        let outs = Buffer::of(&queue.stream, gradients)?;
        let args =
            SeedPosesArgs { objectives: self.objective_args.address(), outs: outs.address() };
        // SAFETY: each gradient has a place for every pose of its instance.
        unsafe { kernels::seed_poses(&queue.grid(gradients.len() as u32, 1, 1), &args) }
    }

    /// Address of d loss / d forces of an instance in a frame, 0-based; null if none are in its
    /// objective.
    pub(crate) fn force_bars(
        &self,
        simulation: &Simulation<'_>,
        index: usize,
        frame: usize,
    ) -> Pointer<f32> {
        let at = self.force_starts[index];
        if self.force_starts[index + 1] == at {
            return Pointer::default();
        }
        self.force_bars.at(at + frame * force_stride(&simulation.instances[index]))
    }

    /// Address of d loss / d positions of an instance at the end of a frame.
    pub(crate) fn seed(
        &self,
        simulation: &Simulation<'_>,
        index: usize,
        frame: usize,
    ) -> Pointer<f32> {
        let n = simulation.instances[index].model.model().graph.node_count();
        let at = self.seed_starts[index] + 3 * n * frame;
        self.seeds.as_ref().map_or_else(Pointer::default, |s| s.at(at))
    }

    /// Costs by frame and group of each instance, shape [F + 1, groups], infinite from the frame of a
    /// divergence on; waits for the device.
    pub(crate) fn frame_costs(
        &self,
        simulation: &Simulation<'_>,
        diverged: &[Option<Divergence>],
    ) -> Result<Vec<Vec<f64>>, Error> {
        let values = self.values.read()?;
        let each = simulation.instances.iter().zip(&self.objectives).enumerate();
        let costs = each.map(|(i, (instance, objective))| {
            let groups = instance.objective.groups.len();
            let own = &values[self.value_starts[i]..self.value_starts[i + 1]];
            unless_diverged(diverged[i], objective.frame_groups(own, groups), groups)
        });
        Ok(costs.collect())
    }

    /// The losses; waits for the device.
    pub(crate) fn losses(
        &self,
        simulation: &Simulation<'_>,
        diverged: &[Option<Divergence>],
    ) -> Result<Vec<Loss>, Error> {
        let values = self.values.read()?;
        let each = simulation.instances.iter().zip(&self.objectives).enumerate();
        let loss = each.map(|(i, (instance, objective))| {
            let groups = instance.objective.groups.len();
            let own = &values[self.value_starts[i]..self.value_starts[i + 1]];
            loss(diverged[i], objective.groups(own, groups))
        });
        Ok(loss.collect())
    }
}

/// Springs that a strain is measured of.
fn strained(model: &Model) -> u32 {
    let n = model.graph.node_count();
    let springs = model.graph.springs.iter().zip(&model.params.rest_lengths_m);
    springs.filter(|(ends, rest)| **rest > 0.0 && ends.iter().all(|&e| (e as usize) < n)).count()
        as u32
}

/// A loss of these groups; infinite if it diverged.
pub(crate) fn loss(diverged: Option<Divergence>, groups: Vec<f64>) -> Loss {
    let groups = match diverged {
        None => groups,
        Some(_) => vec![f64::INFINITY; groups.len()],
    };
    let total = if diverged.is_some() { f64::INFINITY } else { groups.iter().sum() };
    Loss { total, groups, diverged }
}

/// Costs by frame, infinite from a divergence on.
pub(crate) fn unless_diverged(
    diverged: Option<Divergence>,
    mut costs: Vec<f64>,
    groups: usize,
) -> Vec<f64> {
    let good = diverged.map_or(costs.len(), |d| d.frame * groups).min(costs.len());
    costs[good..].fill(f64::INFINITY);
    costs
}
