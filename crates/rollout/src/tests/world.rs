//! Grasps, colliders, grounds, parameters by instance and implausible motion, with the physics of
//! the CPU.

mod fits;
mod forces;
mod links;
mod mean;
mod spans;
mod success;
mod tasks;

use bendtwin_proto::v1::{
    Capsule, Collider, Ensemble, GradientOptions, Grasp, GripperPoses, Plane, Plausibility, Sphere,
    Vary, World, collider, ensemble::Statistic, grasp, world::GroundChoice,
};

use super::*;

const N: usize = 6;

/// A chain of six nodes along x, 0.1 m apart, at a height [m]; its control point holds nothing.
fn chain(height: f32) -> Twin {
    let base = twin();
    let n = N as u32;
    let graph = Graph {
        rest_positions: (0..N).map(|i| [0.1 * i as f32, 0.0, height]).collect(),
        kinds: vec![NodeKind::Observed; N],
        masses: vec![1.0; N],
        object_ids: vec![0; N],
        observed_points: (0..n).collect(),
        control_rest: vec![[0.0, 0.0, 0.6]],
        springs: (1..n).map(|i| [i, i - 1]).collect(),
        triplets: (2..n).map(|i| [i - 2, i - 1, i]).collect(),
        ..base.graph
    };
    let params = Params {
        spring_stiffness: vec![500.0; N - 1],
        spring_dashpot: vec![1.0; N - 1],
        rest_lengths_m: vec![0.1; N - 1],
        bend_stiffness: vec![0.01; N - 2],
        bend_damping: vec![0.0; N - 2],
        rest_angles_rad: vec![std::f32::consts::PI; N - 2],
        ..base.params
    };
    Twin { skin: Skin::of_nodes(&graph), graph, params, ..base }
}

fn bench(twin: Twin) -> Bench {
    Bench::of(twin, bendtwin_engine::cpu_with_threads(2))
}

/// A gripper at these heights over x = 0, in knots spread over 60 frames.
fn carried(heights: &[f32]) -> RollOutRequest {
    let rows: Vec<[f32; 7]> = heights.iter().map(|z| [0.0, 0.0, *z, 0.0, 0.0, 0.0, 1.0]).collect();
    let poses = Some(Tensor::pack(&[1, heights.len(), 1, 7], rows.as_flattened()));
    RollOutRequest {
        actions: Some(Actions::Poses(GripperPoses { poses, ..GripperPoses::default() })),
        frames: 60,
        ..RollOutRequest::default()
    }
}

/// The control point at these heights over x = 0, in knots spread over 60 frames.
fn lowered(heights: &[f32]) -> RollOutRequest {
    let rows: Vec<[f32; 3]> = heights.iter().map(|z| [0.0, 0.0, *z]).collect();
    let positions = Some(Tensor::pack_points(&[1, heights.len(), 1], &rows));
    let trajectories = ControlTrajectories { positions, interpolation: 0 };
    let actions = Some(Actions::Trajectories(trajectories));
    RollOutRequest { actions, frames: 60, ..RollOutRequest::default() }
}

/// A control point that stands still for `frames` frames.
fn still(at: [f32; 3], frames: u32) -> RollOutRequest {
    let positions = Some(Tensor::pack_points(&[1, 2, 1], &[at; 2]));
    let trajectories = ControlTrajectories { positions, interpolation: 0 };
    let actions = Some(Actions::Trajectories(trajectories));
    RollOutRequest { actions, frames, ..RollOutRequest::default() }
}

fn recording(every_frames: u32) -> Option<Returns> {
    Some(Returns {
        every_frames,
        final_state: true,
        diagnostics: true,
        forces: true,
        ..Returns::default()
    })
}

fn points(tensor: &Option<Tensor>) -> Vec<[f32; 3]> {
    tensor.as_ref().unwrap().unpack_points("p").unwrap().1
}

fn floats(tensor: &Option<Tensor>) -> Vec<f32> {
    tensor.as_ref().unwrap().unpack::<f32>("f").unwrap().1
}

fn reasons(part: &RollOutResponse) -> Vec<&str> {
    part.implausible.iter().map(|i| i.reason.as_str()).collect()
}

