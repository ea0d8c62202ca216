//! Costs at the skin of a twin, and recordings of it.

use bendtwin_core::geometry::{distance, wide};
use bendtwin_proto::v1::PointSet;

use super::*;

type Point = [f32; 3];

/// Two triangles that hang from the control point, with a skin of five points: a node, points between
/// nodes, and offsets along the axes of the world and of frames.
fn clothed() -> Twin {
    let mut twin = twin();
    let graph = &mut twin.graph;
    graph.rest_positions =
        vec![[0.0, 0.0, 0.5], [-0.05, 0.0, 0.41], [0.05, 0.0, 0.41], [0.0, 0.03, 0.32]];
    graph.springs = vec![[0, 4], [1, 0], [2, 0], [2, 1], [3, 1], [3, 2]];
    graph.triplets.clear();
    let ends = graph.springs.iter().map(|s| s.map(|i| wide(graph.rest_endpoint(i))));
    let rest_lengths_m = ends.map(|[a, b]| distance(a, b) as f32).collect();
    twin.params = Params {
        rest_lengths_m,
        spring_stiffness: vec![500.0; 6],
        spring_dashpot: vec![1.0; 6],
        bend_stiffness: Vec::new(),
        bend_damping: Vec::new(),
        rest_angles_rad: Vec::new(),
        ..twin.params
    };
    let none = [Skin::NO_FRAME; 3];
    twin.skin = Skin::default();
    twin.skin.push(0, &[(0, 1.0)], none, [0.0; 3]);
    twin.skin.push(7, &[(0, 0.5), (1, 0.5)], none, [0.01, 0.0, 0.0]);
    twin.skin.push(8, &[(1, 0.25), (2, 0.75)], [0, 1, 2], [0.01, 0.02, -0.03]);
    twin.skin.push(Graph::NOT_OBSERVED, &[(2, 1.5), (3, -0.5)], [1, 2, 3], [0.0, 0.0, 0.02]);
    twin.skin.push(9, &[(3, 1.0)], none, [0.0; 3]);
    twin.check().unwrap();
    twin
}

fn bench() -> Bench {
    Bench::of(clothed(), bendtwin_engine::cpu_with_threads(2))
}

/// Instances that return positions and velocities of every second frame.
fn recording(point_set: PointSet) -> RollOutRequest {
    let returns = Returns {
        every_frames: 2,
        velocities: true,
        point_set: point_set.into(),
        ..Returns::default()
    };
    RollOutRequest { returns: Some(returns), ..request(3) }
}

fn points(tensor: &Option<Tensor>) -> (Vec<usize>, Vec<Point>) {
    tensor.as_ref().unwrap().unpack_points("t").unwrap()
}

#[test]
fn the_returned_skin_is_placed_from_the_returned_nodes() {
    let (bench, skin) = (bench(), clothed().skin);
    let of_nodes = bench.run(recording(PointSet::Nodes), 0).unwrap().remove(0);
    let (shape, nodes) = points(&of_nodes.positions);
    assert_eq!(shape, [3, 3, 4]);
    let (_, velocities) = points(&of_nodes.velocities);
    let some: &[u32] = &[4, 2, 2];
    for chosen in [None, Some(some)] {
        let mut request = recording(PointSet::Skin);
        request.returns.as_mut().unwrap().skin_points =
            chosen.map(|points| Tensor::pack(&[points.len()], points));
        let part = bench.run(request, 0).unwrap().remove(0);
        let chosen = chosen.unwrap_or(&[0, 1, 2, 3, 4]);
        let pick = |all: &[Point]| -> Vec<Point> {
            chosen.iter().map(|point| all[*point as usize]).collect()
        };
        let expected: Vec<Point> =
            nodes.chunks(4).flat_map(|nodes| pick(&skin.positions(nodes))).collect();
        assert_eq!(points(&part.positions), (vec![3, 3, chosen.len()], expected));
        let frames = nodes.chunks(4).zip(velocities.chunks(4));
        let expected: Vec<Point> = frames
            .flat_map(|(nodes, velocities)| {
                let at = |i: u32| wide(nodes[i as usize]);
                let velocity = |i: u32| wide(velocities[i as usize]);
                let of = |point| skin.velocity(point, at, velocity).map(|x| x as f32);
                pick(&(0..5).map(of).collect::<Vec<_>>())
            })
            .collect();
        assert_eq!(points(&part.velocities), (vec![3, 3, chosen.len()], expected));
    }
}

#[test]
fn the_skin_of_parts_is_that_of_the_whole() {
    let bench = bench();
    let mut request = recording(PointSet::Skin);
    request.returns.as_mut().unwrap().skin_points = Some(Tensor::pack(&[2], &[3u32, 1]));
    let smooth = Cost { kind: Some(Kind::Smoothness(Smoothness {})), ..Cost::default() };
    for costs in [vec![keypoint_cost(0.06)], vec![smooth]] {
        request.costs = costs;
        let whole = bench.run(request.clone(), 0).unwrap().remove(0);
        for part_frames in [0, 2, 4] {
            request.returns.as_mut().unwrap().part_frames = part_frames;
            let parts = bench.run(request.clone(), 1).unwrap();
            for (i, expected) in points(&whole.positions).1.chunks(6).enumerate() {
                let own = parts.iter().filter(|part| part.first_instance as usize == i);
                let found: Vec<Point> = own.flat_map(|part| points(&part.positions).1).collect();
                assert_eq!(found, expected, "instance {i} in parts of {part_frames}");
            }
        }
        request.returns.as_mut().unwrap().part_frames = 0;
    }
}

