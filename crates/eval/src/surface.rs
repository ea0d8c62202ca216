//! The points at which errors are measured: a twin's skin, or its nodes.

use bendtwin_core::{Graph, Point, Skin};

use crate::Trajectory;

/// Points of an object, those of its surface first.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Surface {
    /// Observed point of the capture that each is, or [`Graph::NOT_OBSERVED`], shape [P].
    pub(crate) observed_points: Vec<u32>,
    /// Positions at rest [m], shape [P, 3].
    pub(crate) rest: Vec<Point>,
    /// Number of points of the surface.
    pub(crate) count: usize,
}

impl Surface {
    pub(crate) fn of_nodes(graph: &Graph) -> Self {
        Self {
            observed_points: graph.observed_points.clone(),
            rest: graph.rest_positions.clone(),
            count: graph.surface_count(),
        }
    }

    pub(crate) fn of_skin(graph: &Graph, skin: &Skin) -> Self {
        Self {
            observed_points: skin.observed_points.clone(),
            rest: skin.positions(&graph.rest_positions),
            count: skin.len(),
        }
    }
}

impl Trajectory {
    /// The points of a skin that the nodes carry, in place of the nodes. The skin must be of their
    /// graph.
    #[must_use]
    pub fn at_skin(&self, skin: &Skin) -> Self {
        let frames = self.positions.chunks_exact(self.node_count.max(1));
        Self {
            start_frame: self.start_frame,
            node_count: skin.len(),
            positions: frames.flat_map(|nodes| skin.positions(nodes)).collect(),
            diverged: self.diverged,
        }
    }
}
