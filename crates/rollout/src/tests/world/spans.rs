//! Rollouts that are divided in time.

use bendtwin_proto::v1::cost::{ControlPath, ControlSpeed, Force, Strain, force};

use super::*;

/// Tensors along their second dimension, as one.
fn joined(
    parts: &[RollOutResponse],
    of: impl Fn(&RollOutResponse) -> &Option<Tensor>,
) -> Option<Tensor> {
    let tensors: Vec<&Tensor> = parts.iter().filter_map(|part| of(part).as_ref()).collect();
    let first = tensors.first()?;
    let instances = first.shape[0] as usize;
    let mut data = Vec::new();
    for i in 0..instances {
        for tensor in &tensors {
            let each = tensor.data.len() / instances;
            data.extend_from_slice(&tensor.data[i * each..(i + 1) * each]);
        }
    }
    let rows = tensors.iter().map(|t| t.shape[1]).sum();
    let mut whole = Tensor { data: data.into(), ..Tensor::clone(first) };
    whole.shape[1] = rows;
    Some(whole)
}

/// The reply that the parts of one part of the instances make.
fn whole(parts: &[RollOutResponse]) -> RollOutResponse {
    let mut whole = parts.last().unwrap().clone();
    let frames: Vec<u32> = parts
        .iter()
        .filter_map(|part| part.frames.as_ref())
        .flat_map(|frames| frames.unpack::<u32>("frames").unwrap().1)
        .collect();
    whole.frames = whole.frames.map(|_| Tensor::pack(&[frames.len()], &frames));
    whole.positions = joined(parts, |part| &part.positions);
    whole.velocities = joined(parts, |part| &part.velocities);
    whole.frame_costs = joined(parts, |part| &part.frame_costs);
    whole.controls = joined(parts, |part| &part.controls);
    if let Some(forces) = &mut whole.forces {
        let all: Vec<RollOutResponse> = parts.to_vec();
        let of = |get: fn(&bendtwin_proto::v1::roll_out_response::Forces) -> &Option<Tensor>| {
            let parts: Vec<RollOutResponse> = all
                .iter()
                .map(|part| RollOutResponse {
                    positions: get(part.forces.as_ref().unwrap()).clone(),
                    ..RollOutResponse::default()
                })
                .collect();
            joined(&parts, |part| &part.positions)
        };
        forces.controls = of(|forces| &forces.controls);
        forces.grasps = of(|forces| &forces.grasps);
        forces.ground = of(|forces| &forces.ground);
        forces.colliders = of(|forces| &forces.colliders);
    }
    whole.diverged = parts.iter().flat_map(|part| part.diverged.clone()).collect();
    whole.window = None;
    whole
}

fn cost(name: &str, kind: Kind, when: When) -> Cost {
    Cost { name: name.to_owned(), when: when.into(), kind: Some(kind), ..Cost::default() }
}

fn keypoints() -> Kind {
    keypoint_cost(0.06).kind.unwrap()
}

/// A grasp that opens and closes, a capsule that moves, and every kind of cost over time.
fn eventful() -> RollOutRequest {
    let mut request = carried(&[0.01, 0.01, 0.2, 0.2, 0.01, 0.01, 0.2]);
    request.grasps = vec![Grasp {
        region: Some(grasp::Region::Sphere(Sphere { center: Vec::new(), radius_m: 0.03 })),
        attachment: grasp::Attachment::Springs.into(),
        closed: Some(Tensor::pack(&[7], &[0u32, 1, 1, 1, 1, 0, 0])),
        ..Grasp::default()
    }];
    let row = |x: f32| [x, 0.0, 0.05, 0.0, 0.0, 0.0, 1.0];
    let path = [0.5, 0.5, 0.45, 0.4, 0.35, 0.35, 0.35].map(row);
    let capsule = Capsule { from: vec![0.0, -0.5, 0.0], to: vec![0.0, 0.5, 0.0], radius_m: 0.05 };
    let collider = Collider {
        shape: Some(collider::Shape::Capsule(capsule)),
        carrier: Some(collider::Carrier::Path(Tensor::pack(&[7, 7], path.as_flattened()))),
        ..Collider::default()
    };
    request.world = Some(World { colliders: vec![collider], ..World::default() });
    let force = Force { by: Some(force::By::Ground(force::All {})), ..Force::default() };
    request.costs = vec![
        Cost { success_at_most: Some(0.05), ..cost("end", keypoints(), When::LastFrame) },
        cost("smooth", Kind::Smoothness(Smoothness {}), When::EveryFrame),
        Cost { temperature: 0.01, ..cost("near", keypoints(), When::SoftMin) },
        cost("path", Kind::ControlPath(ControlPath {}), When::LastFrame),
        cost("speed", Kind::ControlSpeed(ControlSpeed { limit_m_s: 0.1 }), When::LastFrame),
        cost("strain", Kind::Strain(Strain { limit: 0.001 }), When::EveryFrame),
        cost("force", Kind::Force(force), When::EveryFrame),
        cost("calm at the end", Kind::Smoothness(Smoothness {}), When::LastFrame),
    ];
    // Every grasp is beyond it.
    let grasp_force_n = Some(0.0);
    request.plausibility = Some(Plausibility { grasp_force_n, ..Plausibility::default() });
    request.returns = Some(Returns {
        every_frames: 2,
        velocities: true,
        frame_costs: true,
        controls: true,
        ..recording(2).unwrap()
    });
    request
}

fn divided(request: &RollOutRequest, part_frames: u32) -> RollOutRequest {
    let returns = request.returns.clone().unwrap_or_default();
    RollOutRequest { returns: Some(Returns { part_frames, ..returns }), ..request.clone() }
}

