//! Order, winding and coverage: from the message to the value.

use std::f64::consts::TAU;

use bendtwin_core::Point;
use bendtwin_proto::v1::{
    PointSet,
    cost::{
        Coverage, Order, Winding,
        winding::{Around, Axis},
    },
};

use super::*;

fn list(points: &[u32]) -> Option<Tensor> {
    Some(Tensor::pack(&[points.len()], points))
}

fn cost(kind: Kind) -> Cost {
    Cost { kind: Some(kind), ..Cost::default() }
}

/// The end of the chain, whose skin are its nodes, after it has fallen for five frames; and its costs.
fn ended(costs: Vec<Cost>, world: World) -> (Vec<Point>, Vec<f64>) {
    let mut request = still([0.0, 0.0, 0.6], 5);
    (request.costs, request.world) = (costs, Some(world));
    request.returns = recording(0);
    let part = bench(chain(0.3)).run(request, 0).unwrap().remove(0);
    (points(&part.final_positions), f64s(&part.cost_terms))
}

const ALONG: Point = [0.6, 0.0, 0.8];

fn order(skin_points: bool) -> Cost {
    let points = list(&[0, 2, 1, 5]);
    let (nodes, skin_points) = if skin_points { (None, points) } else { (points, None) };
    cost(Kind::Order(Order { nodes, direction: ALONG.to_vec(), gap_m: 0.02, skin_points }))
}

fn winding(around: Around, skin_points: bool) -> Cost {
    let points = list(&[0, 1, 3, 5]);
    let (nodes, skin_points) = if skin_points { (None, points) } else { (points, None) };
    cost(Kind::Winding(Winding { nodes, around: Some(around), turns: 0.5, skin_points }))
}

/// A line along y beside the middle of the chain.
fn beside() -> Around {
    Around::Axis(Axis { point: vec![0.22, 9.0, 0.1], direction: vec![0.0, 1.0, 0.0] })
}

fn coverage(point_set: PointSet) -> Cost {
    let cloud = [[0.0, 0.0, 0.2], [0.31, 0.02, 0.2], [0.5, 0.0, 0.0]];
    let points = Some(Tensor::pack_points(&[3], &cloud));
    cost(Kind::Coverage(Coverage { points, reach_m: 0.1, point_set: point_set.into() }))
}

#[test]
fn costs_of_tasks_are_as_defined_at_nodes_and_at_the_skin() {
    let costs = vec![
        order(false),
        order(true),
        winding(beside(), false),
        winding(beside(), true),
        coverage(PointSet::Nodes),
        coverage(PointSet::Unspecified),
    ];
    let (end, terms) = ended(costs, World::default());
    let along = |i: usize| (0..3).map(|k| f64::from(end[i][k] * ALONG[k])).sum::<f64>();
    let lack = |pair: [usize; 2]| (0.02 - (along(pair[1]) - along(pair[0]))).max(0.0).powi(2);
    let order = [[0, 2], [2, 1], [1, 5]].map(lack).iter().sum::<f64>() / 3.0;
    // Counter-clockwise seen against y is from z to x.
    let angle = |i: usize| f64::from(end[i][0] - 0.22).atan2(f64::from(end[i][2] - 0.1));
    let turns = (angle(5) - angle(0)) / TAU;
    let uncovered = |target: Point| {
        let square = |x: &Point| (0..3).map(|k| f64::from(x[k] - target[k]).powi(2)).sum::<f64>();
        let nearest = end.iter().map(square).fold(f64::MAX, f64::min);
        1.0 - (-nearest / (2.0 * 0.1f64.powi(2))).exp()
    };
    let cloud = [[0.0, 0.0, 0.2], [0.31, 0.02, 0.2], [0.5, 0.0, 0.0]];
    let expected =
        [order, (turns - 0.5).powi(2), cloud.into_iter().map(uncovered).sum::<f64>() / 3.0];
    for (i, term) in terms.iter().enumerate() {
        let expected = expected[i / 2];
        assert!(expected > 1e-3, "{i}: {expected}");
        assert!((term - expected).abs() < 1e-4 * expected, "{i}: {term} is not {expected}");
    }
}

