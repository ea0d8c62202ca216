use bendtwin_core::{Identifiability, identifiability::Quantity};
use bendtwin_engine::cpu_with_threads;

use crate::strip::{held_in_the_middle, lift, lift_and_shake, record, strip};

use super::*;

fn report(twin: &Twin, capture: &Capture) -> Identifiability {
    let cancel = CancelToken::default();
    identify(&*cpu_with_threads(2), twin, capture, &cancel).unwrap().unwrap()
}

/// Relative deviation of the stiffness of a region.
fn stiffness(report: &Identifiability, region: usize) -> f64 {
    let is_it = |g: &&Group| g.quantity == Quantity::Stiffness && g.region == Some(region as u32);
    report.groups.iter().find(is_it).unwrap().relative_sd
}

/// A strip that moves only between its two hands.
#[test]
fn only_the_part_that_moves_is_determined() {
    let twin = held_in_the_middle();
    let capture = record(&twin, 31, 31, lift_and_shake);
    let report = report(&twin, &capture);
    let far = report.regions.len() - 1;
    let names: Vec<&str> = report.regions.iter().map(|r| r.name.as_str()).collect();
    assert_eq!(names[far], "free end");
    let is_beyond = |r: &usize| report.regions[*r].center[0] > 0.25;
    for region in (0..report.regions.len()).filter(is_beyond) {
        assert!(stiffness(&report, region) > 0.95, "{}", names[region]);
    }
    let is_moved = |r: &usize| report.regions[*r].center[0] < 0.15;
    for region in (0..report.regions.len()).filter(is_moved) {
        assert!(stiffness(&report, region) < 1.0 / 3.0, "{}", names[region]);
    }
    // The part that swings when both hands shake is the uncertain one.
    let shake = report.motions.iter().find(|m| m.motion == "shake").unwrap();
    assert!(shake.sd_m > 0.2 * shake.prior_sd_m, "{shake:?}");
    let largest = |values: &[f32]| {
        (0..values.len()).max_by(|a, b| values[*a].total_cmp(&values[*b])).unwrap()
    };
    assert!(largest(&report.point_sd_m) >= 72, "the tip: {:?}", report.point_sd_m);
    assert!(report.summary.iter().any(|s| s.starts_with("Record next")), "{:?}", report.summary);
    // Shaking the part that moved already would be less informative than moving the other.
    assert!(report.next[0].sd_m < 0.5 * report.sd_m(), "{:?}", report.next);
    report.check(80, 80).unwrap();
    assert_eq!((report.node_regions.len(), report.point_sd_m.len()), (80, 80));
}

#[test]
fn the_recording_to_make_next_moves_what_is_open() {
    let twin = strip(true);
    let capture = record(&twin, 31, 31, lift);
    let first = report(&twin, &capture);
    let best = &first.next[0];
    assert!(best.sd_m < 0.7 * first.sd_m(), "{:?}", first.next);
    // The prediction of it comes true: with such a recording less is left open, first of all where most
    // was.
    let mut both = capture;
    both.others.push(record(&twin, 31, 31, lift_and_shake));
    let second = report(&twin, &both);
    let far = first.regions.len() - 1;
    assert!(stiffness(&second, far) < 0.7 * stiffness(&first, far));
    assert!(second.sd_m() < 0.7 * first.sd_m(), "{} {}", second.sd_m(), first.sd_m());
    for (one, two) in first.groups.iter().zip(&second.groups) {
        assert!(two.relative_sd <= one.relative_sd + 1e-6, "{one:?} {two:?}");
    }
}

#[test]
fn frames_after_the_training_frames_are_asked_about() {
    let twin = strip(true);
    let capture = record(&twin, 41, 21, lift_and_shake);
    let one = report(&twin, &capture);
    let future = &one.motions[0];
    assert_eq!(future.motion, "future");
    assert!(future.sd_m > 0.0 && future.sd_m < future.prior_sd_m, "{future:?}");
    assert!(one.expected_error_m.unwrap() >= future.sd_m);
    assert_eq!(report(&twin, &capture), one, "nothing is random");
}

#[test]
fn a_capture_without_training_frames_says_nothing() {
    let twin = strip(false);
    let capture = record(&twin, 11, 0, lift);
    let cancel = CancelToken::default();
    assert_eq!(identify(&*cpu_with_threads(1), &twin, &capture, &cancel).unwrap(), None);
    let cancelled = CancelToken::default();
    cancelled.cancel();
    assert!(identify(&*cpu_with_threads(1), &twin, &capture, &cancelled).is_err());
}

#[test]
fn a_twin_that_nothing_holds_has_a_report() {
    let mut twin = strip(true);
    twin.graph.control_rest.clear();
    twin.control_hands.clear();
    let held = twin.graph.springs.iter().filter(|s| s[1] < 80).count();
    twin.graph.springs.truncate(held);
    twin.params.spring_stiffness.truncate(held);
    twin.params.spring_dashpot.truncate(held);
    twin.params.rest_lengths_m.truncate(held);
    let capture = record(&twin, 11, 11, lift);
    let report = report(&twin, &capture);
    assert!(report.groups.iter().all(|g| g.quantity != Quantity::Grip));
    assert!(report.next.iter().any(|n| n.motion == "far_shake"), "{:?}", report.next);
}
