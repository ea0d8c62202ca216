//! Points whose positions and velocities are recorded. The engine records nodes; the skin is placed
//! from them here, so that it is the same on every backend.

use std::sync::Arc;

use bendtwin_contract::rollout;
use bendtwin_core::{Point, Skin, geometry::wide};
use bendtwin_engine::backend::Rollout;
use bendtwin_proto::v1::{PointSet, Returns, Tensor};

use crate::error::Error;

/// Points that are recorded.
#[derive(Clone, Debug)]
pub(crate) enum Recorded {
    /// Nodes; none means all.
    Nodes(Option<Arc<Vec<u32>>>),
    Skin(Arc<SkinSelection>),
}

/// Points of a skin, and the nodes that they are placed from.
#[derive(Debug)]
pub(crate) struct SkinSelection {
    /// `None` means all.
    points: Option<Vec<u32>>,
    /// Nodes that the engine records, ascending.
    nodes: Arc<Vec<u32>>,
    /// Place of each node among them, shape [N]; [`u32::MAX`] where it is not recorded.
    rows: Vec<u32>,
}

impl Default for Recorded {
    fn default() -> Self {
        Self::Nodes(None)
    }
}

impl Recorded {
    /// Reads what is recorded from the returns of a checked request to a twin with `nodes` nodes.
    pub(crate) fn read(wire: &mut Returns, skin: &Skin, nodes: usize) -> Result<Self, Error> {
        let listed = |tensor: &mut Option<Tensor>, field| {
            let given = tensor.take().filter(|t| !t.is_absent());
            given.map(|t| t.unpack(field).map(|(_, points)| points)).transpose()
        };
        if rollout::recorded(wire) == PointSet::Skin {
            let points = listed(&mut wire.skin_points, "returns.skin_points")?;
            return Ok(Self::Skin(Arc::new(SkinSelection::new(points, skin, nodes))));
        }
        Ok(Self::Nodes(listed(&mut wire.nodes, "returns.nodes")?.map(Arc::new)))
    }

    /// Nodes that the engine records; none means all.
    pub(crate) fn nodes(&self) -> Option<&Arc<Vec<u32>>> {
        match self {
            Self::Nodes(nodes) => nodes.as_ref(),
            Self::Skin(placed) => Some(&placed.nodes),
        }
    }

    /// Number of points K of a twin with this skin and number of nodes.
    pub(crate) fn count(&self, skin: &Skin, nodes: usize) -> usize {
        match self {
            Self::Nodes(some) => some.as_ref().map_or(nodes, |some| some.len()),
            Self::Skin(placed) => placed.points.as_ref().map_or(skin.len(), Vec::len),
        }
    }

    /// Replaces recorded nodes by the points that are asked for.
    pub(crate) fn place(&self, skin: &Skin, rollout: &mut Rollout) {
        if let Self::Skin(placed) = self {
            let velocities = placed.velocities(skin, &rollout.positions, &rollout.velocities);
            rollout.positions = placed.positions(skin, &rollout.positions);
            rollout.velocities = velocities;
        }
    }
}

impl SkinSelection {
    fn new(points: Option<Vec<u32>>, skin: &Skin, nodes: usize) -> Self {
        let mut rows = vec![u32::MAX; nodes];
        let mut carry = |point: usize| skin.carriers(point).for_each(|i| rows[i as usize] = 0);
        match &points {
            None => (0..skin.len()).for_each(&mut carry),
            Some(points) => points.iter().for_each(|point| carry(*point as usize)),
        }
        let carriers = rows.iter_mut().zip(0..).filter(|(row, _)| **row == 0);
        let number = |(place, (row, node)): (u32, (&mut u32, u32))| {
            *row = place;
            node
        };
        let nodes = Arc::new((0..).zip(carriers).map(number).collect());
        Self { points, nodes, rows }
    }

    /// Positions of the points [m], shape [frames, K], from those of the nodes.
    fn positions(&self, skin: &Skin, nodes: &[Point]) -> Vec<Point> {
        let each = nodes.chunks_exact(self.nodes.len().max(1)).flat_map(|now| {
            let at = move |i: u32| self.at(now, i);
            self.points(skin).map(move |point| skin.position(point, at).map(|x| x as f32))
        });
        each.collect()
    }

    /// Velocities of the points [m/s], shape [frames, K], from positions and velocities of the nodes;
    /// none if those have none.
    fn velocities(&self, skin: &Skin, nodes: &[Point], velocities: &[Point]) -> Vec<Point> {
        let frames = |values| <[Point]>::chunks_exact(values, self.nodes.len().max(1));
        let each = frames(nodes).zip(frames(velocities)).flat_map(|(now, moving)| {
            let (at, velocity) = (move |i| self.at(now, i), move |i| self.at(moving, i));
            let of = move |point| skin.velocity(point, at, velocity).map(|x| x as f32);
            self.points(skin).map(of)
        });
        each.collect()
    }

    fn points<'a>(&'a self, skin: &Skin) -> impl Iterator<Item = usize> + use<'a> {
        let count = self.points.as_ref().map_or(skin.len(), Vec::len);
        (0..count).map(|k| self.points.as_ref().map_or(k, |points| points[k] as usize))
    }

    /// A node in a frame of the recording.
    fn at(&self, now: &[Point], node: u32) -> [f64; 3] {
        wide(now[self.rows[node as usize] as usize])
    }
}
