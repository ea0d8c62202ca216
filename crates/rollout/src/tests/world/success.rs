//! Conditions of success: what they compare, and that nothing else depends on them.

use bendtwin_proto::v1::cost::Strain;

use super::{
    fits::{FITS, on_fits, twin_with_members},
    *,
};
use crate::tests::costs::varied;

fn successes(part: &RollOutResponse) -> Vec<f32> {
    part.successes.as_ref().expect("there are conditions").unpack("s").unwrap().1
}

/// The distance of node 0 from x = 0.06 at the end, as a condition.
fn reaches(at_most: f64) -> Cost {
    Cost { success_at_most: Some(at_most), ..keypoint_cost(0.06) }
}

#[test]
fn conditions_change_nothing_else() {
    let bench = Bench::new();
    let mut request = request(3);
    request.costs = varied();
    request.returns = Some(Returns {
        every_frames: 2,
        final_state: true,
        frame_costs: true,
        control_gradients: true,
        gradient_norms: true,
        ..Returns::default()
    });
    let mut with = request.clone();
    for cost in &mut with.costs {
        if !matches!(cost.kind, Some(Kind::ControlPath(_) | Kind::ControlSpeed(_))) {
            cost.success_at_most = Some(0.5);
        }
    }
    for best in [0, 2] {
        for request in [&mut request, &mut with] {
            request.returns.get_or_insert_default().best = best;
        }
        let without = bench.run(request.clone(), 0).unwrap().remove(0);
        let mut part = bench.run(with.clone(), 0).unwrap().remove(0);
        assert_eq!(part.successes.take().unwrap().shape, [3]);
        assert!(without.successes.is_none());
        // Bytes, for NaN equals nothing.
        assert_eq!(part.encode_to_vec(), without.encode_to_vec(), "the best {best}");
    }
}

/// The value after the last frame is compared for every `when` and every weight.
#[test]
fn the_value_after_the_last_frame_counts_without_its_weight() {
    let bench = Bench::new();
    let end = f64s(
        &bench.run(RollOutRequest { costs: vec![reaches(1.0)], ..request(1) }, 0).unwrap()[0].costs,
    )[0];
    assert!(end > 1e-3, "{end}");
    for (when, weight) in [
        (When::LastFrame, -3.0),
        (When::EveryFrame, 0.25),
        (When::SoftMin, 7.0),
        (When::EveryFrame, 0.0),
    ] {
        for (at_most, expected) in [(end, 1.0), (0.999_999 * end, 0.0), (0.0, 0.0)] {
            let cost = Cost {
                when: when.into(),
                temperature: 0.01,
                weight: Some(weight),
                ..reaches(at_most)
            };
            let part = bench.run(RollOutRequest { costs: vec![cost], ..request(1) }, 0).unwrap();
            assert_eq!(successes(&part[0]), [expected], "{when:?} {weight} {at_most}");
            assert_eq!(f64s(&part[0].costs)[0] == 0.0, weight == 0.0);
        }
    }
}

#[test]
fn all_conditions_are_to_be_met() {
    let bench = Bench::new();
    let strain = |at_most| Cost {
        name: "strain".into(),
        weight: Some(0.0),
        kind: Some(Kind::Strain(Strain { limit: 0.0 })),
        success_at_most: Some(at_most),
        ..Cost::default()
    };
    for (distance, tension, expected) in
        [(1.0, 1.0, 1.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 0.0)]
    {
        let costs = vec![reaches(distance), strain(tension)];
        let part = bench.run(RollOutRequest { costs, ..request(2) }, 0).unwrap().remove(0);
        assert_eq!(successes(&part), [expected; 2]);
    }
}

/// A condition whose targets differ by instance, in parts of two instances.
#[test]
fn parts_have_the_successes_of_their_instances() {
    let bench = Bench::new();
    let mut request = request(5);
    let end = {
        let mut request = request.clone();
        request.returns = Some(Returns { final_state: true, ..Returns::default() });
        points(&bench.run(request, 0).unwrap().remove(0).final_positions)
    };
    // The targets of instances 1 and 4 are where node 0 ends.
    let target = |i: usize| {
        let [x, y, z] = end[4 * i];
        if i == 1 || i == 4 { [x, y, z] } else { [x + 0.05, y, z] }
    };
    let keypoints = Keypoints {
        nodes: Some(Tensor::pack(&[1], &[0u32])),
        targets: Some(Tensor::pack_points(&[5, 1, 1], &[0, 1, 2, 3, 4].map(target))),
        ..Keypoints::default()
    };
    let kind = Some(Kind::Keypoints(keypoints));
    request.costs = vec![
        keypoint_cost(0.06),
        Cost { weight: Some(0.0), success_at_most: Some(1e-6), kind, ..Cost::default() },
    ];
    let whole = bench.run(request.clone(), 0).unwrap().remove(0);
    assert_eq!(successes(&whole), [0.0, 1.0, 0.0, 0.0, 1.0]);
    let parts = bench.run(request.clone(), 2).unwrap();
    let of_parts: Vec<f32> = parts.iter().flat_map(successes).collect();
    assert_eq!(of_parts, successes(&whole));
    // In time as well: with the last part of each instance.
    request.returns = Some(Returns { part_frames: 4, ..Returns::default() });
    let parts = bench.run(request, 2).unwrap();
    let with: Vec<bool> = parts.iter().map(|part| part.successes.is_some()).collect();
    assert_eq!(with, [false, true, false, true, false, true]);
    let last = parts.iter().filter(|part| part.successes.is_some());
    assert_eq!(last.flat_map(successes).collect::<Vec<f32>>(), successes(&whole));
}