#[test]
fn one_value_is_that_of_all_knots() {
    let bench = bench(chain(0.0));
    for value in [0, 1u32] {
        let ends = [&[value; 4][..], &[value]].map(|closed| {
            let mut request = carried(&[0.01, 0.1, 0.2, 0.2]);
            request.grasps = vec![Grasp {
                region: Some(grasp::Region::Sphere(Sphere { center: Vec::new(), radius_m: 0.03 })),
                closed: Some(Tensor::pack(&[closed.len()], closed)),
                ..Grasp::default()
            }];
            request.returns = recording(10);
            bench.run(request, 0).unwrap().remove(0).positions
        });
        assert_eq!(ends[0], ends[1]);
        assert_eq!(points(&ends[1])[5 * N][2] > 0.1, value == 1);
    }
}

#[test]
fn a_gripper_lifts_a_chain_from_the_ground_and_sets_it_down() {
    let bench = bench(chain(0.0));
    // Springs yield under the weight that they carry.
    let attachments = [(grasp::Attachment::Pin, 0.01), (grasp::Attachment::Springs, 0.04)];
    for (attachment, slack) in attachments {
        let mut request = carried(&[0.01, 0.01, 0.2, 0.2, 0.01, 0.01, 0.2]);
        request.grasps = vec![Grasp {
            region: Some(grasp::Region::Sphere(Sphere { center: Vec::new(), radius_m: 0.03 })),
            attachment: attachment.into(),
            closed: Some(Tensor::pack(&[7], &[0u32, 1, 1, 1, 1, 0, 0])),
            ..Grasp::default()
        }];
        request.returns = recording(10);
        let part = bench.run(request, 0).unwrap().remove(0);
        assert!(part.diverged.is_empty());
        let positions = points(&part.positions);
        let held = |row: usize| positions[row * N][2];
        let heights: Vec<f32> = (0..6).map(held).collect();
        // Where it lay, lifted by 0.19 m, held, set down, released, left behind.
        let expected = [0.0, 0.19, 0.19, 0.0, 0.0, 0.0];
        for (row, (height, expected)) in heights.iter().zip(expected).enumerate() {
            // The chain that was pulled in bends up while it is set down, against springs too.
            let slack = if row == 3 { 2.0 * slack } else { slack };
            assert!((height - expected).abs() < slack, "{attachment:?} {heights:?}");
        }
        // The far end never left the ground.
        assert!((0..6).all(|row| positions[row * N + N - 1][2].abs() < 0.01));
        let forces = part.forces.as_ref().unwrap();
        assert_eq!(forces.grasps.as_ref().unwrap().shape, [1, 60, 1, 6]);
        let lift = |frame: usize| floats(&forces.grasps)[6 * frame + 2];
        let ground = |frame: usize| floats(&forces.ground)[3 * frame + 2];
        let weight = 9.81 * N as f32;
        assert_eq!((lift(5), lift(58)), (0.0, 0.0));
        assert!(lift(29) > 0.1 * weight && lift(29) < weight, "{}", lift(29));
        let both = lift(29) + ground(29);
        assert!((both - weight).abs() < 0.2 * weight, "{both} for {weight}");
        let phases = part.final_grasping.unwrap().phases.unwrap().unpack::<u32>("p").unwrap().1;
        assert_eq!(phases, [0]);
    }
}

