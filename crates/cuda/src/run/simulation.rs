//! Instances under way on the device: their memory, their groups, and frames forward.

use std::{
    collections::{HashMap, HashSet},
    sync::Arc,
};

use bendtwin_core::{CancelToken, Point};
use bendtwin_engine::{
    Error,
    backend::{Divergence, Instance},
    constants::MAX_PARTNERS,
};
use cudarc::driver::CudaStream;
use rayon::prelude::*;

use crate::{
    device::{
        args::{FindPartnersArgs, InstanceArgs, Pointer, StateArgs},
        kernels,
        launch::Launch,
        memory::{Buffer, end_of},
        queue::Queue,
        specialization::{Specialization, WorldParts},
        throttle::LaunchThrottle,
    },
    plan::{
        choice::{LaunchPlan, Purpose, choose},
        layouts::Cut,
        resident::{Packed, has_contact, has_skin_contact, resident},
        tape::RolloutTapes,
    },
    run::{
        clearance::{ClearanceSize, Clearances, find_clearances},
        contact::{Contact, contact_nodes},
        group::{FrameRange, Group, InstanceSpan},
        start::{InitialStates, start},
        world::{self, Worlds},
    },
};

/// Frames whose states are kept.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum RetainedStates {
    /// All of them.
    All,
    /// The last one.
    Last,
}

/// Instances of a batch on the device.
pub(crate) struct Simulation<'a> {
    pub(crate) queue: &'a Queue,
    pub(crate) instances: &'a [Instance],
    /// States of each instance, shape [slots, 6, N].
    states: Buffer<f32>,
    state_starts: Vec<usize>,
    /// Twists of each instance's rods, shape [slots, R].
    twists: Buffer<f32>,
    twist_starts: Vec<usize>,
    retained: RetainedStates,
    controls: Buffer<Point>,
    control_starts: Vec<usize>,
    divergence: Buffer<u64>,
    contact: Contact,
    clearances: Clearances,
    pub(crate) worlds: Worlds,
    pub(super) initial: InitialStates,
}

/// Bytes of device memory that an instance takes while it is simulated; `measured` if its forces are
/// asked for.
pub(crate) fn bytes_of(instance: &Instance, retained: RetainedStates, measured: bool) -> u64 {
    let model = instance.model.model();
    let n = model.graph.node_count() as u64;
    let states = (24 * n + 4 * model.graph.rods.len() as u64) * slots(instance, retained) as u64;
    let contact = if has_contact(model) { n * (4 * MAX_PARTNERS as u64 + 56) } else { 0 };
    let world = world::bytes_of(instance, slots(instance, retained), measured);
    let clearances = ClearanceSize::of(instance).bytes(false);
    states + contact + clearances + 12 * instance.controls.len() as u64 + world
}

fn slots(instance: &Instance, retained: RetainedStates) -> usize {
    match retained {
        RetainedStates::All => instance.frames + 1,
        RetainedStates::Last => 2,
    }
}

impl<'a> Simulation<'a> {
    /// Puts checked instances onto the device, at their initial states; `measured` if their forces
    /// are asked for.
    pub(crate) fn new(
        queue: &'a Queue,
        instances: &'a [Instance],
        retained: RetainedStates,
        measured: bool,
    ) -> Result<Self, Error> {
        let stream = &queue.stream;
        let (mut state_starts, mut control_starts) = (vec![0], vec![0]);
        let mut twist_starts = vec![0];
        for instance in instances {
            let graph = &instance.model.model().graph;
            let (n, r) = (graph.node_count(), graph.rods.len());
            state_starts.push(end_of(&state_starts) + 6 * n * slots(instance, retained));
            twist_starts.push(end_of(&twist_starts) + r * slots(instance, retained));
            control_starts.push(end_of(&control_starts) + instance.controls.len());
        }
        let all: Vec<Point> = instances.iter().flat_map(|i| i.controls.iter()).copied().collect();
        let divergence = Buffer::empty(stream, instances.len())?;
        divergence.fill(0xff)?;
        let each_slots: Vec<usize> = instances.iter().map(|i| slots(i, retained)).collect();
        let keeps_all = retained == RetainedStates::All;
        let worlds = Worlds::new(queue, instances, measured, &each_slots, keeps_all)?;
        let this = Self {
            states: Buffer::empty(stream, end_of(&state_starts))?,
            twists: Buffer::empty(stream, end_of(&twist_starts))?,
            controls: Buffer::of(stream, &all)?,
            contact: Contact::new(queue, instances.iter().map(|i| contact_nodes(i.model.model())))?,
            clearances: Clearances::new(queue, instances.iter().map(ClearanceSize::of), false)?,
            queue,
            instances,
            state_starts,
            twist_starts,
            retained,
            control_starts,
            divergence,
            worlds,
            initial: InitialStates::new(stream, instances)?,
        };
        start(&this)?;
        Ok(this)
    }

