//! Tapes: the records of substeps for the backward pass.

use std::sync::Arc;

use bendtwin_core::Graph;
use bendtwin_engine::{Error, backend::Instance};
use cudarc::driver::CudaStream;

use crate::device::{
    args::{InstanceArgs, Pointer},
    memory::Buffer,
};

/// Bytes of a node's substep on tape.
pub(crate) const NODE_BYTES: u64 = 36;
/// Bytes of a rod's.
pub(crate) const ROD_BYTES: u64 = 4;

/// States that substeps began in, and velocities before contact: an entry for each node of each
/// substep; and twists, an entry for each rod of each.
pub(crate) struct Tape {
    /// x, y, z, vx.
    x: Buffer<[f32; 4]>,
    /// vy, vz.
    v: Buffer<[f32; 2]>,
    before: Buffer<[f32; 3]>,
    twists: Buffer<f32>,
}

/// Entries of a tape: of nodes, and of rods.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Entries {
    pub(crate) nodes: usize,
    pub(crate) rods: usize,
}

impl Entries {
    /// Entries of `substeps` of a graph.
    pub(crate) fn of(graph: &Graph, substeps: usize) -> Self {
        Self { nodes: substeps * graph.node_count(), rods: substeps * graph.rods.len() }
    }

    fn after(self, before: Self) -> Self {
        Self { nodes: before.nodes + self.nodes, rods: before.rods + self.rods }
    }

    fn bytes(self) -> u64 {
        NODE_BYTES * self.nodes as u64 + ROD_BYTES * self.rods as u64
    }
}

/// Tapes of all frames of all instances, written as they ran.
pub(crate) struct RolloutTapes {
    tape: Tape,
    starts: Vec<Entries>,
    /// Slot of each node on tape, by instance.
    slots: Vec<Pointer<u32>>,
}

impl Tape {
    /// A tape with space for `entries`.
    pub(crate) fn new(stream: &Arc<CudaStream>, entries: Entries) -> Result<Self, Error> {
        Ok(Self {
            x: Buffer::empty(stream, entries.nodes)?,
            v: Buffer::empty(stream, entries.nodes)?,
            before: Buffer::empty(stream, entries.nodes)?,
            twists: Buffer::empty(stream, entries.rods)?,
        })
    }

    /// Lets an instance write or read from an entry on.
    pub(crate) fn place(&self, entry: Entries, args: &mut InstanceArgs) {
        args.tape.x = self.x.at(entry.nodes);
        args.tape.v = self.v.at(entry.nodes);
        args.tape.before = self.before.at(entry.nodes);
        args.tape.twists = self.twists.at(entry.rods);
    }
}

impl RolloutTapes {
    /// Bytes that it takes for these instances.
    pub(crate) fn bytes_of(instances: &[Instance]) -> u64 {
        instances.iter().map(|i| entries(i, i.frames).bytes()).sum()
    }

    pub(crate) fn new(stream: &Arc<CudaStream>, instances: &[Instance]) -> Result<Self, Error> {
        let (mut starts, mut end) = (Vec::with_capacity(instances.len()), Entries::default());
        for instance in instances {
            starts.push(end);
            end = entries(instance, instance.frames).after(end);
        }
        let slots = vec![Pointer::default(); instances.len()];
        Ok(Self { tape: Tape::new(stream, end)?, starts, slots })
    }

    /// Lets an instance write all its frames.
    pub(crate) fn write(&mut self, index: usize, args: &mut InstanceArgs) {
        self.tape.place(self.starts[index], args);
        self.slots[index] = args.tape.slot_of;
    }

    /// Lets an instance read from a frame on.
    pub(crate) fn read(
        &self,
        instances: &[Instance],
        index: usize,
        frame: usize,
        args: &mut InstanceArgs,
    ) {
        self.tape.place(entries(&instances[index], frame).after(self.starts[index]), args);
        args.tape.slot_of = self.slots[index];
    }
}

/// Entries of `frames`.
fn entries(instance: &Instance, frames: usize) -> Entries {
    let model = instance.model.model();
    Entries::of(&model.graph, frames * model.timing.substeps as usize)
}