#[test]
fn a_rope_falls_over_a_capsule_that_moves() {
    let bench = bench(chain(0.3));
    let row = |x: f32| [x, 0.0, 0.1, 0.0, 0.0, 0.0, 1.0];
    let path = Tensor::pack(&[2, 7], [row(0.2), row(0.3)].as_flattened());
    let capsule = Capsule { from: vec![0.0, -0.5, 0.0], to: vec![0.0, 0.5, 0.0], radius_m: 0.05 };
    let collider = Collider {
        shape: Some(collider::Shape::Capsule(capsule)),
        carrier: Some(collider::Carrier::Path(path)),
        margin_m: 0.01,
        ..Collider::default()
    };
    let mut request = still([0.0, 0.0, 0.6], 30);
    request.returns = recording(1);
    let distance = |part: &RollOutResponse| {
        let rows = points(&part.positions);
        let away = rows.chunks(N).enumerate().flat_map(|(row, nodes)| {
            let x = 0.2 + 0.1 * (row + 1) as f32 / 30.0;
            nodes.iter().map(move |p| (p[0] - x).hypot(p[2] - 0.1))
        });
        away.fold(f32::MAX, f32::min)
    };
    let without = bench.run(request.clone(), 0).unwrap().remove(0);
    request.world = Some(World { colliders: vec![collider], ..World::default() });
    let with = bench.run(request, 0).unwrap().remove(0);
    assert!(distance(&without) < 0.05, "{}", distance(&without));
    assert!(distance(&with) > 0.058, "{}", distance(&with));
    let upwards: f32 =
        floats(&with.forces.unwrap().colliders).chunks(6).map(|wrench| wrench[2]).sum();
    assert!(upwards > 0.0, "{upwards}");
}

#[test]
fn the_ground_is_where_the_request_says() {
    let bench = bench(chain(0.3));
    let lowest = |choice: Option<GroundChoice>, gravity: Vec<f32>| {
        let mut request = still([0.0, 0.0, 0.6], 30);
        request.world = Some(World { ground_choice: choice, gravity, ..World::default() });
        request.returns = recording(0);
        let part = bench.run(request, 0).unwrap().remove(0);
        points(&part.final_positions).iter().map(|p| p[2]).fold(f32::MAX, f32::min)
    };
    let plane = |offset_m| Some(GroundChoice::Ground(Plane { normal: Vec::new(), offset_m }));
    assert!(lowest(None, Vec::new()).abs() < 0.01);
    assert!((lowest(plane(0.2), Vec::new()) - 0.2).abs() < 0.01);
    assert!(lowest(Some(GroundChoice::NoGround(true)), Vec::new()) < -0.5);
    assert_eq!(lowest(None, vec![0.0; 3]), 0.3);
}

fn factors(values: &[f32]) -> Option<Tensor> {
    Some(Tensor::pack(&[values.len()], values))
}

#[test]
fn a_mass_is_the_inverse_of_all_that_exerts_forces() {
    let bench = Bench::new();
    let mut request = request(1);
    let knots = [[0.0, 0.0, 0.6], [0.05, 0.0, 0.6]].repeat(3);
    let positions = Some(Tensor::pack_points(&[3, 2, 1], &knots));
    let trajectories = ControlTrajectories { positions, interpolation: 0 };
    request.actions = Some(Actions::Trajectories(trajectories));
    request.vary = Some(Vary {
        mass: factors(&[1.0, 2.0, 1.0]),
        stiffness: factors(&[1.0, 1.0, 0.5]),
        damping: factors(&[1.0, 1.0, 0.5]),
        bending: factors(&[1.0, 1.0, 0.5]),
        ..Vary::default()
    });
    request.returns = recording(0);
    let part = bench.run(request.clone(), 0).unwrap().remove(0);
    let last = points(&part.final_positions);
    let (plain, heavy, weak) = (&last[..4], &last[4..8], &last[8..]);
    assert_eq!(heavy, weak);
    // It hangs lower, and pulls twice as much at its control point as the weak one.
    assert!(heavy[3][2] < plain[3][2] - 1e-3, "{heavy:?} {plain:?}");
    let forces = floats(&part.forces.unwrap().controls);
    let (heavy, weak) = (&forces[18..36], &forces[36..]);
    assert!(heavy.iter().zip(weak).all(|(h, w)| *h == 2.0 * w) && heavy[17] > 0.0, "{heavy:?}");
    // What would need more than a hundred thousand substeps is refused.
    request.vary = Some(Vary {
        mass: factors(&[1.0, 0.01, 1.0]),
        damping: factors(&[1.0, 100.0, 1.0]),
        ..Vary::default()
    });
    let mut damped = twin();
    damped.params.spring_dashpot.fill(500.0);
    let error = self::bench(damped).run(request, 0).unwrap_err();
    assert_eq!(error.category(), Category::InvalidArgument);
    assert!(error.to_string().contains("`vary`") && error.to_string().contains("at most 100000"));
}