    /// Address of an instance's states.
    pub(crate) fn states_of(&self, index: usize) -> Pointer<f32> {
        self.states.at(self.state_starts[index])
    }

    /// Address of an instance's twists.
    pub(super) fn twists_of(&self, index: usize) -> Pointer<f32> {
        self.twists.at(self.twist_starts[index])
    }

    /// Address of an instance's controls.
    pub(crate) fn controls_of(&self, index: usize) -> Pointer<Point> {
        self.controls.at(self.control_starts[index])
    }

    /// Slots of an instance's states.
    pub(crate) fn slots_of(&self, index: usize) -> usize {
        slots(&self.instances[index], self.retained)
    }

    /// The arguments of an instance, for these packed parameters.
    pub(crate) fn instance_args(
        &self,
        index: usize,
        packed: &Packed,
    ) -> Result<InstanceArgs, Error> {
        let instance = &self.instances[index];
        let model = instance.model.model();
        let resident = resident(&instance.model)?;
        let first_rod = 3 * (model.graph.springs.len() + model.graph.triplets.len());
        let mut args = packed.instance_args(model);
        args.parameters.rods = resident.params.at(first_rod);
        args.parameters.dashpot = resident.dashpot.unwrap_or_default();
        args.state = StateArgs {
            controls: self.controls_of(index),
            states: self.states_of(index),
            twists: self.twists_of(index),
            divergence: self.divergence.at(index),
            slot_count: self.slots_of(index) as u32,
            frame_count: instance.frames as u32,
            ..StateArgs::default()
        };
        args.contact.object_ids = resident.graph.object_ids.address();
        args.contact.rest = resident.graph.rest.address();
        if has_contact(model) {
            if model.params.contact.within_object {
                let neighbours = resident.graph.neighbours(&resident.device)?;
                args.contact.neighbour_starts = neighbours.starts.address();
                args.contact.neighbours = neighbours.nodes.address();
            }
            self.contact.place(index, &mut args);
        }
        if has_skin_contact(model) {
            let by_node = resident.skin.by_node(&resident.device, model.graph.node_count())?;
            args.clearance.skin = by_node.add_to(resident.skin.args());
            self.clearances.place(index, &mut args);
        }
        args.world = self.worlds.args(index);
        args.world.initial = self.initial.of(index);
        Ok(args)
    }

