//! The mean motion of the fits of a twin: its arrays, its costs and their gradients.

use bendtwin_core::{Point, geometry::point_distance};
use bendtwin_proto::v1::cost::Clearance;

use super::{
    fits::{FITS, on_fits, row, twin_with_members, with_spread},
    *,
};
use crate::tests::costs::varied;

/// The weights of the fits, whose losses are 1, 2 and 1 times the least.
const WEIGHTS: [f64; FITS] = [4.0 / 9.0, 1.0 / 9.0, 4.0 / 9.0];

fn twin() -> Twin {
    let mut twin = twin_with_members();
    twin.provenance.loss = Some(1e-3);
    (twin.members[0].loss, twin.members[1].loss) = (Some(2e-3), Some(1e-3));
    twin
}

/// The twin with a member that flies away.
fn with_a_lost_member() -> Twin {
    let mut twin = twin();
    twin.members[0].environment.gravity = [0.0, 0.0, 1e8];
    twin
}

/// A request for the mean motion, without forces, which a mean does not have.
fn of_mean(request: &RollOutRequest) -> RollOutRequest {
    let mut request = request.clone();
    request.ensemble.iter_mut().for_each(|e| e.set_statistic(Statistic::MeanPrediction));
    request.returns.iter_mut().for_each(|returns| returns.forces = false);
    request
}

fn weighted(rows: &[Vec<Point>], weights: &[f64]) -> Vec<Point> {
    let sum: f64 = weights.iter().sum();
    let of = |i: usize, axis: usize| {
        let parts = rows.iter().zip(weights).map(|(row, w)| w * f64::from(row[i][axis]));
        (parts.sum::<f64>() / sum) as f32
    };
    (0..rows[0].len()).map(|i| [0, 1, 2].map(|axis| of(i, axis))).collect()
}

fn assert_near(a: &[Point], b: &[Point]) {
    assert_eq!(a.len(), b.len());
    let apart = a.iter().zip(b).map(|(a, b)| point_distance(*a, *b)).fold(0.0, f64::max);
    assert!(apart < 1e-6, "{a:?} is not {b:?}");
}

fn u32s(tensor: &Option<Tensor>) -> Vec<u32> {
    tensor.as_ref().unwrap().unpack::<u32>("u").unwrap().1
}

#[test]
fn what_comes_back_is_the_weighted_mean_of_what_the_fits_do() {
    let bench = bench(twin());
    let mut request = on_fits(FITS as u32);
    request.returns.iter_mut().for_each(|returns| {
        (returns.velocities, returns.controls, returns.frame_costs) = (true, true, true);
    });
    let all = bench.run(request.clone(), 0).unwrap().remove(0);
    let part = bench.run(of_mean(&request), 0).unwrap().remove(0);
    let whole = [
        (&all.positions, &part.positions),
        (&all.velocities, &part.velocities),
        (&all.final_positions, &part.final_positions),
        (&all.final_velocities, &part.final_velocities),
    ];
    for (of_fits, of_mean) in whole {
        for action in 0..2 {
            let rows = [0, 1, 2].map(|fit| row(of_fits, action * FITS + fit));
            assert_near(&row(of_mean, action), &weighted(&rows, &WEIGHTS));
        }
        assert_eq!(of_mean.as_ref().unwrap().shape[0], 2);
    }
    // The cost is that of node 0 at the end of the mean motion.
    for action in 0..2 {
        let there = row(&part.final_positions, action)[0];
        let expected = point_distance(there, [0.06, 0.0, 0.5]);
        assert!((f64s(&part.costs)[action] - expected).abs() < 1e-6, "{expected}");
        let frames = &f64s(&part.frame_costs)[7 * action..7 * (action + 1)];
        assert_eq!(frames[6], f64s(&part.costs)[action]);
        assert!(frames[..6].iter().all(|cost| *cost == 0.0));
    }
    assert_ne!(part.costs, all.costs);
    assert_eq!(part.cost_terms.as_ref().unwrap().shape, [2, 1]);
    assert_eq!(part.member_costs, all.member_costs);
    assert_eq!(part.diagnostics, all.diagnostics);
    assert_eq!(u32s(&part.instances), [0, 3]);
    assert_eq!(row(&part.controls, 1), row(&all.controls, FITS));
}

#[test]
fn the_mean_of_one_fit_is_that_fit_bit_by_bit() {
    let bench = bench(twin());
    let mut request = on_fits(1);
    request.costs = varied();
    request.returns.iter_mut().for_each(|returns| {
        (returns.frame_costs, returns.forces, returns.velocities) = (true, false, true);
    });
    let alone = bench.run(request.clone(), 0).unwrap();
    assert_eq!(bench.run(of_mean(&request), 0).unwrap(), alone);
}

