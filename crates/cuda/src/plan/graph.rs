//! A graph on the device, shared by all parameters on it.

use std::sync::Arc;

use bendtwin_core::Graph;
use bendtwin_engine::Error;

use crate::{
    device::{
        Device,
        args::{self, LocalPin, Pointer, Share, Triplet},
        memo::Memo,
        memory::Buffer,
    },
    plan::{
        layout::Layout,
        layouts::{Cut, Layouts},
    },
};

/// A graph on the device.
pub(crate) struct DeviceGraph {
    pub(crate) graph: Arc<Graph>,
    /// Zero where pinned.
    inverse_mass: Buffer<f32>,
    masses: Buffer<f32>,
    pins: Buffer<args::Pin>,
    pin_of: Buffer<i32>,
    pub(crate) object_ids: Buffer<u32>,
    /// Positions at rest [m], padded.
    pub(crate) rest: Buffer<[f32; 4]>,
    /// Shape [E, 2].
    pub(crate) springs: Buffer<[u32; 2]>,
    /// Made when self contact first asks for it.
    neighbours: Memo<(), Arc<Neighbours>>,
    /// Made when a strain first asks for it.
    node_springs: Memo<(), Arc<NodeSprings>>,
    pub(crate) layouts: Layouts,
    /// Layouts that are on the device.
    cuts: Memo<Cut, Arc<CutGraph>>,
}

/// Nodes that springs join to each node.
pub(crate) struct Neighbours {
    /// First neighbour of each node, shape [N + 1].
    pub(crate) starts: Buffer<u32>,
    /// Neighbours, ascending for each node.
    pub(crate) nodes: Buffer<u32>,
}

/// Springs between two nodes, by node.
pub(crate) struct NodeSprings {
    /// First spring of each node, shape [N + 1].
    pub(crate) starts: Buffer<u32>,
    /// Springs, ascending for each node.
    pub(crate) springs: Buffer<u32>,
}

/// A graph cut for one shape of launch.
pub(crate) struct CutGraph {
    pub(crate) layout: Arc<Layout>,
    pub(crate) topology: args::TopologyArgs,
    pub(crate) springs: Buffer<u32>,
    pub(crate) others: Buffer<u32>,
    pub(crate) triplet_of: Buffer<u32>,
    /// First of each spring's sums; see `layout.rs`.
    pub(crate) sum_of: Buffer<u32>,
    /// Slot of each node on a tape that this cut writes.
    pub(crate) tape_slots: Buffer<u32>,
    /// Keeps alive what `topology` points to.
    _parts: TopologyBuffers,
}

struct TopologyBuffers {
    _shares: Buffer<Share>,
    _nodes: Buffer<u32>,
    _rows: Buffer<u32>,
    _triplets: Buffer<Triplet>,
    _arm_rows: Buffer<u32>,
    _arm_refs: Buffer<u32>,
    _local_pins: Buffer<LocalPin>,
    _exports: Buffer<u32>,
    _export_refs: Buffer<u32>,
    _sum_rows: Buffer<u32>,
    _rod_turns: Buffer<u32>,
    _rod_shares: Buffer<f32>,
}

impl DeviceGraph {
    pub(crate) fn new(device: &Device, graph: &Arc<Graph>) -> Result<Self, Error> {
        let stream = &device.normal;
        let mut inverse_mass: Vec<f32> = graph.masses.iter().map(|m| 1.0 / m).collect();
        let mut pin_of = vec![-1_i32; graph.node_count()];
        for (p, pin) in graph.pins.iter().enumerate() {
            inverse_mass[pin.node as usize] = 0.0;
            pin_of[pin.node as usize] = p as i32;
        }
        let pins: Vec<args::Pin> = graph
            .pins
            .iter()
            .map(|p| args::Pin { control: p.control, offset: p.offset_m })
            .collect();
        let rest: Vec<[f32; 4]> =
            graph.rest_positions.iter().map(|&[x, y, z]| [x, y, z, 0.0]).collect();
        Ok(Self {
            inverse_mass: Buffer::of(stream, &inverse_mass)?,
            masses: Buffer::of(stream, &graph.masses)?,
            pins: Buffer::of(stream, &pins)?,
            pin_of: Buffer::of(stream, &pin_of)?,
            object_ids: Buffer::of(stream, &graph.object_ids)?,
            rest: Buffer::of(stream, &rest)?,
            springs: Buffer::of(stream, &graph.springs)?,
            neighbours: Memo::default(),
            node_springs: Memo::default(),
            layouts: Layouts::new(graph.clone()),
            cuts: Memo::default(),
            graph: graph.clone(),
        })
    }

    /// Addresses of each node's pin, -1 where it has none, and of the pins.
    pub(crate) fn pins(&self) -> (Pointer<i32>, Pointer<args::Pin>) {
        (self.pin_of.address(), self.pins.address())
    }