    /// Runs all frames, with all that happens in them onto tape if there is one.
    pub(crate) fn run(
        &self,
        tape: Option<&mut RolloutTapes>,
        cancel: &CancelToken,
    ) -> Result<(), Error> {
        let all: Vec<usize> = (0..self.instances.len()).collect();
        let purpose = if tape.is_some() { Purpose::Tape } else { Purpose::Forward };
        let mut groups = self.groups(&all, 0, purpose)?;
        if let Some(tape) = tape {
            for (index, args) in groups.iter_mut().flat_map(Group::members_mut) {
                tape.write(index, args);
            }
        }
        let control_impulses = self.measure(&mut groups)?;
        let longest = self.instances.iter().map(|i| i.frames).max().unwrap_or(0);
        let uploaded: Vec<Buffer<InstanceArgs>> = groups
            .iter()
            .map(|g| Buffer::of(&self.queue.stream, g.instances()))
            .collect::<Result<_, _>>()?;
        let frame_us: f64 = groups.iter().map(|g| self.frame_us(g)).sum();
        let frame_by_frame =
            |g: &Group| g.plan.specialization.contact || g.plan.specialization.skin_contact;
        let step = if groups.iter().any(frame_by_frame) {
            1
        } else {
            ((self.queue.stretch_us() / frame_us.max(1e-3)) as usize).clamp(1, longest.max(1))
        };
        let mut throttle = LaunchThrottle::default();
        let mut first = 0;
        while first < longest {
            if cancel.is_cancelled() {
                self.queue.synchronize()?;
                return Err(Error::Cancelled);
            }
            let end = self.worlds.end_of_launch(first, (first + step).min(longest));
            let range = FrameRange::frames(first, end);
            // Different graphs take different kernels, no single one of which fills the device:
            // they run concurrently.
            self.queue.launch_concurrently(groups.len(), |k, streams| {
                let (group, span) = (&groups[k], InstanceSpan::all(&uploaded[k]));
                let stream = streams.of(k, &group.plan.team);
                self.change_grasps(group, span, stream, (first, end))?;
                if group.plan.specialization.contact {
                    self.find_partners(stream, span, first as u32)?;
                }
                if group.plan.specialization.skin_contact {
                    find_clearances(self.queue, stream, span, first as u32)?;
                }
                group.advance(self.queue, stream, span, &range)
            })?;
            throttle.launched(self.queue, frame_us * (end - first) as f64)?;
            first = end;
        }
        for (group, uploaded) in groups.iter().zip(&uploaded) {
            let (span, stream) = (InstanceSpan::all(uploaded), &self.queue.stream);
            self.change_grasps(group, span, stream, (longest, longest))?;
        }
        drop(control_impulses);
        Ok(())
    }

    /// Opens and closes the grasps of a group in front of a launch.
    fn change_grasps(
        &self,
        group: &Group,
        span: InstanceSpan,
        stream: &CudaStream,
        (boundary, end): (usize, usize),
    ) -> Result<(), Error> {
        let has_grasps = group.plan.specialization.world.grasps;
        // Holds of frames are written for all of them together, launch by launch.
        if !has_grasps {
            return Ok(());
        }
        self.worlds.change_grasps(self.queue, stream, group.own(span), (boundary, end))
    }

    /// Lets the instances of groups measure their forces; what their control points exert goes into
    /// the memory that is returned.
    fn measure(&self, groups: &mut [Group]) -> Result<Vec<Buffer<f32>>, Error> {
        let mut all = Vec::new();
        for group in groups.iter_mut().filter(|g| g.plan.specialization.world.forces) {
            let blocks = group.plan.team.blocks as usize;
            let count = |args: &InstanceArgs| 6 * blocks * args.topology.control_count as usize;
            let mut starts = vec![0];
            for args in group.instances() {
                starts.push(end_of(&starts) + count(args));
            }
            let impulses = Buffer::zeros(&self.queue.stream, end_of(&starts))?;
            for (k, (index, args)) in group.members_mut().enumerate() {
                self.worlds.measure(index, args);
                args.world.control_impulses = impulses.at(starts[k]);
            }
            all.push(impulses);
        }
        Ok(all)
    }

    fn frame_us(&self, group: &Group) -> f64 {
        let model = |&i: &usize| self.instances[i].model.model();
        let substeps = group.members.iter().map(model).map(|m| m.timing.substeps).max();
        group.frame_us(substeps.unwrap_or(1))
    }

