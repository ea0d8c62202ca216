//! Sizes of the backward pass: windows that go backward together, frames of each on tape at a time,
//! and the arrays for them.

use std::ops::Range;

use bendtwin_engine::Error;

use super::{Backward, motion};
use crate::{
    device::{args::InstanceArgs, launch::MOST_BLOCKS, memory::Buffer, specialization::WorldParts},
    plan::{
        resident::LAWS,
        tape::{self, Entries, Tape},
    },
    run::{
        clearance::{ClearanceSize, Clearances},
        contact::{Contact, contact_nodes},
    },
};

/// Bytes that contact takes a node.
const CONTACT_BYTES: u64 = 2_088;
/// Frames that go onto tape together, a multiprocessor: more would not be quicker.
const FRAMES_A_PROCESSOR: usize = 2;
/// Most instances whose arguments are made ready together. They stand in the host's memory too,
/// where a small twin's would take far more than its frames on the device.
const MAX_INSTANCE_ARGS: usize = 1 << 16;

/// Arrays of windows that go backward together.
pub(super) struct WindowArrays {
    /// Number of windows.
    pub(super) windows: usize,
    /// Frames of each that are made ready at a time; they are on tape together.
    pub(super) frames: usize,
    /// Substeps of a frame that are on tape at a time: all of them, unless not even one frame fits.
    segment: usize,
    /// Substeps of a frame.
    pub(super) substeps: usize,
    pub(super) nodes: usize,
    pub(super) rods: usize,
    pub(super) bar_x: Buffer<[f32; 4]>,
    pub(super) bar_v: Buffer<[f32; 4]>,
    pub(super) twist_bars: Buffer<f32>,
    /// `None` if the forward pass wrote all tapes.
    tape: Option<Tape>,
    contact: Option<Contact>,
    clearances: Option<Clearances>,
}

/// Bytes of a window.
struct Bytes {
    /// Bytes independent of the frames on tape.
    fixed: u64,
    /// Bytes of each frame on tape.
    frame: u64,
    /// Bytes of each substep of it.
    substep: u64,
}

/// Sizes of the part of a backward pass that is on the device at a time.
pub(super) struct Sizes {
    /// Windows.
    pub(super) windows: usize,
    /// Frames of each that are made ready.
    frames: usize,
    /// Substeps of a frame that are on tape.
    segment: usize,
}

impl Sizes {
    /// Sizes for the windows of a graph in `room` bytes.
    pub(super) fn new(backward: &Backward<'_>, room: u64) -> Self {
        let (all, deepest) = backward.shape();
        let (simulation, instance) = (backward.forward.simulation, backward.members[0]);
        let substeps = simulation.instances[instance].model.model().timing.substeps as usize;
        let (most, deepest) = (all.clamp(1, MOST_BLOCKS), deepest.max(1));
        let bytes = backward.bytes(instance);
        let fit = |room: u64, each: u64| (room / each.max(1)) as usize;
        if backward.forward.tapes.is_some() {
            let windows = fit(room, bytes.fixed).clamp(1, most);
            let frames = deepest.min(MAX_INSTANCE_ARGS / windows).max(1);
            return Self { windows, frames, segment: substeps };
        }
        let windows = fit(room, bytes.fixed + bytes.frame).clamp(1, most);
        let left = room.saturating_sub(windows as u64 * bytes.fixed);
        let processors = simulation.queue.device.capabilities.processors as usize;
        let useful = (FRAMES_A_PROCESSOR * processors / windows).max(1);
        let frames = fit(left, windows as u64 * bytes.frame).clamp(1, deepest.min(useful));
        let longest = fit(left, bytes.substep).clamp(1, substeps.max(1));
        // Segments of equal length.
        let segment = substeps.div_ceil(substeps.div_ceil(longest).max(1));
        Self { windows, frames, segment }
    }
}

