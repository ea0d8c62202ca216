//! What substeps leave behind for the way back.

use std::sync::Arc;

use bendtwin_engine::{Error, backend::Instance};
use cudarc::driver::CudaStream;

use crate::{
    job::{Address, Job},
    memory::{Buffer, end_of},
};

/// Bytes of a node's substep on tape.
pub(crate) const NODE_BYTES: u64 = 36;

/// States that substeps began in, and velocities before contact: an entry for each node of each substep.
pub(crate) struct Tape {
    /// x, y, z, vx.
    x: Buffer<[f32; 4]>,
    /// vy, vz.
    v: Buffer<[f32; 2]>,
    before: Buffer<[f32; 3]>,
}

/// Tapes of all frames of all instances, written as they ran.
pub(crate) struct Kept {
    tape: Tape,
    starts: Vec<usize>,
    /// By instance, where each node is on tape.
    slots: Vec<Address>,
}

impl Tape {
    /// With room for so many entries.
    pub(crate) fn new(stream: &Arc<CudaStream>, entries: usize) -> Result<Self, Error> {
        Ok(Self {
            x: Buffer::empty(stream, entries)?,
            v: Buffer::empty(stream, entries)?,
            before: Buffer::empty(stream, entries)?,
        })
    }

    /// Lets a job write or read from an entry on.
    pub(crate) fn place(&self, entry: usize, job: &mut Job) {
        job.tape_x = self.x.at(entry);
        job.tape_v = self.v.at(entry);
        job.tape_b = self.before.at(entry);
    }
}

impl Kept {
    /// Bytes that it takes for these instances.
    pub(crate) fn bytes_of(instances: &[Instance]) -> u64 {
        instances.iter().map(|i| NODE_BYTES * entries(i, i.frames) as u64).sum()
    }

    pub(crate) fn new(stream: &Arc<CudaStream>, instances: &[Instance]) -> Result<Self, Error> {
        let mut starts = vec![0];
        for instance in instances {
            starts.push(end_of(&starts) + entries(instance, instance.frames));
        }
        let slots = vec![0; instances.len()];
        Ok(Self { tape: Tape::new(stream, end_of(&starts))?, starts, slots })
    }

    /// Lets the job of an instance write all its frames.
    pub(crate) fn write(&mut self, index: usize, job: &mut Job) {
        self.tape.place(self.starts[index], job);
        self.slots[index] = job.tape_slots;
    }

    /// Lets a job of an instance read from a frame on.
    pub(crate) fn read(&self, instances: &[Instance], index: usize, frame: usize, job: &mut Job) {
        self.tape.place(self.starts[index] + entries(&instances[index], frame), job);
        job.tape_slots = self.slots[index];
    }
}

/// Entries of so many frames.
fn entries(instance: &Instance, frames: usize) -> usize {
    let model = instance.model.model();
    frames * model.timing.substeps as usize * model.graph.node_count()
}
