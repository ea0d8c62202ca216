//! Limits of the forces of grasps.

use std::sync::atomic::Ordering;

use bendtwin_contract::rollout::{Batch, split};
use bendtwin_proto::v1::roll_out_response::Implausible;

use super::*;

/// Grippers at x = 0 and at x = 0.5 m that lift both ends of the chain to these heights.
fn lifted(heights: &[[f32; 2]]) -> RollOutRequest {
    let rows: Vec<[f32; 7]> = heights
        .iter()
        .flat_map(|[first, last]| {
            [[0.0, 0.0, *first, 0.0, 0.0, 0.0, 1.0], [0.5, 0.0, *last, 0.0, 0.0, 0.0, 1.0]]
        })
        .collect();
    let poses = Some(Tensor::pack(&[1, heights.len(), 2, 7], rows.as_flattened()));
    let region = || Some(grasp::Region::Sphere(Sphere { center: Vec::new(), radius_m: 0.03 }));
    let grasp = |gripper| Grasp { gripper, region: region(), ..Grasp::default() };
    RollOutRequest {
        actions: Some(Actions::Poses(GripperPoses { poses, ..GripperPoses::default() })),
        grasps: vec![grasp(0), grasp(1)],
        frames: 60,
        ..RollOutRequest::default()
    }
}

fn limited(request: &RollOutRequest, grasp_force_n: Option<f64>) -> RollOutRequest {
    let plausibility = Plausibility { grasp_force_n, ..Plausibility::default() };
    RollOutRequest { plausibility: Some(plausibility), ..request.clone() }
}

/// Largest force of each grasp in the forces that an instance returns, and its frame.
fn largest(part: &RollOutResponse, instance: usize) -> Vec<(f32, u32)> {
    let forces = part.forces.as_ref().unwrap();
    let [frames, grasps] = [1, 2].map(|i| forces.grasps.as_ref().unwrap().shape[i] as usize);
    let wrenches = floats(&forces.grasps);
    let own = &wrenches[6 * instance * frames * grasps..][..6 * frames * grasps];
    let of = |grasp: usize| {
        let rows = own.chunks(6).skip(grasp).step_by(grasps).zip(1u32..);
        let norms =
            rows.map(|(f, frame)| ((f[0] * f[0] + f[1] * f[1] + f[2] * f[2]).sqrt(), frame));
        norms.fold((0.0, 0), |most, new| if new.0 > most.0 { new } else { most })
    };
    (0..grasps).map(of).collect()
}

fn found(part: &RollOutResponse) -> Vec<&Implausible> {
    part.implausible.iter().filter(|found| found.reason == "GRASP_FORCE").collect()
}

#[test]
fn each_grasp_beyond_the_limit_is_named_with_its_frame() {
    let bench = bench(chain(0.0));
    let mut request = lifted(&[[0.0, 0.0], [0.1, 0.3]]);
    request.returns = recording(0);
    let part = bench.run(limited(&request, Some(0.0)), 0).unwrap().remove(0);
    let most = largest(&part, 0);
    assert_eq!(found(&part).len(), 2);
    for (grasp, (found, (force, frame))) in (0u32..).zip(found(&part).into_iter().zip(&most)) {
        assert_eq!((found.grasp, found.frame, found.limit), (Some(grasp), *frame, 0.0));
        assert!((found.found - f64::from(*force)).abs() < 1e-4 * f64::from(*force), "{found:?}");
    }
    // Between the two forces is a limit that one of them exceeds.
    assert!((most[0].0 - most[1].0).abs() > 0.1, "{most:?}");
    let between = f64::from(f32::midpoint(most[0].0, most[1].0));
    let part = bench.run(limited(&request, Some(between)), 0).unwrap().remove(0);
    let stronger = u32::from(most[1].0 > most[0].0);
    assert_eq!(found(&part).iter().map(|f| f.grasp).collect::<Vec<_>>(), [Some(stronger)]);
    assert_eq!(reasons(&part), ["GRASP_FORCE"]);
    let refused =
        Plausibility { grasp_force_n: Some(between), refuse: true, ..Plausibility::default() };
    let error =
        bench.run(RollOutRequest { plausibility: Some(refused), ..request }, 0).unwrap_err();
    assert_eq!(error.reason(), "IMPLAUSIBLE_MOTION");
    let message = error.to_string();
    assert!(message.contains(&format!("grasp {stronger}")) && message.contains("grasp_force_n"));
}

#[test]
fn forces_are_measured_for_a_limit_alone() {
    for (limit, is_measured) in [(None, false), (Some(f64::INFINITY), false), (Some(1e3), true)] {
        let bench = bench(chain(0.0));
        let request = limited(&lifted(&[[0.0, 0.0], [0.1, 0.1]]), limit);
        let part = bench.run(request.clone(), 0).unwrap().remove(0);
        assert_eq!(bench.backend.has_measured.load(Ordering::Relaxed), is_measured, "{limit:?}");
        assert!(part.forces.is_none() && part.implausible.is_empty());
        let divided = Returns { part_frames: 20, ..Returns::default() };
        let parts = bench.run(RollOutRequest { returns: Some(divided), ..request }, 8).unwrap();
        assert_eq!(bench.backend.has_measured.load(Ordering::Relaxed), is_measured, "{limit:?}");
        assert!(parts.iter().all(|part| part.forces.is_none()));
    }
    // Without grasps there is nothing to measure.
    let bench = bench(chain(0.3));
    bench.run(limited(&still([0.0, 0.0, 0.6], 5), Some(1.0)), 0).unwrap();
    assert!(!bench.backend.has_measured.load(Ordering::Relaxed));
}

