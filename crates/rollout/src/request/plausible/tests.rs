use std::sync::Arc;

use bendtwin_core::Problem as _;
use bendtwin_engine::{backend::Diagnostics, world::Face};

use super::*;

const UP: Plane = Plane { normal: [0.0, 0.0, 1.0], offset_m: 0.0 };

/// A control point that falls by 0.2 m a frame from a height of 0.3 m, at 30 frames a second.
fn falling() -> Vec<Point> {
    (0..4).map(|f| [0.0, 0.0, 0.3 - 0.2 * f as f32]).collect()
}

#[test]
fn speeds_and_depths_are_those_of_the_worst_frame() {
    let obstacles = Obstacles { ground: Some(UP), shapes: Vec::new() };
    let mut path = falling();
    path[1][2] = 0.25;
    let of = |controls| Prescribed { start: &[[0.0, 0.0, 1.0]], controls, middles: &[], held: &[] };
    let found = extremes(0.0, of(&path), 3, 30.0, &obstacles);
    // From 0.25 to -0.1 m in frame 2; 0.3 m below the ground at the end of frame 3.
    assert!((found.speed.0 - 10.5).abs() < 1e-4 && found.speed.1 == 2, "{found:?}");
    assert!((found.depth.0 - 0.3).abs() < 1e-6 && found.depth.1 == 3, "{found:?}");
    // Other points count for the depth alone.
    let still = [[0.0, 0.0, 1.0]; 4];
    let middles = Prescribed { middles: &falling(), ..of(&still) };
    let found = extremes(0.0, middles, 3, 30.0, &obstacles);
    assert_eq!((found.speed, found.depth.1), ((0.0, 0), 3));
    // A held node counts from where it was taken on, and by how much deeper it gets.
    let points = vec![[0.0, 0.0, -0.01], [0.0, 0.0, -0.04]];
    let held = [Path { from: 2, points }];
    let found = extremes(0.0, Prescribed { held: &held, ..of(&still) }, 3, 30.0, &obstacles);
    assert!((found.depth.0 - 0.03).abs() < 1e-6 && found.depth.1 == 3, "{found:?}");
}

/// A hand that lies in the ground, as those of many captures do, moves there and goes deeper.
#[test]
fn control_points_count_by_how_much_deeper_they_get_than_they_were() {
    let obstacles = Obstacles { ground: Some(UP), shapes: Vec::new() };
    let deep = |z: [f32; 4]| z.map(|z| [0.0, 0.0, z]);
    let depth = |start: &[Point], z| {
        let of = Prescribed { start, controls: &deep(z), middles: &[], held: &[] };
        let (depth, frame) = extremes(0.0, of, 3, 30.0, &obstacles).depth;
        ((1e3 * depth).round(), frame)
    };
    let start = [[0.0, 0.0, -0.009]];
    assert_eq!(depth(&start, [-0.009; 4]), (0.0, 0));
    assert_eq!(depth(&start, [-0.009, 0.001, -0.004, -0.012]), (3.0, 3));
    // Actions that begin deeper than the state do not begin where it is.
    assert_eq!(depth(&[[0.0, 0.0, 0.1]], [-0.009, -0.009, 0.0, 0.0]), (9.0, 0));
    // The middle of a grasp has no place in the state.
    let controls = deep([0.0; 4]);
    let middles = deep([-0.009; 4]);
    let of = Prescribed { start: &start, controls: &controls, middles: &middles, held: &[] };
    assert!((extremes(0.0, of, 3, 30.0, &obstacles).depth.0 - 0.009).abs() < 1e-6);
}

#[test]
fn the_depth_in_a_shape_leaves_its_margin_out() {
    let face = |normal, offset_m| Face { normal, offset_m };
    let slab = vec![face([0.0, 0.0, 1.0], 0.11), face([0.0, 0.0, -1.0], 0.01)];
    let ball = Shape::Capsule { from: [1.0, 0.0, 0.0], to: [2.0, 0.0, 0.0], radius_m: 0.2 };
    let shapes = vec![(Shape::Convex(Arc::new(slab)), 0.01), (ball, 0.0)];
    let obstacles = Obstacles { ground: None, shapes };
    let depth = |p| obstacles.depth(p);
    assert!((depth([0.0, 0.0, 0.07]) - 0.03).abs() < 1e-6);
    assert!((depth([1.5, 0.15, 0.0]) - 0.05).abs() < 1e-6);
    assert!(depth([0.0, 0.0, 0.5]) < 0.0);
}

#[test]
fn what_is_beyond_a_limit_is_named_and_refused_if_asked() {
    let extremes =
        Extremes { start_gap_m: 0.05, speed: (9.0, 2), depth: (0.02, 3), ..Extremes::default() };
    let diagnostics = Diagnostics { max_strain: 1.5, ..Diagnostics::default() };
    let rollout = Rollout { diagnostics: Some(diagnostics), ..Rollout::default() };
    let forces = vec![(3.0, 5), (0.5, 2)];
    let extremes = Extremes { grasp_forces: forces, ..extremes };
    let limits = Plausibility::read(Some(Wire { grasp_force_n: Some(1.0), ..Wire::default() }));
    let found = limits.judge(7, &extremes, Some(&rollout));
    let reasons: Vec<&str> = found.iter().map(|f| f.reason.as_str()).collect();
    assert_eq!(
        reasons,
        ["START_GAP", "CONTROL_SPEED", "STRAIN", "CONTROL_IN_OBSTACLE", "GRASP_FORCE"]
    );
    assert_eq!((found[4].grasp, found[4].frame, found[4].found), (Some(0), 5, 3.0));
    assert!(found.iter().all(|f| f.instance == 7 && f.found > f.limit));
    assert!(limits.refuse(&found).is_ok());
    let strict = Plausibility::read(Some(Wire { refuse: true, ..Wire::default() }));
    for (i, advice) in
        ["where the state is", "more frames", "pull less", "lift its path", "grasp elsewhere"]
            .into_iter()
            .enumerate()
    {
        let error = strict.refuse(&found[i..=i]).unwrap_err();
        assert_eq!(error.reason(), "IMPLAUSIBLE_MOTION");
        assert!(error.to_string().contains(advice), "{error}");
    }
    assert!(limits.judge(0, &Extremes::default(), None).is_empty());
}