/// Factors as large and as small as they may be: each instance has the substeps that it needs, so it
/// moves in the same bits alone and beside others.
#[test]
fn what_varies_gets_the_substeps_that_it_needs() {
    // Of its 60 substeps it needs 57.
    let mut stiff = twin();
    stiff.params.spring_stiffness.fill(3e5);
    let bench = bench(stiff);
    let run = |stiffness: &[f32], mass: &[f32]| {
        let mut request = request(1);
        let knots = [[0.0, 0.0, 0.6], [0.05, 0.0, 0.6]].repeat(mass.len());
        let positions = Some(Tensor::pack_points(&[mass.len(), 2, 1], &knots));
        let trajectories = ControlTrajectories { positions, interpolation: 0 };
        request.actions = Some(Actions::Trajectories(trajectories));
        let (stiffness, mass) = (factors(stiffness), factors(mass));
        request.vary = Some(Vary { stiffness, mass, ..Vary::default() });
        request.returns = recording(0);
        bench.run(request, 0).unwrap().remove(0)
    };
    let [stiffness, mass] = [[1.0, 100.0, 1.0, 0.01], [1.0, 1.0, 0.1, 100.0]];
    let together = run(&stiffness, &mass);
    assert!(together.diverged.is_empty() && together.substeps > 60, "{}", together.substeps);
    let (last, forces) = (points(&together.final_positions), together.forces.unwrap().controls);
    for i in 0..4 {
        let apart = run(&stiffness[i..i + 1], &mass[i..i + 1]);
        assert_eq!(points(&apart.final_positions), last[4 * i..4 * (i + 1)], "{i}");
        let own = floats(&apart.forces.unwrap().controls);
        assert_eq!(own, floats(&forces)[own.len() * i..own.len() * (i + 1)], "{i}");
        assert_eq!(apart.substeps > 60, i == 1 || i == 2, "{i}: {}", apart.substeps);
    }
}

/// Energies are those of the object's mass, as forces are.
#[test]
fn energies_are_joules_where_the_mass_is_known() {
    let mut known = twin();
    let units: f64 = known.graph.masses.iter().map(|m| f64::from(*m)).sum();
    known.mass_kg = Some(0.05 * units);
    let energies = |twin: Twin, mass: f32| {
        let mut request = request(1);
        request.vary = Some(Vary { mass: factors(&[mass]), ..Vary::default() });
        request.returns = recording(0);
        let part = bench(twin).run(request, 0).unwrap().remove(0);
        [part.diagnostics[0].kinetic_energy, part.diagnostics[0].elastic_energy]
    };
    let [kinetic, elastic] = energies(twin(), 1.0);
    assert!(kinetic > 0.0 && elastic > 0.0);
    let near = |a: f32, b: f32| (a - b).abs() < 1e-5 * b;
    let joules = energies(known.clone(), 1.0);
    assert!(near(joules[0], 0.05 * kinetic) && near(joules[1], 0.05 * elastic), "{joules:?}");
    let [heavy, _] = energies(known, 2.0);
    let [unit, _] = energies(twin(), 2.0);
    assert!(near(heavy, 0.05 * unit), "{heavy} {unit}");
}

#[test]
fn a_chain_bounces_as_high_as_its_restitution_says() {
    let bench = bench(chain(0.3));
    let mut request = still([0.0, 0.0, 0.6], 20);
    let positions = Some(Tensor::pack_points(&[2, 2, 1], &[[0.0, 0.0, 0.6]; 4]));
    let trajectories = ControlTrajectories { positions, interpolation: 0 };
    request.actions = Some(Actions::Trajectories(trajectories));
    request.vary = Some(Vary { ground_restitution: factors(&[0.0, 0.9]), ..Vary::default() });
    request.returns = recording(1);
    let part = bench.run(request, 0).unwrap().remove(0);
    let positions = points(&part.positions);
    // The highest that the far end gets after it has met the ground, which takes 7.4 frames.
    let [dead, bouncy] = [0, 1].map(|instance| {
        let rows = positions.chunks(N).skip(20 * instance).take(20).map(|row| row[N - 1][2]);
        rows.skip(9).fold(0.0, f32::max)
    });
    assert!(bouncy > dead + 0.1, "{dead} {bouncy}");
}

