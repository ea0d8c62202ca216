//! The surface of a twin: a closed mesh around the points of its skin, or tubes along its cables.
//!
//! The skin is a cloud of points, with gaps where no camera saw the object. [`surface_of`] closes the gaps: it
//! grows the points to balls that touch one another, fills what the balls enclose, and shrinks the whole again
//! by the radius of the balls ([`wrap`]). The mesh passes near the points, and is closed wherever they
//! lie. Nodes carry its vertices as they carry the skin.

mod color;
mod grid;
mod nets;
mod tubes;
mod wrap;

use std::borrow::Cow;

use bendtwin_core::{Graph, NodeKind, Point, Surface, Twin};
use bendtwin_graph::{SurfacePoints, bind_points};

pub use self::wrap::{Wrapped, wrap};

/// The surface that a twin has, or one that is made for it in the colours of its skin; `None` if its points are too few
/// for one.
pub fn of_twin(twin: &Twin) -> Option<Cow<'_, Surface>> {
    let colors = twin.appearance.as_ref().map_or(&[][..], |look| &look.skin_colors);
    match &twin.surface {
        Some(surface) => Some(Cow::Borrowed(surface)),
        None => surface_of(twin, colors).map(Cow::Owned),
    }
}

/// Colours of all vertices of a twin's surface, those of tubes included (sRGB), shape [V, 3]; empty if they are not
/// known.
pub fn vertex_colors(twin: &Twin, surface: &Surface) -> Vec<[u8; 3]> {
    let own = surface.carriers.len();
    if surface.tubes.is_empty() {
        return surface.colors.clone();
    }
    let colors = twin.appearance.as_ref().map_or(&[][..], |look| &look.skin_colors);
    let rest = &twin.graph.rest_positions;
    let mut all = color::of_vertices(&surface.positions(rest), &twin.skin.positions(rest), colors);
    if all.len() >= own && surface.colors.len() == own {
        all[..own].copy_from_slice(&surface.colors);
    }
    all
}

/// The surface of a twin at rest; `None` if its points are too few for one.
///
/// `colors` has the colour of each skin point (sRGB), shape [M, 3], or is empty.
pub fn surface_of(twin: &Twin, colors: &[[u8; 3]]) -> Option<Surface> {
    let graph = &twin.graph;
    let tubes = tubes::of(graph);
    if !tubes.is_empty() {
        return Some(Surface { tubes, ..Surface::default() });
    }
    let skin = twin.skin.positions(&graph.rest_positions);
    let nodes = graph.rest_positions.iter().zip(&graph.kinds);
    let inside: Vec<Point> =
        nodes.filter(|(_, kind)| **kind == NodeKind::Interior).map(|(p, _)| *p).collect();
    // A twin that was made by hand may have a skin of a few points.
    let of_nodes = &graph.rest_positions[..graph.surface_count()];
    let points = if skin.len() < of_nodes.len() { of_nodes } else { &skin[..] };
    let Wrapped { vertices, triangles } = wrap(points, &inside)?;
    let colors = color::of_vertices(&vertices, &skin, colors);
    let observed_points = vec![Graph::NOT_OBSERVED; vertices.len()];
    let points = SurfacePoints { positions: vertices, observed_points };
    let carriers = bind_points(graph, &graph.rest_positions, &points);
    Some(Surface { carriers, triangles, colors, tubes })
}

#[cfg(test)]
mod tests;
