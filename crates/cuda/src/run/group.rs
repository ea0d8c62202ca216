//! Jobs that one launch serves: alike enough for one kernel, and what their teams share.

use std::sync::Arc;

use bendtwin_engine::Error;
use cudarc::driver::CudaStream;

use crate::{
    device::{
        job::{Address, Job},
        launch::Arguments,
        memory::Buffer,
        queue::Queue,
        team::Meeting,
    },
    plan::{
        choice::{Fitted, Purpose},
        resident::Packed,
    },
};

/// Jobs on the device, one after the other.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Jobs {
    pub(crate) address: Address,
    pub(crate) count: usize,
}

impl Jobs {
    pub(crate) fn all(buffer: &Buffer<Job>) -> Self {
        Self { address: buffer.address(), count: buffer.len() }
    }

    pub(crate) fn part(buffer: &Buffer<Job>, first: usize, count: usize) -> Self {
        Self { address: buffer.at(first), count }
    }

    fn at(&self, index: usize) -> Address {
        self.address + (index * size_of::<Job>()) as u64
    }
}

/// What a launch runs of its jobs, which take as many frames of it as they have.
#[derive(Clone, Debug)]
pub(crate) struct Stretch {
    first: u32,
    end: u32,
    /// Substeps that go onto tape; a frame ends with the last of them.
    taped: std::ops::Range<u32>,
    /// Whether frames leave the states that they end in.
    keep: bool,
}

impl Stretch {
    /// Frames from `first` to before `end`, on tape where jobs have one.
    pub(crate) fn frames(first: usize, end: usize) -> Self {
        Self { first: first as u32, end: end as u32, taped: 0..u32::MAX, keep: true }
    }

    /// A frame that has been run before, for these substeps on tape.
    pub(crate) fn again(taped: std::ops::Range<u32>) -> Self {
        Self { first: 0, end: 1, taped, keep: false }
    }
}

/// Where a grid's blocks meet: x, y, z, vx and vy, vz.
type Exchange = (Buffer<[f32; 4]>, Buffer<[f32; 2]>);

/// Jobs of instances that one launch serves.
pub(crate) struct Group {
    pub(crate) fitted: Fitted,
    /// Whose each job is, by the index that [`crate::run::simulation::Simulation::groups`] was given; jobs that only
    /// fill up a team are nobody's.
    pub(crate) members: Vec<usize>,
    jobs: Vec<Job>,
    packed: Vec<Arc<Packed>>,
    _spill: Option<Buffer<[f32; 4]>>,
    _exchange: Option<Exchange>,
    barriers: Option<Buffer<u32>>,
}

impl Group {
    pub(crate) fn new(fitted: Fitted) -> Self {
        Self {
            fitted,
            members: Vec::new(),
            jobs: Vec::new(),
            packed: Vec::new(),
            _spill: None,
            _exchange: None,
            barriers: None,
        }
    }

    /// Whether a job of another model fits in.
    pub(crate) fn takes(&self, fit: &Fitted, packed: &Arc<Packed>) -> bool {
        self.fitted.variant == fit.variant
            && (fit.team.instances == 1 || self.packed.iter().all(|p| Arc::ptr_eq(p, packed)))
    }

    pub(crate) fn add(&mut self, member: usize, job: Job, fit: &Fitted, packed: &Arc<Packed>) {
        self.fitted.shared_bytes = self.fitted.shared_bytes.max(fit.shared_bytes);
        self.fitted.spill_stride = self.fitted.spill_stride.max(fit.spill_stride);
        self.members.push(member);
        self.jobs.push(job);
        if !self.packed.iter().any(|p| Arc::ptr_eq(p, packed)) {
            self.packed.push(packed.clone());
        }
    }

    /// The parameters of its jobs, as this kernel wants them.
    pub(crate) fn packed(&self) -> &[Arc<Packed>] {
        &self.packed
    }

    /// Fills the last team and gives the jobs what their teams share.
    pub(crate) fn complete(&mut self, queue: &Queue) -> Result<(), Error> {
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

    /// Members with their jobs, to be changed before they are uploaded.
    pub(crate) fn members_mut(&mut self) -> impl Iterator<Item = (usize, &mut Job)> {
        self.members.iter().copied().zip(&mut self.jobs)
    }

    /// The jobs as they go to the device.
    pub(crate) fn jobs(&self) -> &[Job] {
        &self.jobs
    }

    /// A stretch forward.
    pub(crate) fn advance(
        &self,
        queue: &Queue,
        stream: &CudaStream,
        jobs: Jobs,
        stretch: &Stretch,
    ) -> Result<(), Error> {
        let Stretch { first, end, taped, keep } = stretch;
        self.launch(queue, stream, Purpose::Forward, jobs, |jobs| {
            let substeps = Arguments::default().with(jobs).with(*first).with(*end);
            substeps.with(taped.start).with(taped.end).with(u32::from(*keep))
        })
    }

    /// Substeps `from..to` of a frame backward.
    pub(crate) fn back(&self, queue: &Queue, jobs: Jobs, from: u32, to: u32) -> Result<(), Error> {
        self.launch(queue, &queue.stream, Purpose::Backward, jobs, |jobs| {
            Arguments::default().with(jobs).with(from).with(to)
        })
    }

    fn launch(
        &self,
        queue: &Queue,
        stream: &CudaStream,
        purpose: Purpose,
        jobs: Jobs,
        arguments: impl Fn(Address) -> Arguments,
    ) -> Result<(), Error> {
        let Fitted { team, variant, shared_bytes, .. } = &self.fitted;
        let function = queue.device.function(variant, purpose.kernel())?;
        let instances = team.instances as usize;
        let teams = jobs.count / instances;
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
                function.launch(stream, grid, *shared_bytes, &arguments)?;
            }
        }
        Ok(())
    }
}
