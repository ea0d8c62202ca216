//! The geometry of twins, for planners: what a rollout's arrays are arrays of.

use std::sync::Arc;

use bendtwin_budget::Share;
use bendtwin_core::{Graph, Skin, Twin as TwinFile, geometry::distance, ids::TwinId};
use bendtwin_proto::v1::{Plane, Tensor, TwinGeometry, twin_geometry};
use prost::Message as _;

use super::{App, Result};
use crate::access::Scope;

/// The geometry of a twin, and its memory.
pub(crate) struct Geometry {
    pub(crate) message: TwinGeometry,
    pub(crate) held: Arc<Share>,
}

impl App {
    /// The geometry of a twin, `as_lists` if it is to be written as nested lists of JSON.
    pub(crate) async fn twin_geometry(&self, name: &str, as_lists: bool) -> Result<Geometry> {
        self.geometry_of(self.reach(Scope::TwinsRead, name).await?, as_lists).await
    }

    /// The geometry of a twin that the caller reaches.
    pub(in crate::app) async fn geometry_of(
        &self,
        twin: TwinId,
        as_lists: bool,
    ) -> Result<Geometry> {
        let message = self.read_twin(twin, |_, twin| Ok(geometry(twin))).await?;
        let held = self.hold_tensors(message.encoded_len() as u64, as_lists).await?;
        Ok(Geometry { message, held })
    }
}

fn geometry(twin: &TwinFile) -> TwinGeometry {
    let graph = &twin.graph;
    let (n, c) = (graph.node_count(), graph.control_count());
    let kinds: Vec<u8> = graph.kinds.iter().map(|kind| *kind as u8).collect();
    let unit = twin.newtons_per_unit();
    let physical = |values: &[f32]| -> Vec<f32> {
        values.iter().map(|value| (unit * f64::from(*value)) as f32).collect()
    };
    let numbers = |values: &[f32]| Some(Tensor::pack(&[values.len()], values));
    let pins: Vec<[u32; 2]> = graph.pins.iter().map(|pin| [pin.node, pin.control]).collect();
    let hands = twin.hands();
    let mut rod_starts = vec![0u32];
    rod_starts.extend(graph.rods.iter().scan(0, |start, rod| {
        *start += rod.len() as u32;
        Some(*start)
    }));
    let rod_nodes = graph.rods.concat();
    let plane = |plane: bendtwin_core::Plane| Plane {
        normal: plane.normal.to_vec(),
        offset_m: plane.offset_m,
    };
    let rows = |rows: &[[u32; 2]]| Some(Tensor::pack(&[rows.len(), 2], rows.as_flattened()));
    let contact = &twin.params.contact;
    let report = twin.quality.identifiability.as_ref();
    let regions = report.map_or(&[][..], |report| &report.node_regions);
    TwinGeometry {
        rest_positions: Some(Tensor::pack_points(&[n], &graph.rest_positions)),
        kinds: Some(Tensor::pack(&[n], &kinds)),
        edges: rows(&graph.springs),
        rest_lengths: numbers(&twin.params.rest_lengths_m),
        triplets: Some(Tensor::pack(&[graph.triplets.len(), 3], graph.triplets.as_flattened())),
        masses: numbers(&physical(&graph.masses)),
        controls: Some(Tensor::pack_points(&[c], &graph.control_rest)),
        hands: Some(Tensor::pack(&[c], &hands)),
        pins: rows(&pins),
        surface_count: graph.surface_count() as u32,
        rod_count: graph.rods.len() as u32,
        fps: twin.timing.fps,
        substeps: twin.timing.substeps,
        gravity: twin.environment.gravity.to_vec(),
        ground: twin.environment.ground.map(plane),
        ground_friction: contact.ground_friction,
        ground_restitution: contact.ground_restitution,
        mass_kg: twin.mass_kg,
        spacing_m: spacing(graph),
        rod_starts: Some(Tensor::pack(&[rod_starts.len()], &rod_starts)),
        rod_nodes: Some(Tensor::pack(&[rod_nodes.len()], &rod_nodes)),
        skin: Some(skin(&twin.skin, graph)),
        spring_stiffness: numbers(&physical(&twin.params.spring_stiffness)),
        bend_stiffness: numbers(&physical(&twin.params.bend_stiffness)),
        fits: 1 + twin.members.len() as u32,
        node_regions: Some(Tensor::pack(&[regions.len()], regions)),
        skin_sd: numbers(report.map_or(&[], |report| &report.point_sd_m)),
    }
}

/// The wire form of points that nodes carry.
pub(super) fn skin(skin: &Skin, graph: &Graph) -> twin_geometry::Skin {
    let (m, k) = (skin.len(), skin.nodes.len());
    let counts: Vec<u32> = skin.starts.windows(2).map(|ends| ends[1] - ends[0]).collect();
    twin_geometry::Skin {
        rest_positions: Some(Tensor::pack_points(&[m], &skin.positions(&graph.rest_positions))),
        observed_points: Some(Tensor::pack(&[m], &skin.observed_points)),
        weight_counts: Some(Tensor::pack(&[m], &counts)),
        weight_nodes: Some(Tensor::pack(&[k], &skin.nodes)),
        weights: Some(Tensor::pack(&[k], &skin.weights)),
        frames: Some(Tensor::pack(&[m, 3], skin.frames.as_flattened())),
        offsets: Some(Tensor::pack_points(&[m], &skin.offsets_m)),
    }
}

/// Mean length of springs between nodes at rest [m]; 0 without any.
fn spacing(graph: &Graph) -> f64 {
    let n = graph.node_count() as u32;
    let between = graph.springs.iter().filter(|[_, end]| *end < n);
    let (sum, count) = between.fold((0.0, 0usize), |(sum, count), [a, b]| {
        let length = distance(graph.rest_endpoint(*a), graph.rest_endpoint(*b));
        (sum + f64::from(length), count + 1)
    });
    if count == 0 { 0.0 } else { sum / count as f64 }
}