/// The capsule's ends are at y = -1 and 1 once its pose has turned them from x to y.
#[test]
fn a_capsule_winds_around_its_axis_at_its_pose() {
    let half = std::f32::consts::FRAC_1_SQRT_2;
    let capsule = Capsule { from: vec![-1.0, 0.0, 0.0], to: vec![1.0, 0.0, 0.0], radius_m: 0.01 };
    let collider = Collider {
        shape: Some(collider::Shape::Capsule(capsule)),
        pose: vec![0.22, 0.0, 0.1, 0.0, 0.0, half, half],
        ..Collider::default()
    };
    let world = World { colliders: vec![collider], ..World::default() };
    let costs = vec![winding(Around::Collider(0), false), winding(beside(), false)];
    let (_, terms) = ended(costs, world);
    assert!(terms[0] > 1e-3 && (terms[0] - terms[1]).abs() < 1e-6, "{terms:?}");
}

#[test]
fn gradients_of_tasks_agree_with_differences() {
    let bench = Bench::new();
    let start: Vec<Point> =
        (0..7).map(|f| [0.02 * f as f32, 0.003 * (f * f) as f32, 0.6 - 0.004 * f as f32]).collect();
    let at = |controls: &[Point]| {
        let positions = Some(Tensor::pack_points(&[1, 7, 1], controls));
        let trajectories = ControlTrajectories { positions, interpolation: 0 };
        let direction = vec![0.6, 0.0, 0.8];
        let order = Order { nodes: list(&[0, 1, 3]), direction, gap_m: 0.05, skin_points: None };
        let axis = Axis { point: vec![0.3, 0.1, 0.4], direction: vec![0.0, 1.0, 0.0] };
        let around = Some(Around::Axis(axis));
        let winding = Winding { nodes: list(&[3, 2, 0]), around, turns: 0.4, skin_points: None };
        let points = Some(Tensor::pack_points(&[2], &[[0.03, 0.0, 0.5], [0.1, 0.02, 0.21]]));
        let coverage = Coverage { points, reach_m: 0.1, point_set: PointSet::Nodes.into() };
        let kinds = [Kind::Order(order), Kind::Winding(winding), Kind::Coverage(coverage)];
        let whens = [When::EveryFrame, When::SoftMin, When::LastFrame];
        let costs = kinds.into_iter().zip(whens).map(|(kind, when)| Cost {
            when: when.into(),
            temperature: 1e-3,
            // A condition has no gradient.
            success_at_most: Some(0.01),
            ..cost(kind)
        });
        RollOutRequest {
            actions: Some(Actions::Trajectories(trajectories)),
            costs: costs.collect(),
            ..request(1)
        }
    };
    let mut request = at(&start);
    request.returns = Some(Returns { control_gradients: true, ..Returns::default() });
    let part = bench.run(request, 0).unwrap().remove(0);
    assert!(f64s(&part.cost_terms).iter().all(|term| *term > 1e-4), "{:?}", f64s(&part.cost_terms));
    let gradient = floats(&part.control_gradients);
    let scale = gradient.iter().fold(0.0f32, |m, g| m.max(g.abs()));
    for (i, found) in gradient.iter().enumerate() {
        let moved = |by: f32| {
            let mut controls = start.clone();
            controls.as_flattened_mut()[i] += by;
            f64s(&bench.run(at(&controls), 0).unwrap()[0].costs)[0]
        };
        let expected = (moved(5e-4) - moved(-5e-4)) / 1e-3;
        let error = (f64::from(*found) - expected).abs();
        assert!(error < 0.02 * f64::from(scale), "{i}: {found} {expected} of {scale}");
    }
}
