//! Tracks: points that nodes carry, bound in a state in which both are known.

use bendtwin_core::{Graph, Point, Skin};
use bendtwin_graph::{SurfacePoints, bind_points};

/// Binds points to nodes, both at the same time [m], as the points of a twin's skin are bound at
/// rest; `None` if the nodes are not those of the graph, if there are no points, or if a position
/// is not finite.
pub fn bind_tracks(graph: &Graph, nodes: &[Point], points: &[Point]) -> Option<Skin> {
    let finite = nodes.iter().chain(points).flatten().all(|x| x.is_finite());
    if !finite || nodes.is_empty() || nodes.len() != graph.node_count() {
        return None;
    }
    let points = SurfacePoints {
        positions: points.to_vec(),
        observed_points: vec![Graph::NOT_OBSERVED; points.len()],
    };
    Some(bind_points(graph, nodes, &points))
}

#[cfg(test)]
mod tests;
