use bendtwin_proto::v1::{
    ControlTrajectories, Cost, Grasp, InitialState, Returns, Vary,
    cost::{Keypoints, TargetCloud},
    initial_state::GivenState,
    roll_out_response::{Diagnostics, Divergence, Implausible},
};
use proptest::prelude::*;

use super::*;

/// Numbers that differ from row to row.
fn numbered(shape: &[usize], from: f32) -> Option<Tensor> {
    let count = shape.iter().product::<usize>();
    let values: Vec<f32> = (0..count).map(|i| from + i as f32).collect();
    Some(Tensor::pack(shape, &values))
}

/// A request of `b` instances that has every tensor by instance, and some for all of them.
fn request(b: usize) -> RollOutRequest {
    let positions = numbered(&[b, 3, 2, 3], 0.0);
    let given = GivenState {
        positions: numbered(&[b, 4, 3], 1e3),
        velocities: numbered(&[4, 3], 2e3),
        twists: numbered(&[b, 2], 3e3),
        controls: numbered(&[b, 2, 3], 4e3),
        grasping: Some(Grasping {
            phases: numbered(&[b, 1], 5e3),
            holders: numbered(&[4], 6e3),
            places: numbered(&[b, 4, 3], 7e3),
        }),
        commanded_controls: numbered(&[b, 2, 3], 4.5e3),
    };
    let cloud = TargetCloud { points: numbered(&[b, 1, 5, 3], 8e3), point_set: 0 };
    let keypoints = Keypoints {
        targets: numbered(&[2, 5, 3], 9e3),
        nodes: numbered(&[5], 0.0),
        squared: true,
        skin_points: None,
    };
    let cost = |kind| Cost { kind: Some(kind), ..Cost::default() };
    RollOutRequest {
        twin: "twins/x".to_owned(),
        actions: Some(Actions::Trajectories(ControlTrajectories { positions, interpolation: 2 })),
        initial: Some(InitialState { state: Some(State::Given(given)) }),
        costs: vec![cost(Kind::TargetCloud(cloud)), cost(Kind::Keypoints(keypoints))],
        grasps: vec![
            Grasp { closed: numbered(&[b, 3], 1e4), ..Grasp::default() },
            Grasp { closed: numbered(&[3], 2e4), ..Grasp::default() },
        ],
        vary: Some(Vary { mass: numbered(&[b], 3e4), ..Vary::default() }),
        ..RollOutRequest::default()
    }
}

fn batch(b: usize) -> Batch {
    Batch { instances: b as u64, knots: 3, frames: 2 }
}

/// Values of an instance: the row of a tensor by instance, all of one for all.
fn values(tensor: Option<&Tensor>, rank: usize, instance: usize, b: usize) -> Vec<f32> {
    let (shape, values) = tensor.unwrap().unpack::<f32>("").unwrap();
    if shape.len() < rank {
        return values;
    }
    assert_eq!(shape[0], b);
    let width = values.len() / b;
    values[instance * width..][..width].to_vec()
}

/// Everything that a worker would read for an instance.
fn seen(request: &RollOutRequest, instance: usize, b: usize) -> Vec<Vec<f32>> {
    let Some(Actions::Trajectories(t)) = &request.actions else { panic!("trajectories") };
    let Some(State::Given(g)) = &request.initial.as_ref().unwrap().state else { panic!("given") };
    let grasping = g.grasping.as_ref().unwrap();
    let Some(Kind::TargetCloud(cloud)) = &request.costs[0].kind else { panic!("a cloud") };
    let Some(Kind::Keypoints(keypoints)) = &request.costs[1].kind else { panic!("keypoints") };
    let of = |tensor: &Option<Tensor>, rank| values(tensor.as_ref(), rank, instance, b);
    vec![
        of(&t.positions, 4),
        of(&g.positions, 3),
        of(&g.velocities, 3),
        of(&g.twists, 2),
        of(&g.controls, 3),
        of(&g.commanded_controls, 3),
        of(&grasping.phases, 2),
        of(&grasping.holders, 2),
        of(&grasping.places, 3),
        of(&cloud.points, 4),
        of(&keypoints.targets, 4),
        of(&request.grasps[0].closed, 2),
        of(&request.grasps[1].closed, 2),
        of(&request.vary.as_ref().unwrap().mass, 1),
    ]
}

