//! Surroundings of the instances of a batch, on the device: bodies, colliders, grasps and what they
//! hold, forces.

mod upload;

use std::collections::BTreeSet;

use bendtwin_core::Point;
use bendtwin_engine::{
    Error, Term,
    backend::{Forces, Instance},
    world::{Grasping, Hold, Phase, Region},
};
use cudarc::driver::CudaStream;

use self::upload::{Parts, encode_phase, initial_phases};
use crate::{
    device::{
        args::{self, ChangeGraspsArgs, InstanceArgs, Pointer, WorldArgs},
        kernels,
        launch::Launch,
        memory::{Buffer, end_of},
        queue::Queue,
        specialization::WorldParts,
    },
    run::group::InstanceSpan,
};

/// Kinds of impulses of a node beside those by colliders; see `kernels/force.cuh`.
const IMPULSES: usize = 15;

/// Surroundings of a batch's instances.
pub(crate) struct Worlds {
    parts: Vec<WorldParts>,
    args: Vec<WorldArgs>,
    /// Frames in front of which a launch has to end, since grasps open or close there.
    boundaries: BTreeSet<usize>,
    uploaded: Parts,
    holds: Buffer<args::Hold>,
    hold_starts: Vec<usize>,
    phases: Buffer<u32>,
    phase_starts: Vec<usize>,
    spans: Buffer<args::RodSpan>,
    span_starts: Vec<usize>,
    impulses: Buffer<f32>,
    impulse_starts: Vec<usize>,
    forces: Buffer<f32>,
    force_starts: Vec<usize>,
}

/// The parts of its surroundings that an instance has; `measured` where its forces are asked for.
pub(crate) fn parts_of(instance: &Instance, measured: bool) -> WorldParts {
    let (world, model) = (&instance.world, instance.model.model());
    let colliders = !world.colliders.is_empty();
    let has_term = || instance.objective.terms.iter().any(|t| matches!(t.term, Term::Force { .. }));
    WorldParts {
        grasps: !world.grasps.is_empty(),
        colliders,
        smooth: world.smoothing_m > 0.0 && (colliders || model.environment.ground.is_some()),
        rolls: !instance.motion.rolls.is_empty(),
        forces: measured || can_slip(instance) || has_term(),
    }
}

/// True if a grasp of an instance releases when it is pulled too hard.
fn can_slip(instance: &Instance) -> bool {
    instance.world.grasps.iter().any(|g| g.max_force.is_finite())
}

/// Holds of an instance's grasps at its start, with other places, by node.
pub(crate) fn start(instance: &Instance, place: impl Fn(usize) -> Point) -> Grasping {
    let given = &instance.initial.grasping.holds;
    Grasping {
        phases: initial_phases(instance).into_iter().map(decode_phase).collect(),
        holds: given.iter().map(|h| Hold { place: place(h.node as usize), ..*h }).collect(),
    }
}

/// True for a control point that no grasp holds when the first frame of an instance begins, though
/// one has it.
pub(crate) fn begins_released(instance: &Instance, control: u32) -> bool {
    let phases = initial_phases(instance);
    let has = |region: &Region| controls_of(region).is_some_and(|c| c.contains(&control));
    instance.world.grasps.iter().enumerate().any(|(g, grasp)| {
        let opens = instance.motion.closed.get(g) == Some(&false);
        has(&grasp.region) && (phases[g] != encode_phase(Phase::Closed) || opens)
    })
}

/// Floats of a frame's forces.
pub(crate) fn force_stride(instance: &Instance) -> usize {
    let controls = instance.model.model().graph.control_count();
    let world = &instance.world;
    6 * (controls + world.grasps.len() + world.colliders.len()) + 3
}

fn impulse_count(instance: &Instance) -> usize {
    (IMPULSES + 6 * instance.world.colliders.len()) * instance.model.model().graph.node_count()
}

/// Slots of holds, for a number of slots of states: one more, since there are holds before the
/// first frame and after the last.
fn hold_slots(state_slots: usize, keeps_all: bool) -> usize {
    if keeps_all { state_slots + 1 } else { 2 }
}

/// Bytes that an instance's surroundings take, given its slots of states.
pub(crate) fn bytes_of(instance: &Instance, state_slots: usize, measured: bool) -> u64 {
    let parts = parts_of(instance, measured);
    if parts == WorldParts::default() {
        return 0;
    }
    let (world, motion) = (&instance.world, &instance.motion);
    let n = instance.model.model().graph.node_count();
    let held = if parts.grasps {
        let rods = instance.model.model().graph.rods.len();
        let spans = size_of::<args::RodSpan>() * rods;
        (state_slots + 1) * (size_of::<args::Hold>() * n + 4 * world.grasps.len() + spans)
    } else {
        0
    };
    let forces = if parts.forces {
        4 * (impulse_count(instance) + instance.frames * force_stride(instance))
    } else {
        0
    };
    let moving = 48 * motion.poses.len() + 4 * (motion.closed.len() + motion.rolls.len());
    (held + forces + moving) as u64
}

