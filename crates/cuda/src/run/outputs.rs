//! Outputs of a rollout beside its costs.

use std::collections::HashMap;

use bendtwin_core::Point;
use bendtwin_engine::{
    Energies, Energy, Error, Model,
    backend::{Diagnose, Diagnostics, Instance, Loss, Outputs, Rollout},
    model::{State, ground_contacts},
};

use crate::{
    device::{
        args::{ExtremesArgs, OutputArgs, Pointer, RecordArgs},
        kernels,
        launch::MOST_BLOCKS,
        memory::{Buffer, end_of},
        specialization::THREADS,
    },
    plan::resident::{has_skin_contact, resident},
    run::simulation::{RetainedStates, Simulation},
};

/// Models arranged at a time: some hundred kilobytes each.
const KNOWN_MODELS: usize = 32;

/// Recorded arrays of a simulation's instances, on the device.
pub(crate) struct RecordedOutputs {
    frames: Vec<Vec<u32>>,
    positions: Buffer<[f32; 3]>,
    /// Velocities, laid out like `positions`; empty if not requested.
    velocities: Buffer<[f32; 3]>,
    starts: Vec<usize>,
    /// Largest strain, that of springs to control points, and speed, by frame.
    extremes: Buffer<[f32; 3]>,
    extreme_starts: Vec<usize>,
}

/// States that a rollout needs.
pub(crate) fn retained_states(batch: &[Instance], outputs: &Outputs) -> RetainedStates {
    let scored = batch.iter().any(|i| !i.objective.terms.is_empty());
    let all = scored || outputs.every > 0 || outputs.initial || diagnoses(outputs);
    if all { RetainedStates::All } else { RetainedStates::Last }
}

fn diagnoses(outputs: &Outputs) -> bool {
    outputs.diagnose != Diagnose::Nothing
}

/// Frames that a rollout records.
fn frames(instance: &Instance, outputs: &Outputs) -> Vec<u32> {
    let every = outputs.every;
    (0..=instance.frames)
        .filter(|&f| if f == 0 { outputs.initial } else { every > 0 && f % every == 0 })
        .map(|f| f as u32)
        .collect()
}

