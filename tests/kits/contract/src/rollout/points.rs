//! Costs and returns with one fault each in the points that they name.

use bendtwin_proto::v1::{
    Cost, PointSet, Returns, Tensor,
    cost::{Keypoints, Kind, TargetCloud},
};

use super::{Named, cost, zeros};

fn list(points: &[u32]) -> Option<Tensor> {
    Some(Tensor::pack(&[points.len()], points))
}

pub(super) fn costs() -> Named<Vec<Cost>> {
    const POINTS: &str = "`costs[0].keypoints.skin_points`";
    let keypoints = |nodes, skin_points, targets| {
        let targets = Some(zeros(&[targets, 3]));
        let keypoints = Keypoints { nodes, skin_points, targets, squared: false };
        vec![cost(Some(Kind::Keypoints(keypoints)))]
    };
    let cloud = |point_set| {
        let points = Some(zeros(&[1, 3]));
        vec![cost(Some(Kind::TargetCloud(TargetCloud { points, point_set })))]
    };
    vec![
        ("a cloud at an unknown point set", "`costs[0].target_cloud.point_set`", cloud(3)),
        ("keypoints of nodes and of the skin", POINTS, keypoints(list(&[0]), list(&[0]), 1)),
        ("no points of the skin", POINTS, keypoints(None, list(&[]), 0)),
        ("a point that the skin does not have", POINTS, keypoints(None, list(&[u32::MAX]), 1)),
        ("points of the skin as floats", POINTS, keypoints(None, Some(zeros(&[1])), 1)),
        (
            "more points of the skin than targets",
            "`costs[0].keypoints.targets`",
            keypoints(None, list(&[0, 0]), 1),
        ),
    ]
}

pub(super) fn returns() -> Named<Returns> {
    const POINTS: &str = "`returns.skin_points`";
    let skin = PointSet::Skin.into();
    let recording = |point_set, nodes, skin_points| Returns {
        every_frames: 1,
        point_set,
        nodes,
        skin_points,
        ..Returns::default()
    };
    let as_floats = Some(zeros(&[1]));
    vec![
        ("an unknown point set", "`returns.point_set`", recording(9, None, None)),
        ("nodes of a recorded skin", "`returns.nodes`", recording(skin, list(&[0]), None)),
        ("points of the skin among nodes", POINTS, recording(0, None, list(&[0]))),
        ("a point to record that the skin does not have", POINTS, {
            recording(skin, None, list(&[u32::MAX]))
        }),
        ("points of the skin to record as floats", POINTS, recording(skin, None, as_floats)),
    ]
}