impl WindowArrays {
    /// Arrays of these sizes for windows of a graph.
    pub(super) fn new(backward: &Backward<'_>, sizes: &Sizes) -> Result<Self, Error> {
        let (simulation, instance) = (backward.forward.simulation, backward.members[0]);
        let stream = &simulation.queue.stream;
        let model = simulation.instances[instance].model.model();
        let (nodes, substeps) = (model.graph.node_count(), model.timing.substeps as usize);
        let rods = model.graph.rods.len();
        let Sizes { windows: count, frames, segment } = *sizes;
        let has_tapes = backward.forward.tapes.is_some();
        // If the forward pass has tapes, the windows need none here, and one frame's candidates
        // each.
        let (on_tape, contacts) =
            if has_tapes { (0, count) } else { (count * frames, count * frames) };
        let contact = contact_nodes(model);
        let clearances = ClearanceSize::of(&simulation.instances[instance]);
        Ok(Self {
            windows: count,
            frames,
            segment,
            substeps,
            nodes,
            rods,
            bar_x: Buffer::empty(stream, count * nodes)?,
            bar_v: Buffer::empty(stream, count * nodes)?,
            twist_bars: Buffer::empty(stream, count * rods)?,
            tape: match on_tape {
                0 => None,
                frames => Some(Tape::new(stream, Entries::of(&model.graph, frames * segment))?),
            },
            contact: match contact {
                0 => None,
                nodes => {
                    let each = std::iter::repeat_n(nodes, contacts);
                    Some(Contact::new(simulation.queue, each)?)
                }
            },
            clearances: match clearances == ClearanceSize::default() {
                true => None,
                false => {
                    let each = std::iter::repeat_n(clearances, contacts);
                    Some(Clearances::new(simulation.queue, each, true)?)
                }
            },
        })
    }

    /// The parts of a frame that go onto tape one after another: one, unless not even a frame fits.
    pub(super) fn segments(&self) -> impl DoubleEndedIterator<Item = Range<u32>> + use<> {
        let (segment, substeps) = (self.segment.max(1), self.substeps);
        let part = move |s: usize| (s * segment) as u32..((s + 1) * segment).min(substeps) as u32;
        (0..substeps.div_ceil(segment)).map(part)
    }

    pub(super) fn last_segment(&self) -> Range<u32> {
        self.segments().next_back().unwrap_or(0..0)
    }

    /// Gives an instance the arrays of a frame of a window on tape, counted from the first that is.
    pub(super) fn place(&self, window: usize, frame: usize, args: &mut InstanceArgs) {
        let slot = window * self.frames + frame;
        if let Some(tape) = &self.tape {
            let before = slot * self.segment;
            let entries = Entries { nodes: before * self.nodes, rods: before * self.rods };
            tape.place(entries, args);
        }
        if let Some(contact) = &self.contact {
            contact.place(if self.tape.is_some() { slot } else { window }, args);
        }
        if let Some(clearances) = &self.clearances {
            clearances.place(if self.tape.is_some() { slot } else { window }, args);
        }
    }
}

impl Backward<'_> {
    fn bytes(&self, instance: usize) -> Bytes {
        let simulation = self.forward.simulation;
        let model = simulation.instances[instance].model.model();
        let graph = &model.graph;
        let (n, e, t, r) =
            (graph.node_count(), graph.springs.len(), graph.triplets.len(), graph.rods.len());
        let blocks = simulation.queue.device.capabilities.processors as usize;
        let paths = if self.request.controls {
            blocks * graph.control_count() + graph.pins.len()
        } else {
            0
        };
        // A spring has three sums, in rows that are not full.
        let sums = 5 * e + 3 * (t + r) + r + LAWS * blocks;
        let bodies = simulation.instances[instance].world.bodies;
        let world = match simulation.worlds.parts(instance) == WorldParts::default() {
            true => 0,
            false => motion::bytes_of(n, bodies, r),
        };
        let fixed = (32 * n + 4 * sums + 36 * paths + world) as u64;
        let clearances = ClearanceSize::of(&simulation.instances[instance]).bytes(true);
        let contact = CONTACT_BYTES * contact_nodes(model) as u64 + clearances;
        let substep = tape::NODE_BYTES * n as u64 + tape::ROD_BYTES * r as u64;
        let substeps = u64::from(model.timing.substeps);
        match self.forward.tapes {
            Some(_) => Bytes { fixed: fixed + contact, frame: 0, substep: 0 },
            None => Bytes { fixed, frame: substep * substeps + contact, substep },
        }
    }
}