/// The reply of a worker: every array has what it saw of the instance.
fn reply(request: &RollOutRequest, b: usize) -> RollOutResponse {
    let rows: Vec<Vec<f32>> = (0..b).map(|i| seen(request, i, b).concat()).collect();
    let packed = || Some(Tensor::pack(&[b, rows[0].len()], &rows.concat()));
    let costs: Vec<f64> = rows.iter().map(|r| r.iter().copied().map(f64::from).sum()).collect();
    let numbers: Vec<u32> = (0..b as u32).collect();
    // By what they are and not by where they stand in a part.
    let marked = |i: &u32| rows[*i as usize][0] % 5.0 < 2.0;
    RollOutResponse {
        costs: Some(Tensor::pack(&[b], &costs)),
        cost_names: vec!["a".to_owned(), "b".to_owned()],
        cost_terms: Some(Tensor::pack(&[b, 1], &costs)),
        instances: Some(Tensor::pack(&[b], &numbers)),
        frames: Some(Tensor::pack(&[2], &[1u32, 2])),
        positions: packed(),
        final_positions: packed(),
        final_twists: packed(),
        control_gradients: packed(),
        final_grasping: Some(Grasping { places: packed(), ..Grasping::default() }),
        forces: Some(Forces { ground: packed(), ..Forces::default() }),
        diagnostics: (0..b)
            .map(|i| Diagnostics { max_strain: rows[i][0], ..Diagnostics::default() })
            .collect(),
        diverged: numbers
            .iter()
            .copied()
            .filter(marked)
            .map(|instance| Divergence { instance, ..Divergence::default() })
            .collect(),
        implausible: numbers
            .iter()
            .copied()
            .filter(|i| !marked(i))
            .map(|instance| Implausible { instance, ..Implausible::default() })
            .collect(),
        worker: "workers/x".to_owned(),
        substeps: 7,
        mass_kg: Some(0.5),
        ..RollOutResponse::default()
    }
}

proptest! {
    #[test]
    fn parts_see_what_the_whole_sees_and_their_replies_are_the_reply(b in 1usize..20, n in 1u64..9) {
        let whole = request(b);
        let replies: Vec<RollOutResponse> = runs(b as u64, n, 1)
            .map(|run| {
                let count = (run.end - run.start) as usize;
                let part = part(&whole, &batch(b), run.clone());
                for i in 0..count {
                    assert_eq!(seen(&part, i, count), seen(&whole, run.start as usize + i, b));
                }
                reply(&part, count)
            })
            .collect();
        prop_assert_eq!(join(replies).unwrap(), reply(&whole, b));
    }

    #[test]
    fn runs_cover_everything_with_nearly_equal_lengths_of_whole_units(
        instances in 1u64..1_000_000, n in 0u64..40, unit in 0u64..200,
    ) {
        let all: Vec<_> = runs(instances, n, unit).collect();
        let unit = unit.max(1);
        let units = instances.div_ceil(unit);
        prop_assert_eq!(all.len() as u64, n.clamp(1, units));
        prop_assert_eq!((all[0].start, all[all.len() - 1].end), (0, instances));
        prop_assert!(all.windows(2).all(|w| w[0].end == w[1].start));
        prop_assert!(all.iter().all(|r| r.start % unit == 0 && r.start < r.end));
        let lengths = || all.iter().map(|r| (r.end - r.start).div_ceil(unit));
        prop_assert!(lengths().max().unwrap() - lengths().min().unwrap() <= 1);
    }
}

#[test]
fn a_slice_is_whole_rounds_of_lanes_within_its_work() {
    let twin = TwinShape {
        nodes: 100,
        springs: 700,
        triplets: 100,
        substeps: 100,
        ..TwinShape::default()
    };
    let of =
        |frames, lanes| slice_instances(&request(1), &Batch { frames, ..batch(1) }, &twin, lanes);
    // A frame of an instance is 1e5 element substeps.
    assert_eq!((of(10, 100), of(10, 132)), (10_000, 75 * 132));
    assert_eq!((of(1_000, 132), of(1_000_000, 132)), (132, 132));
    assert_eq!(of(100_000, 0), 1);
}

#[test]
fn times_are_the_longest() {
    let timed = |queue_s, compute_s| RollOutResponse {
        timing: Some(Timing { queue_s, compute_s }),
        ..reply(&request(1), 1)
    };
    let joined = join(vec![timed(1.0, 5.0), timed(2.0, 3.0)]).unwrap();
    assert_eq!(joined.timing, Some(Timing { queue_s: 2.0, compute_s: 5.0 }));
}

#[test]
fn replies_that_do_not_fit_together_are_refused() {
    let good = || reply(&request(2), 2);
    assert!(join(vec![good(), good()]).is_ok());
    assert!(join(Vec::new()).is_err());
    assert!(join(vec![good(), RollOutResponse { positions: None, ..good() }]).is_err());
    assert!(join(vec![good(), RollOutResponse { costs: None, ..good() }]).is_err());
    let wider = numbered(&[2, 1], 0.0);
    assert!(join(vec![good(), RollOutResponse { positions: wider, ..good() }]).is_err());
    let mut cut = good();
    if let Some(positions) = &mut cut.positions {
        positions.data = positions.data.slice(..4);
    }
    assert!(join(vec![good(), cut]).is_err());
}

#[test]
fn what_ranks_or_scales_the_whole_batch_is_not_split() {
    assert!(can_split(&request(2)));
    let with = |returns| RollOutRequest { returns: Some(returns), ..request(2) };
    assert!(can_split(&with(Returns { every_frames: 1, ..Returns::default() })));
    assert!(!can_split(&with(Returns { best: 1, ..Returns::default() })));
    let encoding = Encoding::Int16.into();
    assert!(!can_split(&with(Returns { encoding, ..Returns::default() })));
    let ensemble = Some(bendtwin_proto::v1::Ensemble::default());
    assert!(!can_split(&RollOutRequest { ensemble, ..request(2) }));
}
