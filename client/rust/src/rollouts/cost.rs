//! Costs that score a rollout.

use bendtwin_core::Point;
use bendtwin_proto::v1::{
    self, Tensor,
    cost::{Keypoints, Kind, Smoothness, TargetCloud, When},
};

/// A weighted cost, counted after the last frame unless [`Cost::every_frame`].
#[derive(Clone, Debug, PartialEq)]
pub struct Cost(pub(super) v1::Cost);

impl Cost {
    /// Mean squared distance of the target's points [m] to the nearest surface node [m²].
    pub fn target_cloud(name: &str, weight: f64, points: &[Point]) -> Self {
        let points = Some(Tensor::pack_points(&[points.len()], points));
        Self::new(name, weight, Kind::TargetCloud(TargetCloud { points }))
    }

    /// Mean distance between nodes and their targets [m]. A target too many or too few is left to
    /// the server to refuse.
    pub fn keypoints(name: &str, weight: f64, nodes: &[u32], targets: &[Point]) -> Self {
        let keypoints = Keypoints {
            nodes: Some(Tensor::pack(&[nodes.len()], nodes)),
            targets: Some(Tensor::pack_points(&[targets.len()], targets)),
            squared: false,
        };
        Self::new(name, weight, Kind::Keypoints(keypoints))
    }

    /// Mean squared second difference of node positions over three frames [m²].
    pub fn smoothness(name: &str, weight: f64) -> Self {
        Self::new(name, weight, Kind::Smoothness(Smoothness {})).every_frame()
    }

    /// Keypoint distances squared [m²]; nothing changes for other costs.
    #[must_use]
    pub fn squared(mut self) -> Self {
        if let Some(Kind::Keypoints(keypoints)) = &mut self.0.kind {
            keypoints.squared = true;
        }
        self
    }

    /// Summed over all frames.
    #[must_use]
    pub fn every_frame(mut self) -> Self {
        self.0.when = When::EveryFrame.into();
        self
    }

    fn new(name: &str, weight: f64, kind: Kind) -> Self {
        Self(v1::Cost {
            name: name.to_owned(),
            weight: Some(weight),
            when: When::LastFrame.into(),
            kind: Some(kind),
            ..v1::Cost::default()
        })
    }
}
