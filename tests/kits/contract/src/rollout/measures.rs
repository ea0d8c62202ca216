//! Costs with one fault each, of the kinds that measure more than distances to targets.

use bendtwin_proto::v1::{
    Cost, Cuboid, Plane, Tensor,
    cost::{
        Clearance, ControlPath, ControlSpeed, Force, Height, Keypoints, Kind, Smoothness, Strain,
        When, Within,
        force::{All, By},
    },
};

use super::{Named, cloud, cost, keypoints, with, zeros};

/// Costs for a batch of 2 instances and 2 frames of a twin with `n` nodes and `c` control points.
pub(super) fn costs(n: u64, c: u64) -> Named<Vec<Cost>> {
    const POINTS: &str = "`costs[0].target_cloud.points`";
    const TARGETS: &str = "`costs[0].keypoints.targets`";
    const SUCCESS: &str = "`costs[0].success_at_most`";
    let of = |kind| vec![cost(Some(kind))];
    let timed = |when: When, kind| vec![Cost { when: when.into(), ..cost(kind) }];
    let strain = |limit| of(Kind::Strain(Strain { limit }));
    let force = |by, limit_n| of(Kind::Force(Force { by, limit_n }));
    let height = |normal: &[f32], nodes| {
        let plane = Some(Plane { normal: normal.to_vec(), offset_m: 0.0 });
        of(Kind::Height(Height { plane, nodes }))
    };
    let within = |low: &[f32], nodes| {
        let cuboid = Some(Cuboid { low: low.to_vec(), high: vec![1.0; 3] });
        of(Kind::Within(Within { cuboid, nodes }))
    };
    let clearance = |collider, margin_m| of(Kind::Clearance(Clearance { collider, margin_m }));
    let condition = |kind, most| vec![Cost { success_at_most: Some(most), ..cost(Some(kind)) }];
    let speed = |limit_m_s| of(Kind::ControlSpeed(ControlSpeed { limit_m_s }));
    let nodes = |node: u32| Some(Tensor::pack(&[1], &[node]));
    let moving = |targets: Tensor| {
        let (nodes, targets) = (nodes(0), Some(targets));
        let keypoints = Keypoints { nodes, targets, ..Keypoints::default() };
        timed(When::EveryFrame, Some(Kind::Keypoints(keypoints)))
    };
    vec![
        ("targets by frame for the last one", POINTS, of_kind(cloud(Some(zeros(&[2, 5, 3]))))),
        ("targets of another horizon", TARGETS, moving(zeros(&[3, 1, 3]))),
        ("targets of another batch", TARGETS, moving(zeros(&[3, 2, 1, 3]))),
        ("targets by frame without points", TARGETS, moving(zeros(&[2, 0, 3]))),
        ("NaN in the targets of a frame", TARGETS, moving(with(&[2, 1, 3], f32::NAN))),
        ("targets in five dimensions", TARGETS, moving(zeros(&[1, 2, 2, 1, 3]))),
        (
            "a soft minimum without temperature",
            "`costs[0].temperature`",
            timed(When::SoftMin, keypoints(&[0], 1)),
        ),
        ("a negative limit of strain", "`costs[0].strain.limit`", strain(-0.1)),
        ("a limit of strain that is NaN", "`costs[0].strain.limit`", strain(f32::NAN)),
        ("a force of nothing", "`costs[0].force.by`", force(None, 1.0)),
        (
            "a negative limit of force",
            "`costs[0].force.limit_n`",
            force(Some(By::Control(0)), -1.0),
        ),
        (
            "a limit of force that is NaN",
            "`costs[0].force.limit_n`",
            force(Some(By::Control(0)), f64::NAN),
        ),
        (
            "a force of a grasp that is not there",
            "`costs[0].force.grasp`",
            force(Some(By::Grasp(0)), 1.0),
        ),
        (
            "a force of a collider that is not there",
            "`costs[0].force.collider`",
            force(Some(By::Collider(0)), 1.0),
        ),
        (
            "a force of a control point that is not there",
            "`costs[0].force.control`",
            force(Some(By::Control(c as u32)), 1.0),
        ),
        (
            "a plane whose normal is long",
            "`costs[0].height.plane.normal`",
            height(&[0.0, 0.0, 1.9], None),
        ),
        (
            "the height of a node that is not there",
            "`costs[0].height.nodes`",
            height(&[], nodes(n as u32)),
        ),
        (
            "the height of no node",
            "`costs[0].height.nodes`",
            height(&[], Some(Tensor::pack::<u32>(&[1, 0], &[]))),
        ),
        ("no box", "`costs[0].within.cuboid`", of(Kind::Within(Within::default()))),
        ("a box that is inside out", "`costs[0].within.cuboid.low`", within(&[2.0; 3], None)),
        (
            "a node that is not there in a box",
            "`costs[0].within.nodes`",
            within(&[0.0; 3], nodes(n as u32)),
        ),
        (
            "clearance of a collider that is not there",
            "`costs[0].clearance.collider`",
            clearance(0, 0.1),
        ),
        ("a negative limit of speed", "`costs[0].control_speed.limit_m_s`", speed(-1.0)),
        ("a condition that is NaN", SUCCESS, condition(Kind::Strain(Strain::default()), f64::NAN)),
        ("a negative condition", SUCCESS, condition(Kind::Strain(Strain::default()), -1e-9)),
        ("a condition of smoothness", SUCCESS, condition(Kind::Smoothness(Smoothness {}), 1.0)),
        (
            "a condition of the control path",
            SUCCESS,
            condition(Kind::ControlPath(ControlPath {}), 1.0),
        ),
        (
            "a condition of the control speed",
            SUCCESS,
            condition(Kind::ControlSpeed(ControlSpeed { limit_m_s: 1.0 }), 1.0),
        ),
        (
            "a condition of a force",
            SUCCESS,
            condition(Kind::Force(Force { by: Some(By::Ground(All {})), limit_n: 1.0 }), 1.0),
        ),
    ]
}

fn of_kind(kind: Option<Kind>) -> Vec<Cost> {
    vec![cost(kind)]
}
