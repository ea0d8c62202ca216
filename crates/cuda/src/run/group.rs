//! Instances that one launch serves: similar enough for one kernel, and the memory that their teams
//! share.

use std::sync::Arc;

use bendtwin_engine::Error;
use cudarc::driver::CudaStream;

use crate::{
    device::{
        args::{AdvanceFramesArgs, BackFrameArgs, InstanceArgs, Pointer, StateArgs},
        kernels,
        launch::Launch,
        memory::Buffer,
        queue::Queue,
        team::TeamShape,
    },
    plan::{
        choice::{LaunchPlan, Purpose},
        resident::Packed,
    },
};

/// Arguments of instances on the device, one after another.
#[derive(Clone, Copy, Debug)]
pub(crate) struct InstanceSpan {
    pub(crate) address: Pointer<InstanceArgs>,
    pub(crate) count: usize,
}

impl InstanceSpan {
    pub(crate) fn all(buffer: &Buffer<InstanceArgs>) -> Self {
        Self { address: buffer.address(), count: buffer.len() }
    }

    pub(crate) fn part(buffer: &Buffer<InstanceArgs>, first: usize, count: usize) -> Self {
        Self { address: buffer.at(first), count }
    }

    fn at(&self, index: usize) -> Pointer<InstanceArgs> {
        self.address.add(index)
    }
}

/// Frames that a launch runs; each instance takes as many of them as it has.
#[derive(Clone, Debug)]
pub(crate) struct FrameRange {
    first: u32,
    end: u32,
    /// Substeps that go onto tape; a frame ends with the last of them.
    taped: std::ops::Range<u32>,
    /// True if frames store the states that they end in.
    keep: bool,
}

impl FrameRange {
    /// Frames from `first` to before `end`, on tape where instances have one.
    pub(crate) fn frames(first: usize, end: usize) -> Self {
        Self { first: first as u32, end: end as u32, taped: 0..u32::MAX, keep: true }
    }

    /// A frame that has been run before, for these substeps on tape.
    pub(crate) fn again(taped: std::ops::Range<u32>) -> Self {
        Self { first: 0, end: 1, taped, keep: false }
    }
}

/// States that a grid's blocks exchange: x, y, z, vx and vy, vz.
type Exchange = (Buffer<[f32; 4]>, Buffer<[f32; 2]>);

/// Instances that one launch serves.
pub(crate) struct Group {
    pub(crate) plan: LaunchPlan,
    /// Index of each member as given to [`crate::run::simulation::Simulation::groups`]; instances
    /// that only fill up a team have none.
    pub(crate) members: Vec<usize>,
    instances: Vec<InstanceArgs>,
    packed: Vec<Arc<Packed>>,
    _spill: Option<Buffer<[f32; 4]>>,
    _exchange: Option<Exchange>,
    barriers: Option<Buffer<u32>>,
}

impl Group {
    pub(crate) fn new(plan: LaunchPlan) -> Self {
        Self {
            plan,
            members: Vec::new(),
            instances: Vec::new(),
            packed: Vec::new(),
            _spill: None,
            _exchange: None,
            barriers: None,
        }
    }

    /// True if an instance of another model fits in.
    pub(crate) fn takes(&self, plan: &LaunchPlan, packed: &Arc<Packed>) -> bool {
        self.plan.specialization == plan.specialization
            && (plan.team.instances == 1 || self.packed.iter().all(|p| Arc::ptr_eq(p, packed)))
    }

    pub(crate) fn add(
        &mut self,
        member: usize,
        args: InstanceArgs,
        plan: &LaunchPlan,
        packed: &Arc<Packed>,
    ) {
        self.plan.shared_bytes = self.plan.shared_bytes.max(plan.shared_bytes);
        self.plan.spill_stride = self.plan.spill_stride.max(plan.spill_stride);
        self.members.push(member);
        self.instances.push(args);
        if !self.packed.iter().any(|p| Arc::ptr_eq(p, packed)) {
            self.packed.push(packed.clone());
        }
    }

    /// Parameters of its instances, packed for this kernel.
    pub(crate) fn packed(&self) -> &[Arc<Packed>] {
        &self.packed
    }

