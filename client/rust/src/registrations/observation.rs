//! What was seen of an object.

use bendtwin_core::Point;
use bendtwin_proto::v1::{
    self, Tensor,
    observation::{Places, Tracks},
};

/// Points that were seen of an object at one time, in the twin's coordinates; those that were not
/// seen are left out.
#[derive(Clone, Debug, PartialEq)]
pub struct Observation(v1::Observation);

impl Observation {
    /// A cloud [m], shape [M], which is matched to the surface.
    pub fn cloud(points: &[Point]) -> Self {
        Self(v1::Observation { points: packed(points), ..v1::Observation::default() })
    }

    /// Points that are nodes of the twin [m], shape [M].
    pub fn nodes(points: &[Point], nodes: &[u32]) -> Self {
        let nodes = Tensor::pack(&[nodes.len()], nodes);
        Self(v1::Observation { tracks: Some(Tracks::Nodes(nodes)), ..Self::cloud(points).0 })
    }

    /// Tracked points [m], shape [M], that were at `places` when the nodes were at `nodes`, or at
    /// rest if that is empty.
    pub fn tracks(points: &[Point], places: &[Point], nodes: &[Point]) -> Self {
        let node_positions = packed(nodes).filter(|_| !nodes.is_empty());
        let places = Tracks::Places(Places { points: packed(places), node_positions });
        Self(v1::Observation { tracks: Some(places), ..Self::cloud(points).0 })
    }

    /// Weights of the points from 0, shape [M].
    #[must_use]
    pub fn weights(mut self, weights: &[f32]) -> Self {
        self.0.weights = Some(Tensor::pack(&[weights.len()], weights));
        self
    }

    /// Velocities of the points [m/s], shape [M]; only a correction by nodes or tracks uses them.
    #[must_use]
    pub fn velocities(mut self, velocities: &[Point]) -> Self {
        self.0.velocities = packed(velocities);
        self
    }

    /// Positions of the cameras that saw the points [m], which say what part of the surface could
    /// have been seen.
    #[must_use]
    pub fn cameras(mut self, cameras: &[Point]) -> Self {
        self.0.cameras = packed(cameras);
        self
    }
}

impl From<Observation> for v1::Observation {
    fn from(Observation(wire): Observation) -> Self {
        wire
    }
}

fn packed(points: &[Point]) -> Option<Tensor> {
    Some(Tensor::pack_points(&[points.len()], points))
}