impl Worlds {
    /// Worlds of instances with `slots` of states each, keeping all or only the last.
    pub(crate) fn new(
        queue: &Queue,
        instances: &[Instance],
        measured: bool,
        slots: &[usize],
        keeps_all: bool,
    ) -> Result<Self, Error> {
        let stream = &queue.stream;
        let parts: Vec<WorldParts> = instances.iter().map(|i| parts_of(i, measured)).collect();
        let (mut hold_starts, mut phase_starts, mut span_starts) = (vec![0], vec![0], vec![0]);
        let (mut impulse_starts, mut force_starts) = (vec![0], vec![0]);
        let (mut boundaries, mut phases) = (BTreeSet::new(), Vec::new());
        for ((instance, parts), &slots) in instances.iter().zip(&parts).zip(slots) {
            let n = if parts.grasps { instance.model.model().graph.node_count() } else { 0 };
            let slots = hold_slots(slots, keeps_all);
            let g = instance.world.grasps.len();
            hold_starts.push(end_of(&hold_starts) + slots * n);
            phase_starts.push(end_of(&phase_starts) + slots * g);
            let rods = if parts.grasps { instance.model.model().graph.rods.len() } else { 0 };
            span_starts.push(end_of(&span_starts) + slots * rods);
            phases.extend(initial_phases(instance));
            phases.resize(end_of(&phase_starts), 0);
            let (impulses, forces) = if parts.forces {
                (impulse_count(instance), instance.frames * force_stride(instance))
            } else {
                (0, 0)
            };
            impulse_starts.push(end_of(&impulse_starts) + impulses);
            force_starts.push(end_of(&force_starts) + forces);
            // Where forces are measured, grasps change behind each frame.
            if parts.grasps && !parts.forces {
                boundaries.extend(changes(instance));
            }
        }
        let uploaded = Parts::new(stream, instances, &parts)?;
        let holds: Buffer<args::Hold> = Buffer::empty(stream, end_of(&hold_starts))?;
        // No grasp holds anything.
        holds.fill(0xff)?;
        for ((instance, &start), parts) in instances.iter().zip(&hold_starts).zip(&parts) {
            if parts.grasps && !instance.initial.grasping.holds.is_empty() {
                holds.write(start, &upload::initial_holds(instance))?;
            }
        }
        let mut this = Self {
            args: Vec::with_capacity(instances.len()),
            boundaries,
            uploaded,
            holds,
            phases: Buffer::of(stream, &phases)?,
            spans: Buffer::empty(stream, end_of(&span_starts))?,
            impulses: Buffer::zeros(stream, end_of(&impulse_starts))?,
            forces: Buffer::zeros(stream, end_of(&force_starts))?,
            hold_starts,
            phase_starts,
            span_starts,
            impulse_starts,
            force_starts,
            parts,
        };
        for (i, instance) in instances.iter().enumerate() {
            let args = this.make_args(i, instance, hold_slots(slots[i], keeps_all));
            this.args.push(args);
        }
        Ok(this)
    }

    fn make_args(&self, index: usize, instance: &Instance, slots: usize) -> WorldArgs {
        let (world, parts) = (&instance.world, self.parts[index]);
        if parts == WorldParts::default() {
            return WorldArgs::default();
        }
        let forces = if parts.forces {
            self.forces.at(self.force_starts[index])
        } else {
            Pointer::default()
        };
        let has_spans = self.span_starts[index + 1] > self.span_starts[index];
        WorldArgs {
            spans: if has_spans {
                self.spans.at(self.span_starts[index])
            } else {
                Pointer::default()
            },
            holds: self.holds.at(self.hold_starts[index]),
            phases: self.phases.at(self.phase_starts[index]),
            forces,
            body_count: world.bodies as u32,
            collider_count: world.colliders.len() as u32,
            grasp_count: world.grasps.len() as u32,
            slot_count: slots as u32,
            smoothing: world.smoothing_m,
            ..self.uploaded.args(index)
        }
    }

    /// The parts of its surroundings that an instance has.
    pub(crate) fn parts(&self, index: usize) -> WorldParts {
        self.parts[index]
    }

    /// Arguments of an instance's surroundings, without forces being measured.
    pub(crate) fn args(&self, index: usize) -> WorldArgs {
        self.args[index]
    }

