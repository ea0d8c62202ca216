//! Returned costs: by frame, by instance, soft minima, controls, gradients.

use bendtwin_proto::v1::cost::{ControlPath, ControlSpeed, Height, Strain, Within};
use bendtwin_proto::v1::{Cuboid, Plane};

use super::*;

fn f32s(tensor: &Option<Tensor>) -> Vec<f32> {
    tensor.as_ref().unwrap().unpack::<f32>("t").unwrap().1
}

/// A cost of the distance of node 3 to targets of this shape, a point each.
fn follow(shape: &[usize], x: impl Fn(usize) -> f32) -> Cost {
    let targets: Vec<Point> =
        (0..shape.iter().product()).map(|i| [x(i), 0.0, 0.2 + 0.01 * i as f32]).collect();
    let keypoints = Keypoints {
        nodes: Some(Tensor::pack(&[1], &[3u32])),
        targets: Some(Tensor::pack_points(shape, &targets)),
        squared: true,
        skin_points: None,
    };
    Cost {
        when: When::EveryFrame.into(),
        kind: Some(Kind::Keypoints(keypoints)),
        ..Cost::default()
    }
}

type Point = [f32; 3];

/// Every kind that needs no world, at every time.
pub(super) fn varied() -> Vec<Cost> {
    let plane = Plane { normal: vec![0.0, 0.6, 0.8], offset_m: 0.3 };
    let cuboid = Some(Cuboid { low: vec![-0.01, -0.01, 0.3], high: vec![0.01, 0.01, 0.4] });
    let nodes = Some(Tensor::pack(&[2], &[1u32, 2]));
    let kinds = [
        Kind::Strain(Strain { limit: 0.001 }),
        Kind::Height(Height { plane: Some(plane), nodes: None }),
        Kind::Within(Within { cuboid, nodes }),
        Kind::ControlPath(ControlPath {}),
        Kind::ControlSpeed(ControlSpeed { limit_m_s: 0.05 }),
    ];
    let mut costs: Vec<Cost> = kinds
        .into_iter()
        .enumerate()
        .map(|(i, kind)| Cost {
            weight: Some([3.0, 2.0, -1.5, 0.2, 0.1][i]),
            when: [When::EveryFrame, When::SoftMin, When::LastFrame][i % 3].into(),
            temperature: 1e-3,
            kind: Some(kind),
            ..Cost::default()
        })
        .collect();
    costs.push(Cost {
        when: When::SoftMin.into(),
        temperature: 2e-4,
        ..follow(&[6, 1], |i| 0.01 * i as f32)
    });
    costs
}

#[test]
fn costs_by_frame_make_up_those_of_whole_rollouts() {
    let bench = Bench::new();
    let mut request = request(3);
    request.costs = varied();
    request.returns = Some(Returns { frame_costs: true, ..Returns::default() });
    let part = bench.run(request, 0).unwrap().remove(0);
    assert_eq!(part.frame_costs.as_ref().unwrap().shape, [3, 7, 6]);
    let (frames, terms, costs) =
        (f64s(&part.frame_costs), f64s(&part.cost_terms), f64s(&part.costs));
    for b in 0..3 {
        for t in 0..6 {
            let own: Vec<f64> = (0..7).map(|f| frames[(b * 7 + f) * 6 + t]).collect();
            let expected = match t {
                1 | 5 => {
                    let (weight, temperature) = if t == 1 { (2.0, 1e-3) } else { (1.0, 2e-4) };
                    let mean = own[1..].iter().map(|c| (-c / weight / temperature).exp());
                    -weight * temperature * (mean.sum::<f64>() / 6.0).ln()
                }
                _ => own.iter().sum::<f64>(),
            };
            let found = terms[b * 6 + t];
            assert!((found - expected).abs() < 1e-9 * (1.0 + expected.abs()), "{b} {t}: {found}");
            assert!(b == 0 && (t == 3 || t == 4) || found != 0.0, "{b} {t} is zero");
        }
        let sum: f64 = terms[b * 6..(b + 1) * 6].iter().sum();
        assert!((costs[b] - sum).abs() < 1e-12);
    }
}

#[test]
fn gradients_of_all_costs_agree_with_differences() {
    let bench = Bench::new();
    let start: Vec<Point> =
        (0..7).map(|f| [0.02 * f as f32, 0.003 * (f * f) as f32, 0.6 - 0.004 * f as f32]).collect();
    let at = |controls: &[Point]| {
        let positions = Some(Tensor::pack_points(&[1, 7, 1], controls));
        let trajectories = ControlTrajectories { positions, interpolation: 0 };
        RollOutRequest {
            actions: Some(Actions::Trajectories(trajectories)),
            costs: varied(),
            ..request(1)
        }
    };
    for best in [0, 1] {
        let mut request = at(&start);
        request.returns = Some(Returns {
            control_gradients: true,
            initial_gradients: true,
            gradient_norms: true,
            best,
            ..Returns::default()
        });
        let part = bench.run(request, 0).unwrap().remove(0);
        let gradient = f32s(&part.control_gradients);
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
        let norms = f64s(&part.gradient_norms);
        let by_start = f32s(&part.initial_position_gradients);
        let norm = by_start.iter().map(|g| f64::from(*g).powi(2)).sum::<f64>().sqrt();
        assert!((norms[0] - norm).abs() < 1e-4 * norm && norm > 0.0, "{norms:?} {norm}");
        assert_eq!(part.initial_velocity_gradients.as_ref().unwrap().shape, [1, 4, 3]);
        let exploded = part.gradient_exploded.as_ref().unwrap().unpack::<u32>("e").unwrap().1;
        assert_eq!(exploded, [0]);
    }
}