#[test]
fn an_ensemble_is_a_statistic_of_instances_that_vary() {
    let bench = Bench::new();
    let masses = [0.8, 1.6, 1.2];
    let vary = Some(Vary { mass: factors(&masses), ..Vary::default() });
    let returns = || Some(Returns { control_gradients: true, ..Returns::default() });
    // The same action three times, as instances.
    let knots = [[0.0, 0.0, 0.6], [0.02, 0.0, 0.6]];
    let positions = Some(Tensor::pack_points(&[3, 2, 1], &knots.repeat(3)));
    let trajectories = ControlTrajectories { positions, interpolation: 0 };
    let apart = RollOutRequest {
        actions: Some(Actions::Trajectories(trajectories)),
        vary: vary.clone(),
        returns: returns(),
        ..request(1)
    };
    let apart = bench.run(apart, 0).unwrap().remove(0);
    let (costs, gradients) = (f64s(&apart.costs), points(&apart.control_gradients));
    let run = |statistic: Statistic, share: f64, part: u32| {
        let ensemble = Some(Ensemble { members: 3, statistic: statistic.into(), share });
        // Action 1 of two is the one above.
        let request =
            RollOutRequest { ensemble, vary: vary.clone(), returns: returns(), ..request(2) };
        bench.run(request, part).unwrap()
    };
    let mean = run(Statistic::Mean, 0.0, 0).remove(0);
    let members = f64s(&mean.member_costs);
    assert_eq!(members[3..], costs);
    assert_eq!(f64s(&mean.costs)[1], costs.iter().map(|c| c / 3.0).sum::<f64>());
    assert_eq!(mean.control_gradients.as_ref().unwrap().shape, [2, 7, 1, 3]);
    let worst = costs.iter().copied().fold(f64::MIN, f64::max);
    let at = costs.iter().position(|c| *c == worst).unwrap();
    // In parts too, with the number of the action first.
    let parts = run(Statistic::Worst, 0.0, 1);
    assert_eq!(parts.iter().map(|p| p.first_instance).collect::<Vec<_>>(), [0, 1]);
    assert_eq!(f64s(&parts[1].costs), [worst]);
    assert_eq!(points(&parts[1].control_gradients), gradients[7 * at..7 * (at + 1)]);
    let tail = run(Statistic::Cvar, 0.5, 0).remove(0);
    let least = costs.iter().copied().fold(f64::MAX, f64::min);
    let expected = (costs.iter().sum::<f64>() - least) / 2.0;
    assert!((f64s(&tail.costs)[1] - expected).abs() < 1e-12);
}

#[test]
fn what_no_robot_does_is_flagged_in_every_reply_and_refused_if_asked() {
    let bench = Bench::new();
    let away = |start: f32, end: f32| {
        let mut request = still([0.0, 0.0, 0.6], 3);
        let knots = [[start, 0.0, 0.6], [end, 0.0, 0.6]];
        let positions = Some(Tensor::pack_points(&[1, 2, 1], &knots));
        let trajectories = ControlTrajectories { positions, interpolation: 0 };
        request.actions = Some(Actions::Trajectories(trajectories));
        request
    };
    let flagged = |request: &RollOutRequest| bench.run(request.clone(), 0).unwrap().remove(0);
    assert!(flagged(&away(0.0, 0.02)).implausible.is_empty());
    // 50 mm from where the control point is; 9 m/s, which also tears the chain.
    let gap = flagged(&away(0.05, 0.05));
    assert_eq!(reasons(&gap), ["START_GAP"]);
    let found = &gap.implausible[0];
    assert!((found.found - 0.05).abs() < 1e-6 && found.limit == 0.005, "{found:?}");
    let fast = flagged(&away(0.0, 0.9));
    assert_eq!(reasons(&fast)[0], "CONTROL_SPEED");
    let found = &fast.implausible[0];
    assert!((found.found - 9.0).abs() < 1e-3 && found.frame > 0, "{found:?}");
    for (request, word) in [(away(0.05, 0.05), "row 0"), (away(0.0, 0.9), "more frames")] {
        let refuse = Plausibility { refuse: true, ..Plausibility::default() };
        let request = RollOutRequest { plausibility: Some(refuse), ..request };
        let error = bench.run(request, 0).unwrap_err();
        assert_eq!(error.reason(), "IMPLAUSIBLE_MOTION");
        assert_eq!(error.category(), Category::FailedPrecondition);
        assert!(error.to_string().contains(word), "{error}");
    }
    let wide = Plausibility { start_gap_m: Some(0.1), refuse: true, ..Plausibility::default() };
    let request = RollOutRequest { plausibility: Some(wide), ..away(0.05, 0.05) };
    assert!(flagged(&request).implausible.is_empty());
}