impl RecordedOutputs {
    /// Gathers the recorded values of instances that have been run.
    pub(crate) fn new(simulation: &Simulation<'_>, outputs: &Outputs) -> Result<Self, Error> {
        let (queue, instances) = (simulation.queue, simulation.instances);
        let stream = &queue.stream;
        let frames: Vec<Vec<u32>> = instances.iter().map(|i| frames(i, outputs)).collect();
        let node_count = |i: &Instance| i.model.model().graph.node_count();
        let nodes = |i: &Instance| outputs.nodes.as_ref().map_or(node_count(i), |n| n.len());
        let (mut starts, mut extreme_starts, mut frame_starts) = (vec![0], vec![0], vec![0]);
        for (instance, frames) in instances.iter().zip(&frames) {
            starts.push(end_of(&starts) + frames.len() * nodes(instance));
            let measured = if diagnoses(outputs) { instance.frames } else { 0 };
            extreme_starts.push(end_of(&extreme_starts) + measured);
            frame_starts.push(end_of(&frame_starts) + frames.len());
        }
        let positions = Buffer::empty(stream, end_of(&starts))?;
        let with_velocities = if outputs.velocities { end_of(&starts) } else { 0 };
        let velocities: Buffer<[f32; 3]> = Buffer::empty(stream, with_velocities)?;
        let extremes = Buffer::empty(stream, end_of(&extreme_starts))?;
        let all_frames = Buffer::of(stream, &frames.concat())?;
        let selected = match &outputs.nodes {
            Some(nodes) => Some(Buffer::of(stream, nodes)?),
            None => None,
        };
        let mut output_args = Vec::with_capacity(instances.len());
        for (i, instance) in instances.iter().enumerate() {
            let resident = resident(&instance.model)?;
            let graph = &resident.graph.graph;
            output_args.push(OutputArgs {
                states: simulation.states_of(i),
                frames: all_frames.at(frame_starts[i]),
                nodes: selected.as_ref().map_or_else(Pointer::default, Buffer::address),
                positions: positions.at(starts[i]),
                springs: resident.graph.springs.address(),
                params: resident.params.address(),
                controls: simulation.controls_of(i),
                velocities: if outputs.velocities {
                    velocities.at(starts[i])
                } else {
                    Pointer::default()
                },
                extremes: extremes.at(extreme_starts[i]),
                node_count: graph.node_count() as u32,
                recorded_nodes: nodes(instance) as u32,
                recorded_frames: frames[i].len() as u32,
                slot_count: simulation.slots_of(i) as u32,
                spring_count: graph.springs.len() as u32,
                control_count: graph.control_count() as u32,
                frame_count: instance.frames as u32,
                pad: 0,
            });
        }
        let output_args = Buffer::of(stream, &output_args)?;
        let most_nodes = instances.iter().map(nodes).max().unwrap_or(0) as u32;
        let most_frames = frames.iter().map(Vec::len).max().unwrap_or(0);
        let longest = instances.iter().map(|i| i.frames).max().unwrap_or(0);
        for first in (0..instances.len()).step_by(MOST_BLOCKS) {
            let count = MOST_BLOCKS.min(instances.len() - first) as u32;
            let args = output_args.at(first);
            if most_frames > MOST_BLOCKS {
                return Err(Error::InvalidInput(format!(
                    "{most_frames} recorded frames: {MOST_BLOCKS} is the most on this device"
                )));
            }
            let launch = queue.grid(most_nodes.div_ceil(THREADS), most_frames as u32, count);
            // SAFETY: the arrays have room for all recorded frames and nodes, which exist.
            unsafe { kernels::record(&launch, &RecordArgs { outputs: args })? };
            if diagnoses(outputs) {
                let launch = queue.grid(longest as u32, count, 1);
                // SAFETY: as above, for every frame.
                unsafe { kernels::extremes(&launch, &ExtremesArgs { outputs: args })? };
            }
        }
        Ok(Self { frames, positions, velocities, starts, extremes, extreme_starts })
    }

    /// The rollouts with their losses and costs by frame; waits for the device.
    pub(crate) fn rollouts(
        &self,
        simulation: &Simulation<'_>,
        outputs: &Outputs,
        losses: Vec<(Loss, Vec<f64>)>,
    ) -> Result<Vec<Rollout>, Error> {
        let positions = simulation.queue.fetch(&self.positions)?;
        let velocities = simulation.queue.fetch(&self.velocities)?;
        let extremes = self.extremes.read()?;
        let forces = match outputs.forces {
            true => simulation.worlds.forces(simulation.queue)?,
            false => Vec::new(),
        };
        let instances = simulation.instances;
        let reached = |i: usize, loss: &Loss| {
            loss.diverged.map_or(instances[i].frames, |d| d.frame.saturating_sub(1))
        };
        let end = |(i, (loss, _)): (usize, &(Loss, _))| {
            let measured = match outputs.diagnose {
                Diagnose::All => true,
                Diagnose::Extremes => instances[i].frames == 0,
                Diagnose::Nothing => false,
            };
            let asked = outputs.final_state && loss.diverged.is_none();
            (asked || measured).then(|| reached(i, loss))
        };
        let ends: Vec<Option<usize>> = losses.iter().enumerate().map(end).collect();
        let last = simulation.states(&ends)?;
        let mut energies = KnownModels::default();
        let mut rollouts = Vec::with_capacity(losses.len());
        for (i, ((loss, frame_costs), last)) in losses.into_iter().zip(last).enumerate() {
            let (instance, reached) = (&instances[i], reached(i, &loss));
            let kept = self.frames[i].iter().take_while(|&&f| f as usize <= reached);
            let frames: Vec<usize> = kept.map(|&f| f as usize).collect();
            let own = &positions[self.starts[i]..self.starts[i + 1]];
            let a_frame = own.len() / self.frames[i].len().max(1);
            let diagnostics = diagnoses(outputs).then(|| {
                let extremes = &extremes[self.extreme_starts[i]..][..reached];
                let energies = (outputs.diagnose == Diagnose::All).then_some(&mut energies);
                diagnose(instance, reached, last.as_ref(), extremes, energies)
            });
            let recorded = frames.len() * a_frame;
            let own_velocities = velocities.get(self.starts[i]..self.starts[i] + recorded);
            rollouts.push(Rollout {
                positions: own[..recorded].to_vec(),
                velocities: own_velocities.unwrap_or_default().to_vec(),
                frame_costs,
                frames,
                cost: loss.total,
                group_costs: loss.groups,
                final_state: last.filter(|_| outputs.final_state && loss.diverged.is_none()),
                diagnostics,
                forces: outputs.forces.then(|| {
                    let end = loss.diverged.map_or(instance.frames, |d| d.frame - 1);
                    simulation.worlds.forces_on(i, instance, end, &forces)
                }),
                diverged: loss.diverged,
            });
        }
        Ok(rollouts)
    }
}

