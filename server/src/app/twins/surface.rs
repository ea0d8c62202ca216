//! The surface of a twin: that of its file, or one that is made for a file without.

use std::sync::Arc;

use bendtwin_budget::Share;
use bendtwin_core::{Graph, Surface};
use bendtwin_proto::v1::{Tensor, TwinSurface};
use bendtwin_surface::of_twin;
use prost::Message as _;

use super::{App, Error, Result, geometry::skin};
use crate::access::Scope;

/// The surface of a twin, and its memory.
pub(crate) struct SurfaceReply {
    pub(crate) message: TwinSurface,
    pub(crate) held: Arc<Share>,
}

impl App {
    /// The surface of a twin, `as_lists` if it is to be written as nested lists of JSON.
    ///
    /// # Errors
    /// [`Error::NoSurface`] for a twin of too few points.
    pub(crate) async fn twin_surface(&self, name: &str, as_lists: bool) -> Result<SurfaceReply> {
        let twin = self.reach(Scope::TwinsRead, name).await?;
        let _turn = self.drawing.turn().await;
        let read = self.read_twin(twin, |row, twin| match of_twin(twin) {
            Some(surface) => Ok(message(&surface, &twin.graph)),
            None => Err(Error::NoSurface(row.id.to_string())),
        });
        let message = read.await?;
        let held = self.hold_tensors(message.encoded_len() as u64, as_lists).await?;
        Ok(SurfaceReply { message, held })
    }
}

fn message(surface: &Surface, graph: &Graph) -> TwinSurface {
    let tubes = &surface.tubes;
    let mut starts = vec![0u32];
    starts.extend(tubes.iter().scan(0, |end, tube| {
        *end += tube.nodes.len() as u32;
        Some(*end)
    }));
    let nodes: Vec<u32> = tubes.iter().flat_map(|tube| &tube.nodes).copied().collect();
    let radii: Vec<f32> = tubes.iter().map(|tube| tube.radius_m).collect();
    let triangles = surface.triangles.as_flattened();
    TwinSurface {
        carriers: Some(skin(&surface.carriers, graph)),
        triangles: Some(Tensor::pack(&[surface.triangles.len(), 3], triangles)),
        colors: Some(Tensor::pack(&[surface.colors.len(), 3], surface.colors.as_flattened())),
        tube_starts: Some(Tensor::pack(&[starts.len()], &starts)),
        tube_nodes: Some(Tensor::pack(&[nodes.len()], &nodes)),
        tube_radii: Some(Tensor::pack(&[radii.len()], &radii)),
        node_count: graph.node_count() as u32,
    }
}