#[test]
fn a_skin_of_a_diverged_instance_is_not_a_number_from_there_on() {
    let bench = bench();
    let mut request = recording(PointSet::Skin);
    let far = [[0.0, 0.0, 0.6], [0.0, 0.0, 0.6], [0.0, 0.0, 0.6], [1e9f32, 0.0, 0.6]];
    let positions = Some(Tensor::pack(&[2, 2, 1, 3], far.as_flattened()));
    let trajectories = ControlTrajectories { positions, interpolation: 0 };
    request.actions = Some(Actions::Trajectories(trajectories));
    let part = bench.run(request, 0).unwrap().remove(0);
    assert_eq!(part.diverged.len(), 1);
    let (shape, positions) = points(&part.positions);
    assert_eq!(shape, [2, 3, 5]);
    assert!(positions[..15].as_flattened().iter().all(|x| x.is_finite()));
    assert!(positions[25..].as_flattened().iter().all(|x| x.is_nan()));
}

const TARGETS: [Point; 3] = [[0.03, 0.01, 0.42], [0.02, 0.0, 0.3], [0.05, 0.02, 0.2]];

fn cloud(point_set: PointSet) -> Cost {
    let points = Some(Tensor::pack_points(&[TARGETS.len()], &TARGETS));
    let cloud = TargetCloud { points, point_set: point_set.into() };
    Cost { kind: Some(Kind::TargetCloud(cloud)), ..Cost::default() }
}

fn skin_keypoints(of: [u32; 3], squared: bool) -> Cost {
    let keypoints = Keypoints {
        skin_points: Some(Tensor::pack(&[3], &of)),
        targets: Some(Tensor::pack_points(&[3], &TARGETS)),
        squared,
        ..Keypoints::default()
    };
    Cost { kind: Some(Kind::Keypoints(keypoints)), ..Cost::default() }
}

#[test]
fn costs_at_the_skin_are_what_they_say() {
    let bench = bench();
    let mut request = recording(PointSet::Skin);
    request.costs = vec![
        cloud(PointSet::Unspecified),
        Cost { name: "skin".into(), ..cloud(PointSet::Skin) },
        Cost { name: "nodes".into(), ..cloud(PointSet::Nodes) },
        skin_keypoints([3, 2, 4], false),
    ];
    let part = bench.run(request.clone(), 0).unwrap().remove(0);
    let skin = points(&part.positions).1;
    request.returns.as_mut().unwrap().point_set = PointSet::Nodes.into();
    let nodes = points(&bench.run(request, 0).unwrap()[0].positions).1;
    let terms = f64s(&part.cost_terms);
    for instance in 0..3 {
        // The last of three recorded frames.
        let at = |all: &[Point], width: usize| -> Vec<Point> {
            all[(3 * instance + 2) * width..][..width].to_vec()
        };
        let nearest = |points: &[Point]| {
            let each = TARGETS.iter().map(|target| {
                let distances = points.iter().map(|p| distance(wide(*p), wide(*target)));
                distances.fold(f64::INFINITY, f64::min).powi(2)
            });
            each.sum::<f64>() / 3.0
        };
        let (skin, nodes) = (at(&skin, 5), at(&nodes, 4));
        let tracked = [3, 2, 4].iter().zip(TARGETS);
        let tracked = tracked.map(|(point, t)| distance(wide(skin[*point]), wide(t))).sum::<f64>();
        let expected = [nearest(&skin), nearest(&skin), nearest(&nodes), tracked / 3.0];
        for (found, expected) in terms[4 * instance..][..4].iter().zip(expected) {
            assert!((found - expected).abs() < 1e-6 * expected, "{found} instead of {expected}");
        }
        assert!((expected[0] - expected[2]).abs() > 0.01 * expected[0]);
    }
}

#[test]
fn gradients_of_costs_at_the_skin_agree_with_differences() {
    const KNOTS: [f32; 9] = [0.0, 0.0, 0.6, 0.02, 0.03, 0.61, 0.05, 0.02, 0.6];
    let bench = bench();
    for cost in [cloud(PointSet::Skin), skin_keypoints([3, 2, 1], true)] {
        let asked = |knots: [f32; 9], action_gradients: bool| {
            let positions = Some(Tensor::pack(&[1, 3, 1, 3], &knots));
            let trajectories = ControlTrajectories { positions, interpolation: 0 };
            let mut asked = request(1);
            asked.actions = Some(Actions::Trajectories(trajectories));
            // Enough frames for the chain to follow.
            asked.frames = 20;
            asked.costs = vec![Cost { when: When::EveryFrame.into(), ..cost.clone() }];
            asked.returns = Some(Returns { action_gradients, ..Returns::default() });
            bench.run(asked, 0).unwrap().remove(0)
        };
        let gradient = asked(KNOTS, true).action_gradients.unwrap().unpack::<f32>("g").unwrap().1;
        let scale = gradient.iter().fold(0.0f32, |most, g| most.max(g.abs()));
        assert!(scale > 0.0);
        for (i, found) in gradient.iter().enumerate() {
            let moved = |by: f32| {
                let mut knots = KNOTS;
                knots[i] += by;
                f64s(&asked(knots, false).costs)[0]
            };
            let expected = (moved(5e-4) - moved(-5e-4)) / 1e-3;
            let error = (f64::from(*found) - expected).abs();
            assert!(error < 0.01 * f64::from(scale), "{i}: {found} instead of {expected}");
        }
    }
}