    /// Fills the last team and gives the instances the memory that their teams share.
    pub(crate) fn complete(&mut self, queue: &Queue) -> Result<(), Error> {
        let together = self.plan.team.instances as usize;
        while let Some(&last) = self.instances.last()
            && !self.instances.len().is_multiple_of(together)
        {
            // It runs along and leaves no trace.
            self.instances
                .push(InstanceArgs { state: StateArgs { frame_count: 0, ..last.state }, ..last });
        }
        let (stream, blocks) = (&queue.stream, self.plan.team.blocks as usize);
        let stride = self.plan.spill_stride as usize;
        if stride > 0 {
            let spill = Buffer::empty(stream, self.instances.len() * blocks * stride)?;
            for (j, args) in self.instances.iter_mut().enumerate() {
                args.team.spill = spill.at(j * blocks * stride);
                args.team.spill_stride = stride as u32;
            }
            self._spill = Some(spill);
        }
        if self.plan.team.shape == TeamShape::Grid {
            let nodes = |j: &InstanceArgs| 2 * j.topology.node_count as usize;
            let total = self.instances.iter().map(nodes).sum();
            let exchange = (Buffer::empty(stream, total)?, Buffer::empty(stream, total)?);
            let barriers = Buffer::zeros(stream, self.instances.len())?;
            let mut at = 0;
            for (j, args) in self.instances.iter_mut().enumerate() {
                (args.team.exchange_x, args.team.exchange_v) =
                    (exchange.0.at(at), exchange.1.at(at));
                args.team.barrier = barriers.at(j);
                at += nodes(args);
            }
            (self._exchange, self.barriers) = (Some(exchange), Some(barriers));
        }
        Ok(())
    }

    /// Members with their arguments, to be changed before they are uploaded.
    pub(crate) fn members_mut(&mut self) -> impl Iterator<Item = (usize, &mut InstanceArgs)> {
        self.members.iter().copied().zip(&mut self.instances)
    }

    /// Arguments of its instances, as they go to the device.
    pub(crate) fn instances(&self) -> &[InstanceArgs] {
        &self.instances
    }

    /// Estimated time of a frame with this many substeps [us].
    pub(crate) fn frame_us(&self, substeps: u32) -> f64 {
        self.plan.substep_us * f64::from(substeps)
    }

    /// The instances of its members, without those that only fill up a team.
    pub(crate) fn own(&self, all: InstanceSpan) -> InstanceSpan {
        InstanceSpan { count: self.members.len(), ..all }
    }

    /// A range of frames forward.
    pub(crate) fn advance(
        &self,
        queue: &Queue,
        stream: &CudaStream,
        of: InstanceSpan,
        range: &FrameRange,
    ) -> Result<(), Error> {
        let FrameRange { first, end, taped, keep } = range;
        self.for_teams(queue, stream, Purpose::Forward, of, |launch, instances| {
            let args = AdvanceFramesArgs {
                instances,
                first: *first,
                end: *end,
                from: taped.start,
                to: taped.end,
                keep: u32::from(*keep),
                pad: 0,
            };
            // SAFETY: as `for_teams` says; frames and substeps are the instances'.
            unsafe { kernels::advance_frames(launch, &args) }
        })
    }

    /// Substeps of a frame backward.
    pub(crate) fn back(
        &self,
        queue: &Queue,
        stream: &CudaStream,
        of: InstanceSpan,
        substeps: &std::ops::Range<u32>,
    ) -> Result<(), Error> {
        self.for_teams(queue, stream, Purpose::Backward, of, |launch, instances| {
            let args = BackFrameArgs { instances, from: substeps.start, to: substeps.end };
            // SAFETY: as `for_teams` says; the substeps are on the instances' tapes.
            unsafe { kernels::back_frame(launch, &args) }
        })
    }

    /// Calls `run` with a launch for all teams of these instances, and the first of them; several
    /// times where not all teams can be resident together though their blocks wait for each other.
    /// The instances' arguments are complete for the specialization, and what they point to lives
    /// until the queue has been waited for.
    fn for_teams(
        &self,
        queue: &Queue,
        stream: &CudaStream,
        purpose: Purpose,
        of: InstanceSpan,
        run: impl Fn(&Launch<'_>, Pointer<InstanceArgs>) -> Result<(), Error>,
    ) -> Result<(), Error> {
        let LaunchPlan { team, specialization, shared_bytes, .. } = &self.plan;
        let instances = team.instances as usize;
        let teams = of.count / instances;
        let batch = match team.shape {
            TeamShape::Grid => {
                let function = queue.device.function(specialization, purpose.kernel())?;
                let processors = queue.device.capabilities.processors;
                (function.resident_teams(*shared_bytes, processors)? as usize).max(1)
            }
            _ => teams.max(1),
        };
        for begin in (0..teams).step_by(batch) {
            if let Some(barriers) = &self.barriers {
                barriers.clear()?;
            }
            let count = batch.min(teams - begin) as u32;
            let launch = Launch::new(&queue.device, stream, [count * team.blocks, 1, 1])
                .specialized(specialization, *shared_bytes);
            run(&launch, of.at(begin * instances))?;
        }
        Ok(())
    }
}