    /// The graph cut in this way; made at first use.
    pub(crate) fn cut(&self, device: &Device, cut: Cut) -> Result<Arc<CutGraph>, Error> {
        self.cuts.get_or_make(cut, || {
            let layout = self.layouts.of(cut)?;
            Ok(Arc::new(self.upload(device, layout)?))
        })
    }

    fn upload(&self, device: &Device, layout: Arc<Layout>) -> Result<CutGraph, Error> {
        let stream = &device.normal;
        let parts = TopologyBuffers {
            _shares: Buffer::of(stream, &layout.shares)?,
            _nodes: Buffer::of(stream, &layout.nodes)?,
            _rows: Buffer::of(stream, &layout.rows)?,
            _triplets: Buffer::of(stream, &layout.triplets)?,
            _arm_rows: Buffer::of(stream, &layout.arm_rows)?,
            _arm_refs: Buffer::of(stream, &layout.arm_refs)?,
            _local_pins: Buffer::of(stream, &layout.local_pins)?,
            _exports: Buffer::of(stream, &layout.exports)?,
            _export_refs: Buffer::of(stream, &layout.export_refs)?,
            _sum_rows: Buffer::of(stream, &layout.sum_rows)?,
            _rod_turns: Buffer::of(stream, &layout.rod_turns)?,
            _rod_shares: Buffer::of(stream, &layout.rod_shares)?,
        };
        let triplet_of = Buffer::of(stream, &layout.triplet_of)?;
        let topology = args::TopologyArgs {
            shares: parts._shares.address(),
            nodes: parts._nodes.address(),
            rows: parts._rows.address(),
            triplets: parts._triplets.address(),
            arm_rows: parts._arm_rows.address(),
            arm_refs: parts._arm_refs.address(),
            local_pins: parts._local_pins.address(),
            pins: self.pins.address(),
            pin_of: self.pin_of.address(),
            exports: parts._exports.address(),
            export_refs: parts._export_refs.address(),
            inverse_mass: self.inverse_mass.address(),
            masses: self.masses.address(),
            sum_rows: parts._sum_rows.address(),
            triplet_of: triplet_of.address(),
            node_count: self.graph.node_count() as u32,
            control_count: layout.controls,
            control_base: layout.control_base,
            stride: layout.stride(),
            max_triplets: layout.max_triplets,
            max_pairs: layout.max_pairs,
            max_all_pairs: layout.max_all_pairs,
            rod_turns: parts._rod_turns.address(),
            rod_shares: parts._rod_shares.address(),
            rod_count: self.graph.rods.len() as u32,
            triplet_count: self.graph.triplets.len() as u32,
            pin_count: self.graph.pins.len() as u32,
        };
        let springs = Buffer::of(stream, &layout.springs)?;
        let others = Buffer::of(stream, &layout.others)?;
        let sum_of = Buffer::of(stream, &layout.sum_of)?;
        let tape_slots = Buffer::of(stream, &layout.tape_slots())?;
        // The urgent stream may use it next.
        crate::device::synchronize(stream)?;
        Ok(CutGraph {
            topology,
            springs,
            others,
            triplet_of,
            sum_of,
            tape_slots,
            layout,
            _parts: parts,
        })
    }

    /// Springs between two nodes by node; kept as long as the graph.
    pub(crate) fn node_springs(&self, device: &Device) -> Result<Arc<NodeSprings>, Error> {
        self.node_springs.get_or_make((), || {
            let n = self.graph.node_count();
            let mut own: Vec<Vec<u32>> = vec![Vec::new(); n];
            for (s, &[a, b]) in self.graph.springs.iter().enumerate() {
                if (a.max(b) as usize) < n {
                    own[a as usize].push(s as u32);
                    own[b as usize].push(s as u32);
                }
            }
            let mut starts = vec![0];
            starts.extend(own.iter().scan(0, |end, list| {
                *end += list.len() as u32;
                Some(*end)
            }));
            let made = NodeSprings {
                starts: Buffer::of(&device.normal, &starts)?,
                springs: Buffer::of(&device.normal, &own.concat())?,
            };
            crate::device::synchronize(&device.normal)?;
            Ok(Arc::new(made))
        })
    }

    /// Neighbours by springs; kept as long as the graph.
    pub(crate) fn neighbours(&self, device: &Device) -> Result<Arc<Neighbours>, Error> {
        self.neighbours.get_or_make((), || {
            let n = self.graph.node_count();
            let mut near: Vec<Vec<u32>> = vec![Vec::new(); n];
            for &[a, b] in self.graph.springs.iter().filter(|s| (s[1] as usize) < n) {
                near[a as usize].push(b);
                near[b as usize].push(a);
            }
            let (mut starts, mut all) = (vec![0], Vec::new());
            for mut list in near {
                list.sort_unstable();
                list.dedup();
                all.extend(list);
                starts.push(all.len() as u32);
            }
            let made = Neighbours {
                starts: Buffer::of(&device.normal, &starts)?,
                nodes: Buffer::of(&device.normal, &all)?,
            };
            crate::device::synchronize(&device.normal)?;
            Ok(Arc::new(made))
        })
    }
}