#[test]
fn targets_by_instance_and_frame_are_those_of_separate_requests() {
    let bench = Bench::new();
    let x = |i: usize| 0.013 * i as f32;
    let mut together = request(2);
    together.costs = vec![follow(&[2, 6, 1], x), follow(&[2, 1, 1], x), follow(&[6, 1], x)];
    together.returns = Some(Returns { control_gradients: true, ..Returns::default() });
    let all = bench.run(together.clone(), 0).unwrap().remove(0);
    let (costs, gradients) = (f64s(&all.costs), f32s(&all.control_gradients));
    for b in 0..2 {
        let mut alone = together.clone();
        let knots = [[0.0, 0.0, 0.6], [0.02 * b as f32, 0.0, 0.6]];
        alone.actions = Some(Actions::Trajectories(ControlTrajectories {
            positions: Some(Tensor::pack_points(&[1, 2, 1], &knots)),
            interpolation: 0,
        }));
        let own = |count: usize, first: usize| {
            let Some(Kind::Keypoints(all)) = follow(&[2, count], x).kind else { unreachable!() };
            let (_, points) = all.targets.unwrap().unpack_points("t").unwrap();
            let targets = Some(Tensor::pack_points(&[count, 1], &points[first..first + count]));
            let nodes = Some(Tensor::pack(&[1], &[3u32]));
            let kind =
                Kind::Keypoints(Keypoints { nodes, targets, squared: true, skin_points: None });
            Cost { kind: Some(kind), ..follow(&[1], x) }
        };
        let mut fixed = own(1, b);
        if let Some(Kind::Keypoints(k)) = &mut fixed.kind {
            k.targets = k.targets.take().map(|t| Tensor { shape: vec![1, 3], ..t });
        }
        alone.costs = vec![own(6, 6 * b), fixed, follow(&[6, 1], x)];
        let part = bench.run(alone, 0).unwrap().remove(0);
        assert_eq!(f64s(&part.costs), costs[b..=b]);
        assert_eq!(f32s(&part.control_gradients), gradients[21 * b..21 * (b + 1)]);
    }
    assert_ne!(costs[0], costs[1]);
}

#[test]
fn velocities_and_controls_come_back() {
    let bench = Bench::new();
    let mut request = request(2);
    request.returns = Some(Returns {
        every_frames: 1,
        velocities: true,
        controls: true,
        final_state: true,
        ..Returns::default()
    });
    let part = bench.run(request.clone(), 0).unwrap().remove(0);
    assert_eq!(part.velocities.as_ref().unwrap().shape, [2, 6, 4, 3]);
    let (velocities, last) = (f32s(&part.velocities), f32s(&part.final_velocities));
    assert_eq!(velocities[60..72], last[..12]);
    assert_eq!(velocities[132..], last[12..]);
    assert_ne!(velocities[48..60], last[..12]);
    let controls = f32s(&part.controls);
    assert_eq!(part.controls.as_ref().unwrap().shape, [2, 7, 1, 3]);
    assert_eq!(controls[21 + 18..], f32s(&part.final_controls)[3..]);
    assert!((controls[21 + 18] - 0.02).abs() < 1e-6);
    // Of the best alone: instance 1, which comes nearer to the target.
    request.returns = Some(Returns { best: 1, ..request.returns.unwrap() });
    let best = bench.run(request, 0).unwrap().remove(0);
    assert_eq!(f32s(&best.controls), controls[21..]);
    assert_eq!(f32s(&best.velocities), velocities[72..]);
}

#[test]
fn what_is_not_known_of_a_diverged_instance_is_no_number() {
    let bench = Bench::new();
    let mut request = request(1);
    let rest = bench.warm.twin.graph.rest_positions.clone();
    let fast = vec![[0.0, 1e5, 0.0f32]; 4];
    request.initial = Some(InitialState {
        state: Some(State::Given(GivenState {
            positions: Some(Tensor::pack_points(&[4], &rest)),
            velocities: Some(Tensor::pack_points(&[4], &fast)),
            ..GivenState::default()
        })),
    });
    request.costs = varied();
    request.costs[2].weight = Some(-1e6);
    request.returns = Some(Returns {
        every_frames: 1,
        velocities: true,
        diagnostics: true,
        frame_costs: true,
        control_gradients: true,
        action_gradients: true,
        initial_gradients: true,
        gradient_norms: true,
        ..Returns::default()
    });
    let part = bench.run(request, 0).unwrap().remove(0);
    assert_eq!(part.diverged.len(), 1);
    assert_eq!(f64s(&part.costs), [f64::INFINITY]);
    let arrays = [
        &part.control_gradients,
        &part.action_gradients,
        &part.initial_position_gradients,
        &part.initial_velocity_gradients,
    ];
    for array in arrays {
        assert!(f32s(array).iter().all(|x| x.is_nan()), "{array:?}");
    }
    assert!(f64s(&part.gradient_norms).iter().all(|x| x.is_nan()));
    assert_eq!(part.gradient_exploded.unwrap().unpack::<u32>("e").unwrap().1, [1]);
    assert!(f32s(&part.velocities).iter().any(|x| x.is_nan()));
    assert!(part.diagnostics[0].kinetic_energy.is_nan());
}