    /// Finds the contact candidates of a frame.
    pub(crate) fn find_partners(
        &self,
        stream: &CudaStream,
        of: InstanceSpan,
        frame: u32,
    ) -> Result<(), Error> {
        let args = FindPartnersArgs { instances: of.address, frame, pad: 0 };
        let launch = Launch::new(&self.queue.device, stream, [of.count as u32, 1, 1]);
        // SAFETY: instances with contact have its arrays; the kernel reads frames that exist.
        unsafe { kernels::find_partners(&launch, &args) }
    }

    /// Some instances in groups that one launch serves; an instance may have several. Groups'
    /// members are indices in `of`. `others` instances share the device with them.
    pub(crate) fn groups(
        &self,
        of: &[usize],
        others: usize,
        purpose: Purpose,
    ) -> Result<Vec<Group>, Error> {
        let device = &self.queue.device;
        let model = |m: usize| &self.instances[of[m]].model;
        // Where there are no nodes, nothing moves.
        let moves = |&m: &usize| model(m).model().graph.node_count() > 0;
        let members: Vec<usize> = (0..of.len()).filter(moves).collect();
        // The first member of each model and kind of surroundings, and how many it has.
        let key = |m: usize| {
            let resident = std::ptr::from_ref(resident(model(m))?) as usize;
            Ok::<_, Error>((resident, self.worlds.parts(of[m])))
        };
        let mut alike: HashMap<(usize, WorldParts), (usize, usize)> = HashMap::new();
        for &m in &members {
            alike.entry(key(m)?).or_insert((m, 0)).1 += 1;
        }
        let firsts: Vec<usize> = alike.values().map(|&(first, _)| first).collect();
        let plans = map_concurrently(self.queue, &firsts, |&m| {
            let (key, resident, model) = (key(m)?, resident(model(m))?, model(m).model());
            let (batch, alike) = (members.len() + others, alike[&key].1);
            let device = &device.capabilities;
            let plan = choose(device, &resident.shapes(), model, purpose, key.1, batch, alike)?;
            Ok((key, (plan, resident.packed(Cut::of(&plan.team))?)))
        })?;
        let known: HashMap<(usize, WorldParts), (LaunchPlan, Arc<Packed>)> =
            plans.into_iter().collect();
        let specializations: HashSet<Specialization> =
            known.values().map(|(plan, _)| plan.specialization).collect();
        let specializations: Vec<Specialization> = specializations.into_iter().collect();
        map_concurrently(self.queue, &specializations, |specialization| {
            device.function(specialization, purpose.kernel())
        })?;
        let mut groups: Vec<Group> = Vec::new();
        for &m in &members {
            let (plan, packed) = &known[&key(m)?];
            let args = self.instance_args(of[m], packed)?;
            // Instances that are simulated together share their model, and groups of them are full.
            let at = match groups.iter().position(|g| g.takes(plan, packed)) {
                Some(at) => at,
                None => {
                    groups.push(Group::new(*plan));
                    groups.len() - 1
                }
            };
            groups[at].add(m, args, plan, packed);
        }
        groups.iter_mut().try_for_each(|g| g.complete(self.queue))?;
        Ok(groups)
    }

    /// Frame and node of each divergence.
    pub(crate) fn divergences(&self) -> Result<Vec<Option<Divergence>>, Error> {
        let found = self.divergence.read()?;
        let decode = |key: u64| {
            let (frame, node) = ((key >> 32) as usize, (key & 0xffff_ffff) as usize);
            (key != u64::MAX).then_some(Divergence { frame, node })
        };
        Ok(found.into_iter().map(decode).collect())
    }
}

/// Makes something of each, on several threads if there are several: new graphs are cut and kernels
/// compiled. On an urgent queue on the caller's thread: the others may be busy with a fit.
fn map_concurrently<T: Sync, U: Send>(
    queue: &Queue,
    of: &[T],
    make: impl Fn(&T) -> Result<U, Error> + Sync + Send,
) -> Result<Vec<U>, Error> {
    match of {
        [] | [_] => of.iter().map(make).collect(),
        _ if queue.is_urgent => of.iter().map(make).collect(),
        several => several.par_iter().map(make).collect(),
    }
}
