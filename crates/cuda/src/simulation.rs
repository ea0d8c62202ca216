//! Instances under way on the device: their jobs in groups that one launch serves, and frames forward.

use std::{collections::HashMap, sync::Arc};

use bendtwin_core::Point;
use bendtwin_engine::{
    Error, Model,
    backend::{CancelToken, Divergence, Instance},
    model::State,
};

use crate::{
    fault,
    job::Job,
    kernel::{Meeting, Source},
    launch::Arguments,
    memory::{Buffer, end_of},
    queue::Queue,
    resident::{Packed, has_contact, resident},
    team::{Fitted, Purpose, choose},
};

/// A node keeps its nearest so many contact candidates.
const MAX_PARTNERS: usize = 512;
/// How long a launch should take at most [us]: what others wait for, and a cancellation.
const LAUNCH_US: f64 = 15_000.0;

/// Which frames' states are kept.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Keep {
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
    keep: Keep,
    controls: Buffer<Point>,
    control_starts: Vec<usize>,
    divergence: Buffer<u64>,
    contact: Contact,
}

/// Where a grid's blocks meet: x, y, z, vx and vy, vz.
type Exchange = (Buffer<[f32; 4]>, Buffer<[f32; 2]>);

/// Jobs of instances that one launch serves.
pub(crate) struct Group {
    pub(crate) fitted: Fitted,
    /// Index in the simulation of each job.
    pub(crate) members: Vec<usize>,
    jobs: Vec<Job>,
    _packed: Vec<Arc<Packed>>,
    _spill: Option<Buffer<[f32; 4]>>,
    _exchange: Option<Exchange>,
    barriers: Option<Buffer<u32>>,
}

/// Contact's arrays of simulations that run side by side.
pub(crate) struct Contact {
    partners: Buffer<u32>,
    counts: Buffer<u32>,
    scratch: Buffer<u32>,
    x: Buffer<[f32; 4]>,
    v: Buffer<[f32; 4]>,
    /// First node of each in these.
    starts: Vec<usize>,
}

/// Bytes of device memory that an instance takes while it is simulated.
pub(crate) fn bytes_of(instance: &Instance, keep: Keep) -> u64 {
    let model = instance.model.model();
    let n = model.graph.node_count() as u64;
    let states = 24 * n * slots(instance, keep) as u64;
    let contact = if has_contact(model) { n * (4 * MAX_PARTNERS as u64 + 40) } else { 0 };
    states + contact + 12 * instance.controls.len() as u64
}

fn slots(instance: &Instance, keep: Keep) -> usize {
    match keep {
        Keep::All => instance.frames + 1,
        Keep::Last => 2,
    }
}

impl<'a> Simulation<'a> {
    /// Puts checked instances onto the device, at their initial states.
    pub(crate) fn new(
        queue: &'a Queue,
        instances: &'a [Instance],
        keep: Keep,
    ) -> Result<Self, Error> {
        let stream = &queue.stream;
        let (mut state_starts, mut control_starts) = (vec![0], vec![0]);
        for instance in instances {
            let n = instance.model.model().graph.node_count();
            state_starts.push(end_of(&state_starts) + 6 * n * slots(instance, keep));
            control_starts.push(end_of(&control_starts) + instance.controls.len());
        }
        let states = initial_states(queue, instances, &state_starts)?;
        let all: Vec<Point> = instances.iter().flat_map(|i| i.controls.iter()).copied().collect();
        let divergence = Buffer::empty(stream, instances.len())?;
        divergence.fill(0xff)?;
        Ok(Self {
            controls: Buffer::of(stream, &all)?,
            contact: Contact::new(queue, instances.iter().map(|i| contact_nodes(i.model.model())))?,
            queue,
            instances,
            states,
            state_starts,
            keep,
            control_starts,
            divergence,
        })
    }

    /// Address of an instance's states.
    pub(crate) fn states_of(&self, index: usize) -> u64 {
        self.states.at(self.state_starts[index])
    }

    /// Address of an instance's controls.
    pub(crate) fn controls_of(&self, index: usize) -> u64 {
        self.controls.at(self.control_starts[index])
    }

    /// Slots of an instance's states.
    pub(crate) fn slots_of(&self, index: usize) -> usize {
        slots(&self.instances[index], self.keep)
    }