#[test]
fn an_ensemble_succeeds_by_the_share_of_its_members() {
    let bench = bench(twin_with_members());
    let mut request = on_fits(FITS as u32);
    let members = f64s(&bench.run(request.clone(), 0).unwrap()[0].member_costs);
    let mut sorted = members.clone();
    sorted.sort_by(f64::total_cmp);
    // Between the members of lowest cost and the others.
    let at_most = 0.5 * (sorted[1] + sorted[2]);
    assert!(sorted[1] < at_most && at_most < sorted[2], "{sorted:?}");
    request.costs[0].success_at_most = Some(at_most);
    let expected: Vec<f32> = members
        .chunks(FITS)
        .map(|own| own.iter().filter(|c| **c <= at_most).count() as f32 / FITS as f32)
        .collect();
    for statistic in [Statistic::Mean, Statistic::Worst] {
        request.ensemble.iter_mut().for_each(|e| e.set_statistic(statistic));
        assert_eq!(successes(&bench.run(request.clone(), 0).unwrap()[0]), expected);
    }
    // The mean motion has its own cost.
    request.ensemble.iter_mut().for_each(|e| e.set_statistic(Statistic::MeanPrediction));
    request.returns.iter_mut().for_each(|returns| returns.forces = false);
    let costs = f64s(&bench.run(request.clone(), 0).unwrap()[0].costs);
    let least = costs.iter().copied().fold(f64::MAX, f64::min);
    for weight in [1.0, 0.0] {
        request.costs[0].weight = Some(weight);
        request.costs[0].success_at_most = Some(least);
        let met: Vec<f32> = costs.iter().map(|c| f32::from(u8::from(*c <= least))).collect();
        assert_eq!(successes(&bench.run(request.clone(), 0).unwrap()[0]), met);
        assert!(met.contains(&1.0), "{met:?}");
    }
}

#[test]
fn what_diverges_does_not_succeed() {
    let bench = Bench::new();
    let mut request = request(2);
    let knots = [[[0.0, 0.0, 0.6], [1e9, 0.0, 0.6]], [[0.0, 0.0, 0.6]; 2]];
    let positions = Some(Tensor::pack_points(&[2, 2, 1], knots.as_flattened()));
    let trajectories = ControlTrajectories { positions, interpolation: 0 };
    request.actions = Some(Actions::Trajectories(trajectories));
    request.costs = vec![reaches(1e6)];
    let part = bench.run(request.clone(), 0).unwrap().remove(0);
    assert_eq!(part.diverged.iter().map(|d| d.instance).collect::<Vec<_>>(), [0]);
    assert_eq!(successes(&part), [0.0, 1.0]);
    request.returns = Some(Returns { part_frames: 2, ..Returns::default() });
    let parts = bench.run(request, 2).unwrap();
    assert_eq!(successes(parts.last().unwrap()), [0.0, 1.0]);
}

/// A condition adds to a reply what the check says that it adds.
#[test]
fn the_check_counts_the_successes_of_a_reply() {
    let bench = Bench::new();
    let shape = crate::shape(&bench.warm.twin, false);
    let [without, with] = [None, Some(0.5)].map(|success_at_most| {
        let mut request = request(60);
        request.costs[0].success_at_most = success_at_most;
        let batch = bendtwin_contract::rollout::check_for(&request, &shape, &limits(), 0).unwrap();
        let most = bendtwin_contract::rollout::reply_bytes(&request, &batch, &shape, 0);
        [most, bench.run(request, 0).unwrap()[0].encoded_len() as u64]
    });
    assert_eq!(with[0] - without[0], with[1] - without[1]);
    assert!(with[1] > without[1] + 4 * 60, "{without:?} {with:?}");
}