#[test]
fn members_that_differ_by_factors_have_equal_weights() {
    let bench = bench(twin());
    let mut request = on_fits(2);
    request.vary = Some(Vary { stiffness: factors(&[0.5, 2.0]), ..Vary::default() });
    let all = bench.run(request.clone(), 0).unwrap().remove(0);
    let part = bench.run(of_mean(&request), 0).unwrap().remove(0);
    let rows = [0, 1].map(|member| row(&all.positions, member));
    assert_near(&row(&part.positions, 0), &weighted(&rows, &[1.0, 1.0]));
}

#[test]
fn a_spread_is_of_the_members_and_what_comes_beside_it_of_the_mean() {
    let bench = bench(twin());
    let request = on_fits(FITS as u32);
    let spread = bench.run(with_spread(&request, 0), 0).unwrap().remove(0).spread;
    let mean = bench.run(of_mean(&request), 0).unwrap().remove(0);
    let both = bench.run(of_mean(&with_spread(&request, 0)), 0).unwrap().remove(0);
    assert_eq!(both.spread, spread);
    assert_eq!((both.positions, both.final_positions), (mean.positions, mean.final_positions));
}

#[test]
fn skin_and_chosen_nodes_are_those_of_the_mean() {
    let bench = bench(twin());
    let mut request = of_mean(&on_fits(FITS as u32));
    let all = bench.run(request.clone(), 0).unwrap().remove(0);
    request.returns = Some(Returns {
        every_frames: 3,
        point_set: bendtwin_proto::v1::PointSet::Skin.into(),
        skin_points: Some(Tensor::pack(&[2], &[3u32, 1])),
        ..Returns::default()
    });
    let skin = bench.run(request.clone(), 0).unwrap().remove(0);
    request.costs.clear();
    request.returns = Some(Returns {
        every_frames: 3,
        nodes: Some(Tensor::pack(&[2], &[3u32, 1])),
        ..Returns::default()
    });
    let nodes = bench.run(request, 0).unwrap().remove(0);
    // Its skin is its nodes.
    assert_near(&points(&skin.positions), &points(&nodes.positions));
    let chosen: Vec<Point> =
        points(&all.positions).chunks(4).flat_map(|nodes| [nodes[3], nodes[1]]).collect();
    assert_near(&points(&nodes.positions), &chosen);
}

#[test]
fn the_best_are_those_whose_mean_motion_costs_least() {
    let bench = bench(twin());
    let mut request = of_mean(&on_fits(FITS as u32));
    let all = bench.run(request.clone(), 0).unwrap().remove(0);
    let parts = bench.run(request.clone(), 1).unwrap();
    let costs: Vec<f64> = parts.iter().flat_map(|part| f64s(&part.costs)).collect();
    assert_eq!(costs, f64s(&all.costs));
    assert_eq!(parts.iter().map(|part| part.first_instance).collect::<Vec<_>>(), [0, 1]);
    let lowest = usize::from(costs[1] < costs[0]);
    request.returns.iter_mut().for_each(|returns| returns.best = 1);
    let best = bench.run(request, 0).unwrap().remove(0);
    assert_eq!(points(&best.positions), row(&all.positions, lowest));
    assert_eq!(u32s(&best.instances), [(lowest * FITS) as u32]);
}

#[test]
fn a_fit_that_diverged_has_no_part_in_the_mean() {
    let lost = bench(with_a_lost_member());
    let request = on_fits(FITS as u32);
    let all = lost.run(request.clone(), 0).unwrap().remove(0);
    assert!(f64s(&all.costs).iter().all(|cost| cost.is_infinite()), "the mean of the costs");
    let mut of_mean = of_mean(&request);
    of_mean.returns.iter_mut().for_each(|returns| returns.control_gradients = true);
    let part = lost.run(of_mean.clone(), 0).unwrap().remove(0);
    assert_eq!(part.diverged.iter().map(|d| d.instance).collect::<Vec<_>>(), [1, 4]);
    assert_eq!(part.diverged, all.diverged);
    let rows = [0, 2].map(|fit| row(&all.positions, fit));
    assert_near(&row(&part.positions, 0), &weighted(&rows, &[4.0, 4.0]));
    assert!(f64s(&part.costs).iter().all(|cost| cost.is_finite()));
    assert_eq!(f64s(&part.member_costs)[1], f64::INFINITY);
    assert!(floats(&part.control_gradients).iter().all(|x| x.is_finite()));

    // With no fit left there is no mean.
    let mut twin = with_a_lost_member();
    twin.environment.gravity = [0.0, 0.0, 1e8];
    twin.members.truncate(1);
    of_mean.ensemble.iter_mut().for_each(|ensemble| ensemble.members = 2);
    let part = bench(twin).run(of_mean, 0).unwrap().remove(0);
    assert!(f64s(&part.costs).iter().all(|cost| *cost == f64::INFINITY));
    assert!(points(&part.positions).iter().flatten().all(|x| x.is_nan()));
    assert!(floats(&part.control_gradients).iter().all(|x| x.is_nan()));
}