    /// The job of an instance, for these packed parameters.
    pub(crate) fn job(&self, index: usize, packed: &Packed) -> Result<Job, Error> {
        let instance = &self.instances[index];
        let model = instance.model.model();
        let resident = resident(&instance.model)?;
        let mut job = Job {
            controls: self.controls_of(index),
            states: self.states_of(index),
            divergence: self.divergence.at(index),
            slots: self.slots_of(index) as u32,
            frames: instance.frames as u32,
            object_ids: resident.graph.object_ids.address(),
            dashpot: resident.dashpot.unwrap_or_default(),
            ..packed.job(model)
        };
        if has_contact(model) {
            if model.params.contact.within_object {
                let joined = resident.graph.joined(&resident.device)?;
                (job.joined_starts, job.joined) = (joined.starts.address(), joined.nodes.address());
            }
            self.contact.place(index, &mut job);
        }
        Ok(job)
    }

    /// Runs all frames.
    pub(crate) fn run(&self, cancel: &CancelToken) -> Result<(), Error> {
        let all: Vec<usize> = (0..self.instances.len()).collect();
        let groups = self.groups(&all, Purpose::Forward)?;
        let longest = self.instances.iter().map(|i| i.frames).max().unwrap_or(0);
        let jobs: Vec<Buffer<Job>> = groups
            .iter()
            .map(|g| Buffer::of(&self.queue.stream, &g.jobs))
            .collect::<Result<_, _>>()?;
        let frame_us: f64 = groups.iter().map(|g| self.frame_us(g)).sum();
        let step = if groups.iter().any(|g| g.fitted.variant.contact) {
            1
        } else {
            ((LAUNCH_US / frame_us.max(1e-3)) as usize).clamp(1, longest.max(1))
        };
        let mut before = None;
        for first in (0..longest).step_by(step) {
            if cancel.is_cancelled() {
                self.queue.synchronize()?;
                return Err(Error::Cancelled);
            }
            for (group, jobs) in groups.iter().zip(&jobs) {
                if group.fitted.variant.contact {
                    self.find_partners(jobs, first as u32)?;
                }
                group.advance(self.queue, jobs, first as u32, (first + step) as u32, 0, 0)?;
            }
            // One launch ahead of the device, not more: others have their turn, and cancellations.
            let now = self.queue.mark()?;
            if let Some(before) = before.replace(now) {
                cudarc::driver::CudaEvent::synchronize(&before)
                    .map_err(|e| fault("the device's work", e))?;
            }
        }
        Ok(())
    }

    fn frame_us(&self, group: &Group) -> f64 {
        let model = |&i: &usize| self.instances[i].model.model();
        let substeps = group.members.iter().map(model).map(|m| m.timing.substeps).max();
        group.fitted.substep_us * f64::from(substeps.unwrap_or(1))
    }

    /// Finds the contact candidates of a frame.
    pub(crate) fn find_partners(&self, jobs: &Buffer<Job>, frame: u32) -> Result<(), Error> {
        let arguments = Arguments::default().with(jobs.address()).with(frame);
        let grid = (jobs.len() as u32, 1, 1);
        // SAFETY: jobs with contact have its arrays; the kernel looks at frames that exist.
        unsafe { self.queue.launch(Source::Partners, "find_partners", grid, &arguments) }
    }

    /// Jobs of some instances, in groups that one launch serves.
    pub(crate) fn groups(&self, members: &[usize], purpose: Purpose) -> Result<Vec<Group>, Error> {
        let device = &self.queue.device;
        let of = |i: usize| resident(&self.instances[i].model);
        // Where there are no nodes, nothing moves.
        let has_nodes = |i: &&usize| self.instances[**i].model.model().graph.node_count() > 0;
        let members: Vec<usize> = members.iter().filter(has_nodes).copied().collect();
        let mut alike: HashMap<usize, usize> = HashMap::new();
        for &i in &members {
            *alike.entry(std::ptr::from_ref(of(i)?) as usize).or_default() += 1;
        }
        let mut fitted: HashMap<usize, Fitted> = HashMap::new();
        let mut groups: Vec<Group> = Vec::new();
        for &i in &members {
            let resident = of(i)?;
            let key = std::ptr::from_ref(resident) as usize;
            let model = self.instances[i].model.model();
            let fit = match fitted.get(&key) {
                Some(fit) => *fit,
                None => {
                    let (batch, alike) = (members.len(), alike[&key]);
                    let fit = choose(&device.ability, resident, model, purpose, batch, alike)?;
                    *fitted.entry(key).or_insert(fit)
                }
            };
            let packed = resident.packed(fit.team.cut())?;
            let job = self.job(i, &packed)?;
            // Instances that are simulated together share their model, and groups of them are full.
            let group = groups.iter_mut().find(|g| g.takes(&fit, &packed));
            let group = match group {
                Some(group) => group,
                None => {
                    groups.push(Group::new(fit));
                    let at = groups.len() - 1;
                    &mut groups[at]
                }
            };
            group.fitted.shared_bytes = group.fitted.shared_bytes.max(fit.shared_bytes);
            group.fitted.spill_stride = group.fitted.spill_stride.max(fit.spill_stride);
            group.members.push(i);
            group.jobs.push(job);
            if !group._packed.iter().any(|p| Arc::ptr_eq(p, &packed)) {
                group._packed.push(packed);
            }
        }
        groups.iter_mut().try_for_each(|g| g.complete(self.queue))?;
        Ok(groups)
    }