    /// Lets an instance measure its forces.
    pub(crate) fn measure(&self, index: usize, args: &mut InstanceArgs) {
        if self.parts[index].forces {
            args.world.impulses = self.impulses.at(self.impulse_starts[index]);
        }
    }

    /// Boundary at which a launch from frame `first` has to end, at most `end`.
    pub(crate) fn end_of_launch(&self, first: usize, end: usize) -> usize {
        self.boundaries.range(first + 1..).next().map_or(end, |&b| b.min(end))
    }

    /// Addresses of the phases of an instance's grasps, shape [grasps], and of what they hold, shape
    /// [N], behind a frame that is kept; nothing if it has no grasps.
    pub(crate) fn grasping(
        &self,
        index: usize,
        frame: usize,
    ) -> Option<(Pointer<u32>, Pointer<args::Hold>)> {
        let args = &self.args[index];
        let slot = (frame + 1) % args.slot_count.max(1) as usize;
        let [phases, holds] = [&self.phase_starts, &self.hold_starts].map(|starts| {
            let stride = (starts[index + 1] - starts[index]) / args.slot_count.max(1) as usize;
            starts[index] + slot * stride
        });
        self.parts[index].grasps.then(|| (self.phases.at(phases), self.holds.at(holds)))
    }

    /// Forces on all instances, in the order of the device; waits for it.
    pub(crate) fn forces(&self, queue: &Queue) -> Result<Vec<f32>, Error> {
        queue.fetch(&self.forces)
    }

    /// Forces on an instance in its frames before `end`, from [`Self::forces`].
    pub(crate) fn forces_on(
        &self,
        index: usize,
        instance: &Instance,
        end: usize,
        all: &[f32],
    ) -> Forces {
        let stride = force_stride(instance);
        let count = end.min(instance.frames) * stride;
        let own = &all[self.force_starts[index]..][..count];
        let controls = instance.model.model().graph.control_count();
        let grasps = instance.world.grasps.len();
        let mut forces = Forces::default();
        for frame in own.chunks(stride) {
            let (by_controls, rest) = frame.split_at(6 * controls);
            let (by_grasps, rest) = rest.split_at(6 * grasps);
            let (by_ground, by_colliders) = rest.split_at(3);
            forces.controls.extend(by_controls.chunks_exact(6).map(|f| [f[0], f[1], f[2]]));
            forces.grasps.extend(by_grasps.as_chunks().0);
            forces.ground.push([by_ground[0], by_ground[1], by_ground[2]]);
            forces.colliders.extend(by_colliders.as_chunks().0);
        }
        forces
    }

    /// Opens and closes the grasps of instances at a boundary; frames from there to before `end`
    /// begin with what they hold then.
    pub(crate) fn change_grasps(
        &self,
        queue: &Queue,
        stream: &CudaStream,
        of: InstanceSpan,
        (boundary, end): (usize, usize),
    ) -> Result<(), Error> {
        let args =
            ChangeGraspsArgs { instances: of.address, boundary: boundary as u32, end: end as u32 };
        let launch = Launch::new(&queue.device, stream, [of.count as u32, 1, 1]);
        // SAFETY: instances with grasps have their holds, phases, states and motion.
        unsafe { kernels::change_grasps(&launch, &args) }
    }
}

/// Frames in front of which the grasps of an instance open or close, and the end of the last.
fn changes(instance: &Instance) -> impl Iterator<Item = usize> + use<'_> {
    let g = instance.world.grasps.len().max(1);
    let rows = instance.motion.closed.chunks(g);
    let pairs = rows.clone().zip(rows.skip(1)).enumerate();
    let changed = pairs.filter(|(_, (a, b))| a != b).map(|(f, _)| f + 1);
    [0, instance.frames].into_iter().chain(changed)
}

/// Phases of grasps, and their holds by node.
pub(crate) fn decode_grasping(phases: &[u32], holds: &[args::Hold]) -> Grasping {
    let held = holds.iter().enumerate().filter(|(_, h)| h.grasp >= 0);
    Grasping {
        phases: phases.iter().map(|&p| decode_phase(p)).collect(),
        holds: held
            .map(|(node, h)| Hold { node: node as u32, grasp: h.grasp as u32, place: h.place })
            .collect(),
    }
}

fn decode_phase(phase: u32) -> Phase {
    match phase {
        p if p == encode_phase(Phase::Closed) => Phase::Closed,
        p if p == encode_phase(Phase::Slipped) => Phase::Slipped,
        _ => Phase::Open,
    }
}

/// The control points of a grasp that holds as the twin does.
fn controls_of(region: &Region) -> Option<&[u32]> {
    match region {
        Region::Controls(controls) => Some(controls),
        _ => None,
    }
}