/// Models of a batch arranged for energies. Instances mostly share theirs, and to arrange one takes
/// longer than to simulate a frame of it.
#[derive(Default)]
struct KnownModels(HashMap<*const Model, Option<Energies>>);

impl KnownModels {
    fn energy(&mut self, model: &Model, state: &State, controls: &[Point]) -> Energy {
        if self.0.len() >= KNOWN_MODELS {
            self.0.clear();
        }
        let known = self.0.entry(std::ptr::from_ref(model)).or_insert_with(|| Energies::new(model));
        known.as_ref().and_then(|e| e.of(state, controls)).unwrap_or_default()
    }
}

/// Diagnostics of the frames that were reached, the last of which ended in a state; that is needed
/// for energies, if they are asked for, and where there is no frame. There are no energies if it was
/// not the last of all.
fn diagnose(
    instance: &Instance,
    reached: usize,
    last: Option<&State>,
    extremes: &[[f32; 3]],
    energies: Option<&mut KnownModels>,
) -> Diagnostics {
    let model = instance.model.model();
    let [max_strain, max_control_strain, max_speed_m_s] = match last {
        Some(state) if instance.frames == 0 => at_rest(instance, state),
        _ => [0, 1, 2].map(|k| extremes.iter().map(|e| e[k]).fold(0.0, f32::max)),
    };
    let mut found = Diagnostics {
        max_strain,
        max_control_strain,
        max_speed_m_s,
        kinetic_energy: f32::NAN,
        elastic_energy: f32::NAN,
        ground_contacts: 0,
    };
    let (Some(last), Some(energies)) = (last, energies) else { return found };
    if reached == instance.frames {
        let controls = model.graph.control_count();
        let held = &instance.controls[reached * controls..(reached + 1) * controls];
        let energy = energies.energy(model, last, held);
        found.kinetic_energy = energy.kinetic as f32;
        found.elastic_energy = energy.elastic as f32;
    }
    if let Some(ground) = model.environment.ground {
        let skin = has_skin_contact(model).then_some(&*model.skin);
        found.ground_contacts = ground_contacts(&ground, skin, &last.positions);
    }
    found
}

/// Largest strains, as [`Diagnostics`] has them, and speed of a state that no frame has followed.
fn at_rest(instance: &Instance, state: &State) -> [f32; 3] {
    let model = instance.model.model();
    let n = model.graph.node_count();
    let at = |e: u32| match e as usize {
        i if i < n => state.positions[i],
        i => instance.controls[i - n],
    };
    let length = |d: [f32; 3]| d.iter().map(|x| x * x).sum::<f32>().sqrt();
    let mut strains = [0.0_f32; 2];
    for (&[a, b], &rest) in model.graph.springs.iter().zip(&model.params.rest_lengths_m) {
        if rest > 0.0 {
            let (from, to) = (at(a), at(b));
            let strain = (length(std::array::from_fn(|k| to[k] - from[k])) / rest - 1.0).abs();
            let kind = &mut strains[usize::from(a.max(b) as usize >= n)];
            *kind = kind.max(strain);
        }
    }
    [strains[0], strains[1], state.velocities.iter().map(|&v| length(v)).fold(0.0, f32::max)]
}