#[test]
fn control_points_do_not_pass_through_a_table_unnoticed() {
    let bench = bench(chain(0.0));
    let mut request = carried(&[0.6, 0.3]);
    request.returns = recording(0);
    // The gripper carries the control point, at its own height, down to 0.3 m.
    let free = bench.run(request.clone(), 0).unwrap().remove(0);
    assert!(reasons(&free).is_empty() && free.diagnostics[0].control_depth_m == 0.0);
    let table =
        bendtwin_proto::v1::Cuboid { low: vec![-1.0, -1.0, 0.2], high: vec![1.0, 1.0, 0.4] };
    let table = Collider {
        shape: Some(collider::Shape::Cuboid(table)),
        margin_m: 0.05,
        ..Collider::default()
    };
    request.world = Some(World { colliders: vec![table], ..World::default() });
    let part = bench.run(request, 0).unwrap().remove(0);
    assert_eq!(reasons(&part), ["CONTROL_IN_OBSTACLE"]);
    assert!((part.diagnostics[0].control_depth_m - 0.1).abs() < 1e-5);
    assert_eq!(part.implausible[0].frame, 60);
}

#[test]
fn a_hand_stops_at_the_ground_and_the_reply_says_so() {
    let bench = bench(chain(0.45));
    let mut request = lowered(&[0.6, 0.3]);
    request.returns = recording(0);
    let ground = Plane { normal: Vec::new(), offset_m: 0.4 };
    let world = World { ground_choice: Some(GroundChoice::Ground(ground)), ..World::default() };
    request.world = Some(world);
    let run = |request: &RollOutRequest| bench.run(request.clone(), 0).unwrap().remove(0);
    let part = run(&request);
    assert_eq!(reasons(&part), ["CONTROL_IN_OBSTACLE"]);
    let found = &part.diagnostics[0];
    assert!((found.control_depth_m - 0.1).abs() < 1e-5, "{found:?}");
    assert!((found.stopped_hand_m - 0.095).abs() < 1e-5, "{found:?}");
    // 200 mm more change nothing of what happens.
    let mut deeper = lowered(&[0.6, 0.3, 0.1]);
    deeper.returns = recording(0);
    deeper.world.clone_from(&request.world);
    let found = &run(&deeper).diagnostics[0];
    assert!((found.stopped_hand_m - 0.295).abs() < 1e-5, "{found:?}");
    // Who wants it deeper says so; above the ground nothing stops.
    request.plausibility = Some(Plausibility { control_depth_m: Some(1.0), ..Default::default() });
    let free = run(&request);
    assert!(reasons(&free).is_empty() && free.diagnostics[0].stopped_hand_m == 0.0);
}