    /// Where instances diverged.
    pub(crate) fn divergences(&self) -> Result<Vec<Option<Divergence>>, Error> {
        let found = self.divergence.read()?;
        let decode = |key: u64| {
            let (frame, node) = ((key >> 32) as usize, (key & 0xffff_ffff) as usize);
            (key != u64::MAX).then_some(Divergence { frame, node })
        };
        Ok(found.into_iter().map(decode).collect())
    }

    /// State of an instance at the end of a frame; waits for the device.
    pub(crate) fn state(&self, index: usize, frame: usize) -> Result<State, Error> {
        let n = self.instances[index].model.model().graph.node_count();
        let slot = frame % self.slots_of(index);
        let planes = self.states.read_from(self.state_starts[index] + slot * 6 * n, 6 * n)?;
        let point = |first: usize, i: usize| {
            [planes[first * n + i], planes[(first + 1) * n + i], planes[(first + 2) * n + i]]
        };
        Ok(State {
            positions: (0..n).map(|i| point(0, i)).collect(),
            velocities: (0..n).map(|i| point(3, i)).collect(),
        })
    }
}

/// Room for the states of all instances, the initial ones in place.
fn initial_states(
    queue: &Queue,
    instances: &[Instance],
    starts: &[usize],
) -> Result<Buffer<f32>, Error> {
    let stream = &queue.stream;
    let states = Buffer::empty(stream, end_of(starts))?;
    let initial: Vec<Vec<f32>> = instances.iter().map(planes).collect();
    // One copy to the device, and from there to where each belongs.
    let together = Buffer::of(stream, &initial.concat())?;
    let mut from = 0;
    for (planes, &start) in initial.iter().zip(starts) {
        states.copy_from(start, &together, from, planes.len())?;
        from += planes.len();
    }
    Ok(states)
}

/// An instance's initial state as planes x, y, z, vx, vy, vz, pinned nodes on their control points.
fn planes(instance: &Instance) -> Vec<f32> {
    let model = instance.model.model();
    let (n, c) = (model.graph.node_count(), model.graph.control_count());
    let mut planes = vec![0.0; 6 * n];
    let mut put = |i: usize, x: Point, v: Point| {
        for k in 0..3 {
            planes[k * n + i] = x[k];
            planes[(3 + k) * n + i] = v[k];
        }
    };
    let state = &instance.initial;
    for (i, (&x, &v)) in state.positions.iter().zip(&state.velocities).enumerate() {
        put(i, x, v);
    }
    let moves = model.control_velocity == bendtwin_core::environment::ControlVelocity::True;
    let rate = (1.0 / model.timing.frame_s()) as f32;
    let next = if instance.frames > 0 { c } else { 0 };
    for pin in &model.graph.pins {
        let control = pin.control as usize;
        let (from, to) = (instance.controls[control], instance.controls[next + control]);
        let x = std::array::from_fn(|k| from[k] + pin.offset_m[k]);
        let v = std::array::from_fn(|k| if moves { (to[k] - from[k]) * rate } else { 0.0 });
        put(pin.node as usize, x, v);
    }
    planes
}

impl Group {
    fn new(fitted: Fitted) -> Self {
        Self {
            fitted,
            members: Vec::new(),
            jobs: Vec::new(),
            _packed: Vec::new(),
            _spill: None,
            _exchange: None,
            barriers: None,
        }
    }

    fn takes(&self, fit: &Fitted, packed: &Arc<Packed>) -> bool {
        self.fitted.variant == fit.variant
            && (fit.team.instances == 1 || self._packed.iter().all(|p| Arc::ptr_eq(p, packed)))
    }

