//! A skin on the device, shared by all models that have it.

use std::sync::Arc;

use bendtwin_core::{Point, Skin};
use bendtwin_engine::Error;

use crate::device::{Device, args::SkinArgs, memo::Memo, memory::Buffer};

/// A skin on the device.
pub(crate) struct DeviceSkin {
    skin: Arc<Skin>,
    starts: Buffer<u32>,
    nodes: Buffer<u32>,
    weights: Buffer<f32>,
    frames: Buffer<[u32; 3]>,
    offsets: Buffer<Point>,
    /// Skins by number of nodes; made when a gradient first asks for one.
    by_node: Memo<usize, Arc<DeviceSkinByNode>>,
}

/// A skin by node on the device, for gradients.
pub(crate) struct DeviceSkinByNode {
    starts: Buffer<u32>,
    points: Buffer<u32>,
    weights: Buffer<f32>,
    corner_starts: Buffer<u32>,
    corners: Buffer<[u32; 2]>,
    borne_starts: Buffer<u32>,
    borne: Buffer<u32>,
}

/// A skin as its nodes see it. K is the number of weights.
#[derive(Debug, PartialEq)]
struct SkinByNode {
    /// First weight of each node, and the end of the last, shape [N + 1].
    starts: Vec<u32>,
    /// Point of each weight, ascending for each node, shape [K].
    points: Vec<u32>,
    /// Weights, shape [K].
    weights: Vec<f32>,
    /// First corner of each node, and the end of the last, shape [N + 1].
    corner_starts: Vec<u32>,
    /// Points with an offset in a frame that the node is in, ascending for each node, and which of the
    /// frame's three nodes it is.
    corners: Vec<[u32; 2]>,
    /// First of the points that each node bears, and the end of the last, shape [N + 1].
    borne_starts: Vec<u32>,
    /// Points that each node bears, ascending.
    borne: Vec<u32>,
}

impl DeviceSkin {
    pub(crate) fn new(device: &Device, skin: &Arc<Skin>) -> Result<Self, Error> {
        let stream = &device.normal;
        Ok(Self {
            starts: Buffer::of(stream, &skin.starts)?,
            nodes: Buffer::of(stream, &skin.nodes)?,
            weights: Buffer::of(stream, &skin.weights)?,
            frames: Buffer::of(stream, &skin.frames)?,
            offsets: Buffer::of(stream, &skin.offsets_m)?,
            by_node: Memo::default(),
            skin: skin.clone(),
        })
    }

    /// Bytes that a skin takes on the device.
    pub(crate) fn bytes_of(skin: &Skin) -> u64 {
        20 * skin.weights.len() as u64 + 52 * skin.len() as u64
    }

    /// Arguments of kernels that place its points.
    pub(crate) fn args(&self) -> SkinArgs {
        SkinArgs {
            starts: self.starts.address(),
            nodes: self.nodes.address(),
            weights: self.weights.address(),
            frames: self.frames.address(),
            offsets: self.offsets.address(),
            point_count: self.skin.len() as u32,
            ..SkinArgs::default()
        }
    }

    /// The skin from the view of `nodes`; kept as long as the skin.
    pub(crate) fn by_node(
        &self,
        device: &Device,
        nodes: usize,
    ) -> Result<Arc<DeviceSkinByNode>, Error> {
        self.by_node.get_or_make(nodes, || {
            let stream = &device.normal;
            let by_node = SkinByNode::new(&self.skin, nodes);
            let made = DeviceSkinByNode {
                starts: Buffer::of(stream, &by_node.starts)?,
                points: Buffer::of(stream, &by_node.points)?,
                weights: Buffer::of(stream, &by_node.weights)?,
                corner_starts: Buffer::of(stream, &by_node.corner_starts)?,
                corners: Buffer::of(stream, &by_node.corners)?,
                borne_starts: Buffer::of(stream, &by_node.borne_starts)?,
                borne: Buffer::of(stream, &by_node.borne)?,
            };
            // The urgent stream may use it next.
            crate::device::synchronize(stream)?;
            Ok(Arc::new(made))
        })
    }
}

impl DeviceSkinByNode {
    /// Adds its lists to the arguments of its skin.
    pub(crate) fn add_to(&self, skin: SkinArgs) -> SkinArgs {
        SkinArgs {
            node_starts: self.starts.address(),
            carried: self.points.address(),
            carried_weights: self.weights.address(),
            corner_starts: self.corner_starts.address(),
            corners: self.corners.address(),
            borne_starts: self.borne_starts.address(),
            borne: self.borne.address(),
            ..skin
        }
    }
}

impl SkinByNode {
    /// The skin by node, of a checked skin.
    fn new(skin: &Skin, nodes: usize) -> Self {
        let weights = (0..skin.len()).flat_map(|m| {
            let own = skin.weights_of(m);
            own.map(move |(node, weight)| (node, (m as u32, weight)))
        });
        let corners = (0..skin.len()).filter(|&m| has_frame(skin, m)).flat_map(|m| {
            let corner = move |(k, node)| (node, [m as u32, k]);
            (0..).zip(skin.frames[m]).map(corner)
        });
        let (starts, carried) = grouped(nodes, weights);
        let (corner_starts, corners) = grouped(nodes, corners);
        let (points, weights) = carried.into_iter().unzip();
        let borne = (0..skin.len()).flat_map(|m| skin.bearers(m).map(move |node| (node, m as u32)));
        let (borne_starts, borne) = grouped(nodes, borne);
        Self { starts, points, weights, corner_starts, corners, borne_starts, borne }
    }
}

/// True if a point has an offset in a frame of nodes.
fn has_frame(skin: &Skin, point: usize) -> bool {
    skin.frames[point][0] != Skin::NO_FRAME && skin.offsets_m[point] != [0.0; 3]
}

/// Values by node, in their order for each, and where those of each begin.
fn grouped<T: Copy>(nodes: usize, values: impl Iterator<Item = (u32, T)>) -> (Vec<u32>, Vec<T>) {
    let mut all: Vec<(u32, T)> = values.collect();
    // Stable: those of a node stay in order.
    all.sort_by_key(|(node, _)| *node);
    let starts = (0..=nodes as u32).map(|n| all.partition_point(|(node, _)| *node < n) as u32);
    (starts.collect(), all.into_iter().map(|(_, value)| value).collect())
}

#[cfg(test)]
mod tests;