/// The chain weighs 2 kg in the place of its six units, and twice that with a factor.
#[test]
fn forces_are_in_newtons_of_the_object() {
    let mut request = lifted(&[[0.0, 0.0], [0.2, 0.2]]);
    let of = |twin: Twin, request: &RollOutRequest| {
        let part = bench(twin).run(limited(request, Some(0.0)), 0).unwrap().remove(0);
        found(&part).iter().map(|found| found.found).collect::<Vec<f64>>()
    };
    let plain = of(chain(0.0), &request);
    let heavy = of(Twin { mass_kg: Some(2.0), ..chain(0.0) }, &request);
    let is_share = |a: &[f64], b: &[f64], share: f64| {
        a.iter().zip(b).all(|(a, b)| (a / b - share).abs() < 1e-4)
    };
    assert!(is_share(&heavy, &plain, 2.0 / 6.0), "{heavy:?} {plain:?}");
    let double = factors(&[2.0]);
    // Stiffness and damping that keep the motion: forces are those of twice the mass.
    request.vary = Some(Vary {
        mass: double.clone(),
        stiffness: double.clone(),
        damping: double.clone(),
        bending: double,
        ..Vary::default()
    });
    let doubled = of(chain(0.0), &request);
    assert!(is_share(&doubled, &plain, 2.0), "{doubled:?} {plain:?}");
}

#[test]
fn a_grasp_that_slips_counts_with_the_force_at_which_it_slipped() {
    let bench = bench(chain(0.0));
    let mut request = lifted(&[[0.0, 0.0], [0.4, 0.4]]);
    request.returns = recording(0);
    let strongest = largest(&bench.run(request.clone(), 0).unwrap()[0], 0)[0].0;
    let slips = f64::from(0.5 * strongest);
    request.grasps[0].max_force_n = Some(slips);
    let part = bench.run(limited(&request, Some(0.9 * slips)), 0).unwrap().remove(0);
    let first = found(&part)[0];
    assert_eq!(first.grasp, Some(0));
    assert!(first.found > slips && first.found < f64::from(strongest), "{first:?}");
    // Afterwards the grasp held nothing.
    let wrenches = floats(&part.forces.as_ref().unwrap().grasps);
    let after = wrenches.chunks(12).skip(first.frame as usize);
    assert!(after.clone().count() > 0 && after.flat_map(|row| &row[..6]).all(|x| *x == 0.0));
}

#[test]
fn members_and_shared_batches_keep_their_numbers() {
    let one = lifted(&[[0.0, 0.0], [0.1, 0.1]]);
    let Some(Actions::Poses(poses)) = &one.actions else { panic!("poses") };
    let (_, still) = poses.poses.as_ref().unwrap().unpack::<f32>("poses").unwrap();
    let mut rows = still.repeat(3);
    // The second of three instances lifts higher.
    for height in [14 + 2, 21 + 2] {
        rows[28 + height] = 0.5;
    }
    let poses = Some(Tensor::pack(&[3, 2, 2, 7], &rows));
    let actions = Some(Actions::Poses(GripperPoses { poses, ..GripperPoses::default() }));
    let request = RollOutRequest { actions, ..one };
    let bench = bench(chain(0.0));
    let all = bench.run(limited(&request, Some(0.0)), 0).unwrap().remove(0);
    let numbers: Vec<u32> = found(&all).iter().map(|found| found.instance).collect();
    assert_eq!(numbers, [0, 0, 1, 1, 2, 2]);
    let force = |i: usize| found(&all)[i].found;
    assert!(force(2) > 1.1 * force(0) && force(4) == force(0));
    let limit = 0.5 * (force(0).max(force(1)) + force(2).max(force(3)));
    let whole = limited(&request, Some(limit));
    let expected = bench.run(whole.clone(), 0).unwrap().remove(0);
    assert!(found(&expected).iter().all(|found| found.instance == 1));
    assert!(!found(&expected).is_empty());
    let batch = Batch { instances: 3, knots: 2, frames: 60 };
    let replies = split::runs(3, 3, 1)
        .map(|run| bench.run(split::part(&whole, &batch, run), 0).unwrap().remove(0));
    let joined = split::join(replies.collect()).unwrap();
    assert_eq!(joined.implausible, expected.implausible);
    // Arrays are returned for the best alone, but all are judged.
    let best = Returns { best: 1, final_state: true, ..Returns::default() };
    let costs = vec![keypoint_cost(0.0)];
    let asked = RollOutRequest { returns: Some(best), costs, ..whole.clone() };
    assert_eq!(bench.run(asked, 0).unwrap()[0].implausible, expected.implausible);
    let ensemble = Ensemble { members: 2, ..Ensemble::default() };
    let vary = Vary { mass: factors(&[1.0, 1.0]), ..Vary::default() };
    let of_members = RollOutRequest {
        ensemble: Some(ensemble),
        vary: Some(vary),
        ..limited(&request, Some(limit))
    };
    let part = bench.run(of_members, 0).unwrap().remove(0);
    let numbers: Vec<u32> = found(&part).iter().map(|found| found.instance).collect();
    let doubled = |i: u32| [2 * i, 2 * i + 1];
    assert!(numbers.iter().all(|number| doubled(1).contains(number)), "{numbers:?}");
    assert_eq!(numbers.len(), 2 * found(&expected).len());
}