#[test]
fn parts_in_time_have_the_bits_of_the_whole() {
    let bench = bench(chain(0.0));
    let mut request = eventful();
    let some_nodes = Some(Tensor::pack(&[2], &[4u32, 1]));
    for (every_frames, nodes) in [(2, None), (2, some_nodes), (0, None)] {
        let returns = request.returns.get_or_insert_default();
        (returns.every_frames, returns.nodes) = (every_frames, nodes);
        returns.velocities = every_frames > 0;
        let expected = bench.run(request.clone(), 0).unwrap().remove(0);
        assert_eq!(reasons(&expected), ["GRASP_FORCE"]);
        for part_frames in [2, 14, 58, 60, 1000] {
            let parts = bench.run(divided(&request, part_frames), 16).unwrap();
            let ends: Vec<u32> = parts.iter().map(|p| p.window.unwrap().last_frame).collect();
            let count = 60_u32.div_ceil(part_frames);
            let at: Vec<u32> = (1..=count).map(|i| (i * part_frames).min(60)).collect();
            assert_eq!(ends, at);
            assert!(parts[..parts.len() - 1].iter().all(|p| p.costs.is_none()));
            assert_eq!(whole(&parts).encode_to_vec(), expected.encode_to_vec(), "{part_frames}");
        }
    }
}

#[test]
fn one_frame_after_another_has_the_bits_of_the_whole() {
    let bench = bench(chain(0.0));
    let mut request = eventful();
    request.returns.get_or_insert_default().every_frames = 1;
    let expected = bench.run(request.clone(), 0).unwrap().remove(0);
    let parts = bench.run(divided(&request, 1), 16).unwrap();
    assert_eq!(parts.len(), 60);
    assert_eq!(whole(&parts).encode_to_vec(), expected.encode_to_vec());
}

#[test]
fn instances_come_in_parts_and_each_of_them_in_time() {
    let bench = Bench::new();
    let mut request = request(5);
    request.vary = Some(Vary { mass: factors(&[1.0, 2.0, 1.0, 1.5, 1.0]), ..Vary::default() });
    request.returns = Some(Returns { every_frames: 1, ..Returns::default() });
    let expected = bench.run(request.clone(), 2).unwrap();
    let parts = bench.run(divided(&request, 4), 2).unwrap();
    let firsts: Vec<u32> = parts.iter().map(|part| part.first_instance).collect();
    assert_eq!(firsts, [0, 0, 2, 2, 4, 4]);
    for (pair, expected) in parts.chunks(2).zip(expected) {
        assert_eq!(whole(pair).encode_to_vec(), expected.encode_to_vec());
    }
}

#[test]
fn a_divergence_comes_with_its_frame_and_what_follows_is_not_a_number() {
    let bench = Bench::new();
    let mut request = request(2);
    let Some(Actions::Trajectories(t)) = &mut request.actions else { panic!("trajectories") };
    let knots = [[0.0, 0.0, 0.6], [0.0, 0.0, 0.6], [0.0, 0.0, 0.6], [1e9f32, 0.0, 0.6]];
    t.positions = Some(Tensor::pack(&[2, 2, 1, 3], knots.as_flattened()));
    request.returns = Some(Returns { every_frames: 1, frame_costs: true, ..recording(1).unwrap() });
    let expected = bench.run(request.clone(), 0).unwrap().remove(0);
    let frame = expected.diverged[0].frame;
    let parts = bench.run(divided(&request, 1), 16).unwrap();
    let diverged: Vec<usize> = parts.iter().map(|part| part.diverged.len()).collect();
    assert_eq!(diverged.iter().sum::<usize>(), 1);
    assert_eq!(diverged[frame as usize - 1], 1);
    assert_eq!(whole(&parts).encode_to_vec(), expected.encode_to_vec());
}

#[test]
fn members_of_an_ensemble_come_in_time_too() {
    let bench = Bench::new();
    let mut request = request(2);
    request.vary = Some(Vary { mass: factors(&[0.8, 1.6]), ..Vary::default() });
    request.ensemble =
        Some(Ensemble { members: 2, statistic: Statistic::Worst.into(), ..Ensemble::default() });
    request.returns = recording(3);
    let expected = bench.run(request.clone(), 0).unwrap().remove(0);
    let parts = bench.run(divided(&request, 3), 16).unwrap();
    assert_eq!(whole(&parts).encode_to_vec(), expected.encode_to_vec());
}

#[test]
fn too_much_strain_ends_it_where_it_shows() {
    let bench = Bench::new();
    let mut request = request(1);
    let Some(Actions::Trajectories(t)) = &mut request.actions else { panic!("trajectories") };
    let knots = [[0.0, 0.0, 0.6], [0.0, 0.0, 0.6], [0.0, 0.0, 0.9f32]];
    t.positions = Some(Tensor::pack(&[1, 3, 1, 3], knots.as_flattened()));
    let limits = Plausibility { strain: Some(0.2), refuse: true, ..Plausibility::default() };
    request.plausibility = Some(limits);
    let (plan, wanted) = bench.plan(divided(&request, 1), 16).unwrap();
    let Wanted::Ready(starts) = wanted else { panic!("a state") };
    let (backend, cancel) = (&bench.backend, CancelToken::default());
    let execution = Execution {
        plan: &plan,
        starts: &starts,
        backend,
        cancel: &cancel,
        until: None,
        arrived: Instant::now(),
        worker: "w",
        keeps_states: false,
    };
    let mut windows = 0;
    let error = execution.run(|_| {
        windows += 1;
        Ok(())
    });
    assert_eq!(error.err().unwrap().reason(), "IMPLAUSIBLE_MOTION");
    assert!((1..6).contains(&windows), "{windows}");
}
