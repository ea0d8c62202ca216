//! What the kernels are handed: the mirror of `kernels/job.cuh`, field by field. Pointers are device
//! addresses; zero is null. The kernels are compiled with the sizes of these structs and refuse others.

use bytemuck::{Pod, Zeroable};

/// A device address.
pub(crate) type Address = u64;

/// A block's share of a graph.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
pub(crate) struct Share {
    pub(crate) own: u32,
    pub(crate) local: u32,
    pub(crate) nodes: u32,
    pub(crate) rows: u32,
    pub(crate) control_rows: u32,
    pub(crate) row: u32,
    pub(crate) triplets: u32,
    pub(crate) triplet: u32,
    pub(crate) arm: u32,
    pub(crate) pins: u32,
    pub(crate) pin: u32,
    pub(crate) export: u32,
    pub(crate) slot: u32,
}

/// A pinned node among a block's local ones.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
pub(crate) struct LocalPin {
    pub(crate) local: u32,
    pub(crate) pin: u32,
}

/// A pin of the graph.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub(crate) struct Pin {
    pub(crate) control: u32,
    pub(crate) offset: [f32; 3],
}

/// A triplet by local indices.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
pub(crate) struct Triplet {
    pub(crate) ends: [u16; 3],
    /// Whether this block reports its gradient; of a rod's inner node, whether the last end is an arm.
    pub(crate) owned: u16,
}

/// A graph as one shape of launch sees it.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub(crate) struct Topology {
    pub(crate) shares: Address,
    pub(crate) nodes: Address,
    pub(crate) rows: Address,
    pub(crate) triplets: Address,
    pub(crate) arms: Address,
    pub(crate) arm_refs: Address,
    pub(crate) local_pins: Address,
    pub(crate) pins: Address,
    pub(crate) pin_of: Address,
    pub(crate) exports: Address,
    pub(crate) export_refs: Address,
    pub(crate) inverse_mass: Address,
    pub(crate) sum_rows: Address,
    pub(crate) triplet_of: Address,
    pub(crate) node_count: u32,
    pub(crate) controls: u32,
    pub(crate) control_base: u32,
    pub(crate) stride: u32,
    pub(crate) max_triplets: u32,
    pub(crate) max_pairs: u32,
    pub(crate) max_all_pairs: u32,
    pub(crate) rods: u32,
    pub(crate) rod_turns: Address,
}

/// One simulation to run.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub(crate) struct Job {
    pub(crate) topology: Topology,
    pub(crate) rates: Address,
    pub(crate) others: Address,
    pub(crate) dashpots: Address,
    pub(crate) bends: Address,
    pub(crate) controls: Address,
    pub(crate) states: Address,
    pub(crate) divergence: Address,
    pub(crate) tape_slots: Address,
    pub(crate) tape_x: Address,
    pub(crate) tape_v: Address,
    pub(crate) tape_b: Address,
    pub(crate) bar_x: Address,
    pub(crate) bar_v: Address,
    pub(crate) spring_sums: Address,
    pub(crate) bend_sums: Address,
    pub(crate) law_sums: Address,
    pub(crate) control_sums: Address,
    pub(crate) pin_sums: Address,
    pub(crate) partners: Address,
    pub(crate) partner_counts: Address,
    pub(crate) partner_scratch: Address,
    pub(crate) object_ids: Address,
    pub(crate) joined_starts: Address,
    pub(crate) joined: Address,
    pub(crate) contact_x: Address,
    pub(crate) contact_v: Address,
    pub(crate) exchange_x: Address,
    pub(crate) exchange_v: Address,
    pub(crate) barrier: Address,
    pub(crate) spill: Address,
    pub(crate) kick: [f32; 3],
    pub(crate) ground_normal: [f32; 3],
    pub(crate) ground_offset: f32,
    pub(crate) ground_law: [f32; 2],
    pub(crate) object_law: [f32; 2],
    pub(crate) dt: f32,
    pub(crate) decay: f32,
    pub(crate) frame_s: f32,
    pub(crate) collision_distance: f32,
    pub(crate) dashpot: f32,
    pub(crate) substeps: u32,
    pub(crate) slots: u32,
    pub(crate) controls_move: u32,
    pub(crate) first: u32,
    pub(crate) frames: u32,
    pub(crate) triplets: u32,
    pub(crate) pins: u32,
    pub(crate) max_partners: u32,
    pub(crate) between_objects: u32,
    pub(crate) within_object: u32,
    pub(crate) spill_stride: u32,
    pub(crate) unused: u32,
    pub(crate) rods: Address,
    pub(crate) twists: Address,
    pub(crate) tape_twists: Address,
    pub(crate) twist_bars: Address,
}

/// One term of an objective; see `kernels/loss.cu`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub(crate) struct Term {
    pub(crate) kind: u32,
    pub(crate) frame: u32,
    pub(crate) count: u32,
    pub(crate) first: u32,
    pub(crate) loss: u32,
    pub(crate) beta: f32,
    pub(crate) weight: f32,
    pub(crate) unused: u32,
}

/// A job as its objective sees it.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub(crate) struct Measure {
    pub(crate) states: Address,
    pub(crate) terms: Address,
    pub(crate) frame_terms: Address,
    pub(crate) targets: Address,
    pub(crate) target_nodes: Address,
    pub(crate) nearest: Address,
    pub(crate) values: Address,
    pub(crate) seeds: Address,
    pub(crate) nodes: u32,
    pub(crate) surface: u32,
    pub(crate) frames: u32,
    pub(crate) term_count: u32,
    pub(crate) cut_every: u32,
    pub(crate) unused: u32,
}

/// A job as its recording sees it; see `kernels/record.cu`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub(crate) struct Record {
    pub(crate) states: Address,
    pub(crate) frames: Address,
    pub(crate) nodes: Address,
    pub(crate) positions: Address,
    pub(crate) springs: Address,
    pub(crate) params: Address,
    pub(crate) controls: Address,
    pub(crate) extremes: Address,
    pub(crate) node_count: u32,
    pub(crate) recorded_nodes: u32,
    pub(crate) recorded_frames: u32,
    pub(crate) slots: u32,
    pub(crate) spring_count: u32,
    pub(crate) controls_count: u32,
    pub(crate) frame_count: u32,
    pub(crate) unused: u32,
}

/// An instance as its start sees it; see `kernels/start.cu`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub(crate) struct Start {
    pub(crate) initial: Address,
    pub(crate) states: Address,
    pub(crate) controls: Address,
    pub(crate) pin_of: Address,
    pub(crate) pins: Address,
    pub(crate) frame_s: f32,
    pub(crate) nodes: u32,
    pub(crate) control_count: u32,
    pub(crate) controls_move: u32,
    pub(crate) initial_twists: Address,
    pub(crate) twists: Address,
    pub(crate) rods: u32,
    pub(crate) unused: u32,
}