#[test]
fn gradients_of_a_mean_agree_with_differences_of_its_costs() {
    let bench = bench(twin());
    let start: Vec<Point> =
        (0..7).map(|f| [0.02 * f as f32, 0.003 * (f * f) as f32, 0.6 - 0.004 * f as f32]).collect();
    let smooth = Kind::Smoothness(Smoothness {});
    let smooth = Cost { when: When::EveryFrame.into(), kind: Some(smooth), ..Cost::default() };
    let at = |controls: &[Point]| {
        let positions = Some(Tensor::pack_points(&[1, 7, 1], controls));
        let trajectories = ControlTrajectories { positions, interpolation: 0 };
        let mut request = on_fits(FITS as u32);
        request.actions = Some(Actions::Trajectories(trajectories));
        request.costs = varied();
        request.costs.push(smooth.clone());
        request.returns = None;
        of_mean(&request)
    };
    for best in [0, 1] {
        let mut request = at(&start);
        request.returns = Some(Returns {
            control_gradients: true,
            action_gradients: true,
            initial_gradients: true,
            gradient_norms: true,
            best,
            ..Returns::default()
        });
        let part = bench.run(request, 0).unwrap().remove(0);
        let gradient = floats(&part.control_gradients);
        assert_eq!(gradient.len(), 21);
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
        assert_eq!(floats(&part.action_gradients), gradient, "knots in every frame");
        assert!(f64s(&part.gradient_norms).iter().all(|norm| *norm > 0.0));
        assert_eq!(part.initial_velocity_gradients.as_ref().unwrap().shape, [1, 4, 3]);
    }
}

/// The gradient by a gripper's poses of a cost that counts its distance is not in the motion alone.
#[test]
fn gradients_of_a_mean_reach_the_colliders_in_its_costs() {
    let bench = bench(twin());
    let sphere = Sphere { center: vec![0.05, 0.0, -0.2], radius_m: 0.02 };
    let collider = Collider {
        shape: Some(collider::Shape::Sphere(sphere)),
        carrier: Some(collider::Carrier::Gripper(0)),
        ..Collider::default()
    };
    let clearance = Kind::Clearance(Clearance { collider: 0, margin_m: 0.2 });
    let values = [
        0.0, 0.0, 0.6, 0.1, 0.0, 0.0, 1.0, //
        0.02, 0.0, 0.61, 0.2, 0.1, 0.0, 1.0, //
        0.03, 0.01, 0.6, 0.2, 0.2, 0.1, 1.0f32,
    ];
    let at = |values: &[f32]| {
        let poses = Some(Tensor::pack(&[1, 3, 1, 7], values));
        let mut request = of_mean(&on_fits(FITS as u32));
        request.actions = Some(Actions::Poses(GripperPoses { poses, ..GripperPoses::default() }));
        request.world = Some(World { colliders: vec![collider.clone()], ..World::default() });
        request.costs = vec![Cost {
            when: When::EveryFrame.into(),
            kind: Some(clearance.clone()),
            ..Cost::default()
        }];
        request.returns = Some(Returns { action_gradients: true, ..Returns::default() });
        request
    };
    let part = bench.run(at(&values), 0).unwrap().remove(0);
    let gradient = floats(&part.action_gradients);
    let scale = gradient.iter().fold(0.0f32, |m, g| m.max(g.abs()));
    assert!(scale > 1e-4, "{scale}");
    for (i, found) in gradient.iter().enumerate() {
        let moved = |by: f32| {
            let mut values = values;
            values[i] += by;
            f64s(&bench.run(at(&values), 0).unwrap()[0].costs)[0]
        };
        let expected = (moved(1e-3) - moved(-1e-3)) / 2e-3;
        let error = (f64::from(*found) - expected).abs();
        assert!(error < 0.02 * f64::from(scale), "{i}: {found} {expected} of {scale}");
    }
}

#[test]
fn quantities_without_a_mean_are_refused() {
    let mut request = of_mean(&on_fits(FITS as u32));
    request.returns.iter_mut().for_each(|returns| returns.forces = true);
    let error = bench(twin()).run(request, 0).unwrap_err().to_string();
    assert!(error.contains("returns.forces") && error.contains("MEAN_PREDICTION"), "{error}");
}

#[test]
fn a_mean_is_no_larger_than_the_check_says() {
    let twin = twin();
    let mut request = of_mean(&on_fits(FITS as u32));
    request.costs = varied();
    request.returns.iter_mut().for_each(|returns| {
        (returns.velocities, returns.frame_costs, returns.action_gradients) = (true, true, true);
    });
    let shape = crate::shape(&twin, false);
    let batch = bendtwin_contract::rollout::check_for(&request, &shape, &limits(), 0).unwrap();
    let most = bendtwin_contract::rollout::reply_bytes(&request, &batch, &shape, 0);
    let part = bench(twin).run(request, 0).unwrap().remove(0);
    let bytes = prost::Message::encoded_len(&part) as u64;
    assert!(bytes <= most && most < 2 * bytes, "{bytes} of {most}");
}