/// A gripper that stays above a table takes hold of nodes below it and carries them into the table:
/// flagged, whether it closes at the start or later.
#[test]
fn held_nodes_do_not_pass_through_a_table_unnoticed() {
    let bench = bench(chain(0.0));
    let table =
        bendtwin_proto::v1::Cuboid { low: vec![-1.0, -1.0, -0.5], high: vec![1.0, 1.0, -0.1] };
    let table = Collider { shape: Some(collider::Shape::Cuboid(table)), ..Collider::default() };
    let world = World {
        gravity: vec![0.0; 3],
        colliders: vec![table],
        ground_choice: Some(GroundChoice::NoGround(true)),
        ..World::default()
    };
    let held = |closed: [u32; 4]| Grasp {
        region: Some(grasp::Region::Nodes(Tensor::pack(&[2], &[0u32, 1]))),
        closed: Some(Tensor::pack(&[4], &closed)),
        ..Grasp::default()
    };
    // Down by 0.15 m in the last third, to 0.3 m above the table's top.
    let carried = carried(&[0.35, 0.35, 0.35, 0.2]);
    for (closed, is_flagged) in
        [([1, 1, 1, 1], true), ([0, 1, 1, 1], true), ([1, 1, 0, 0], false), ([0; 4], false)]
    {
        let mut request = carried.clone();
        (request.world, request.grasps) = (Some(world.clone()), vec![held(closed)]);
        request.returns = Some(Returns { diagnostics: true, ..Returns::default() });
        let part = bench.run(request, 0).unwrap().remove(0);
        let expected: &[&str] = if is_flagged { &["CONTROL_IN_OBSTACLE"] } else { &[] };
        assert_eq!(reasons(&part), expected, "{closed:?}");
        let depth = part.diagnostics[0].control_depth_m;
        assert!((depth - if is_flagged { 0.05 } else { 0.0 }).abs() < 1e-4, "{closed:?}: {depth}");
        if is_flagged {
            assert_eq!(part.implausible[0].frame, 60);
        }
    }
}

#[test]
fn a_gradient_reaches_the_requested_frames() {
    let bench = Bench::new();
    let mut asking = request(1);
    asking.returns = Some(Returns { control_gradients: true, ..Returns::default() });
    let gradient = |reach_frames: u32, smoothing_m: f64| {
        let gradient = Some(GradientOptions { reach_frames, smoothing_m });
        let part = bench.run(RollOutRequest { gradient, ..asking.clone() }, 0).unwrap().remove(0);
        points(&part.control_gradients)
    };
    let whole = gradient(0, 0.0);
    let two = gradient(2, 0.0);
    // Six frames are cut at 2 and 4: what happens before frame 4 has no say.
    assert!(two[..4].iter().all(|g| *g == [0.0; 3]) && whole[1] != [0.0; 3], "{two:?}");
    assert_eq!(two[6], whole[6]);
    // In the air smoothing changes nothing.
    assert_eq!(gradient(0, 0.001), whole);
}

/// A bead that falls on a ball from 10 cm above it, in balance on its top.
#[test]
fn a_gradient_through_impacts_that_multiply_it_is_flagged() {
    let base = twin();
    let graph = Graph {
        rest_positions: vec![[0.0, 0.0, 0.12]],
        kinds: vec![NodeKind::Observed],
        masses: vec![1.0],
        object_ids: vec![0],
        observed_points: vec![0],
        springs: Vec::new(),
        triplets: Vec::new(),
        ..base.graph
    };
    let params = Params { drag: 0.0, contact: base.params.contact, ..Params::default() };
    let bench = bench(Twin { skin: Skin::of_nodes(&graph), graph, params, ..base });
    let ball = Collider {
        shape: Some(collider::Shape::Sphere(Sphere { center: Vec::new(), radius_m: 0.02 })),
        friction: Some(0.0),
        restitution: Some(1.0),
        ..Collider::default()
    };
    for (colliders, is_flagged) in [(Vec::new(), 0), (vec![ball], 1)] {
        let mut request = still([0.0, 0.0, 0.6], 60);
        request.costs = vec![keypoint_cost(0.06)];
        request.world = Some(World {
            colliders,
            ground_choice: Some(GroundChoice::NoGround(true)),
            ..World::default()
        });
        request.returns =
            Some(Returns { initial_gradients: true, gradient_norms: true, ..Returns::default() });
        let part = bench.run(request, 0).unwrap().remove(0);
        // Each bounce turns the direction by far more than the bead was aside.
        let norms = part.gradient_norms.as_ref().unwrap().unpack::<f64>("n").unwrap().1;
        assert_eq!(norms[0] > 1e4 * norms[60], is_flagged == 1, "{norms:?}");
        let exploded = part.gradient_exploded.unwrap().unpack::<u32>("e").unwrap().1;
        assert_eq!(exploded, [is_flagged]);
    }
}