    /// Fills the last team and gives the jobs what their teams share.
    fn complete(&mut self, queue: &Queue) -> Result<(), Error> {
        let instances = self.fitted.team.instances as usize;
        while let Some(&job) = self.jobs.last()
            && !self.jobs.len().is_multiple_of(instances)
        {
            // It runs along and leaves no trace.
            self.jobs.push(Job { frames: 0, ..job });
        }
        let (stream, blocks) = (&queue.stream, self.fitted.team.blocks as usize);
        let stride = self.fitted.spill_stride as usize;
        if stride > 0 {
            let spill = Buffer::empty(stream, self.jobs.len() * blocks * stride)?;
            for (j, job) in self.jobs.iter_mut().enumerate() {
                job.spill = spill.at(j * blocks * stride);
                job.spill_stride = stride as u32;
            }
            self._spill = Some(spill);
        }
        if self.fitted.team.meeting == Meeting::Grid {
            let nodes = |j: &Job| 2 * j.topology.node_count as usize;
            let total = self.jobs.iter().map(nodes).sum();
            let exchange = (Buffer::empty(stream, total)?, Buffer::empty(stream, total)?);
            let barriers = Buffer::zeros(stream, self.jobs.len())?;
            let mut at = 0;
            for (j, job) in self.jobs.iter_mut().enumerate() {
                (job.exchange_x, job.exchange_v) = (exchange.0.at(at), exchange.1.at(at));
                job.barrier = barriers.at(j);
                at += nodes(job);
            }
            (self._exchange, self.barriers) = (Some(exchange), Some(barriers));
        }
        Ok(())
    }

    /// The jobs, to be changed before they are uploaded.
    pub(crate) fn jobs_mut(&mut self) -> &mut [Job] {
        &mut self.jobs
    }

    /// The jobs as they go to the device.
    pub(crate) fn jobs(&self) -> &[Job] {
        &self.jobs
    }

    /// Frames `first..end`; with a tape, one frame as far as substep `to`, on tape from `from` on.
    pub(crate) fn advance(
        &self,
        queue: &Queue,
        jobs: &Buffer<Job>,
        first: u32,
        end: u32,
        from: u32,
        to: u32,
    ) -> Result<(), Error> {
        let arguments =
            |jobs: u64| Arguments::default().with(jobs).with(first).with(end).with(from).with(to);
        self.launch(queue, "advance_frames", jobs, arguments)
    }

    /// Substeps `from..to` of a frame backward.
    pub(crate) fn back(
        &self,
        queue: &Queue,
        jobs: &Buffer<Job>,
        from: u32,
        to: u32,
    ) -> Result<(), Error> {
        self.launch(queue, "back_frame", jobs, |jobs| {
            Arguments::default().with(jobs).with(from).with(to)
        })
    }

    fn launch(
        &self,
        queue: &Queue,
        name: &'static str,
        jobs: &Buffer<Job>,
        arguments: impl Fn(u64) -> Arguments,
    ) -> Result<(), Error> {
        let Fitted { team, variant, shared_bytes, .. } = &self.fitted;
        let function = queue.device.function(variant, name)?;
        let instances = team.instances as usize;
        let teams = jobs.len() / instances;
        // The blocks of a grid wait for each other: all must be running.
        let at_once = match team.meeting {
            Meeting::Grid => {
                let processors = queue.device.ability.processors;
                (function.resident_teams(*shared_bytes, processors)? as usize).max(1)
            }
            _ => teams.max(1),
        };
        for begin in (0..teams).step_by(at_once) {
            if let Some(barriers) = &self.barriers {
                barriers.clear()?;
            }
            let count = at_once.min(teams - begin) as u32;
            let grid = (count * team.blocks, 1, 1);
            // SAFETY: the jobs are complete for this variant, their memory lives until the queue has
            // been waited for, and frames and substeps are theirs.
            unsafe {
                let arguments = arguments(jobs.at(begin * instances));
                function.launch(&queue.stream, grid, *shared_bytes, &arguments)?;
            }
        }
        Ok(())
    }
}

/// Nodes that contact's arrays need for a model.
pub(crate) fn contact_nodes(model: &Model) -> usize {
    if has_contact(model) { model.graph.node_count() } else { 0 }
}

impl Contact {
    /// For simulations with contact of so many nodes each.
    pub(crate) fn new(queue: &Queue, nodes: impl Iterator<Item = usize>) -> Result<Self, Error> {
        let mut starts = vec![0];
        for nodes in nodes {
            starts.push(end_of(&starts) + nodes);
        }
        let (n, stream) = (end_of(&starts), &queue.stream);
        Ok(Self {
            partners: Buffer::empty(stream, n * MAX_PARTNERS)?,
            counts: Buffer::empty(stream, n)?,
            scratch: Buffer::empty(stream, n)?,
            x: Buffer::empty(stream, n)?,
            v: Buffer::empty(stream, n)?,
            starts,
        })
    }

    /// Gives a job the arrays of one of the simulations.
    pub(crate) fn place(&self, index: usize, job: &mut Job) {
        let at = self.starts[index];
        job.partners = self.partners.at(at * MAX_PARTNERS);
        job.partner_counts = self.counts.at(at);
        job.partner_scratch = self.scratch.at(at);
        job.contact_x = self.x.at(at);
        job.contact_v = self.v.at(at);
        job.max_partners = MAX_PARTNERS as u32;
    }
}
