use bendtwin_proto::v1::Tensor;
use proptest::prelude::*;

use super::*;

fn at_s(times: &[f32]) -> Option<KnotTimes> {
    Some(KnotTimes { times: Some(Times::AtS(Tensor::pack(&[times.len()], times))) })
}

fn values(schedule: &Schedule, knots: &[f32]) -> Vec<f32> {
    schedule.places().iter().map(|place| place.at(|k| [knots[k]])[0]).collect()
}

#[test]
fn dense_actions_are_taken_unchanged() {
    for curve in [Curve::Linear, Curve::Cubic, Curve::Hold] {
        let schedule = Schedule::new(curve, 8, 7, None, 30.0).unwrap();
        for (frame, place) in schedule.places().iter().enumerate() {
            assert_eq!((place.knot, place.share), (frame, 0.0));
        }
    }
}

#[test]
fn cubic_passes_through_the_knots_and_is_straight_on_a_line() {
    // At 10 frames a second: knots in frames 0, 5, 20 and 30.
    let at = [0.0, 0.5, 2.0, 3.0];
    let schedule = Schedule::new(Curve::Cubic, 4, 40, at_s(&at), 10.0).unwrap();
    let line: Vec<f32> = at.iter().map(|t| 3.0 - 2.0 * t).collect();
    for (frame, x) in values(&schedule, &line).into_iter().enumerate() {
        let t = (frame as f32 / 10.0).min(3.0);
        assert!((x - (3.0 - 2.0 * t)).abs() < 1e-5, "{frame}: {x}");
    }
    let through = values(&schedule, &[1.0, -1.0, 5.0, 2.0]);
    assert_eq!([0, 5, 20, 30, 40].map(|f: usize| through[f]), [1.0, -1.0, 5.0, 2.0, 2.0]);
}

#[test]
fn cubic_with_even_times_is_catmull_rom() {
    let knots = [0.3, -1.0, 2.0, 0.5, 0.7];
    let even = Schedule::new(Curve::Cubic, 5, 40, None, 30.0).unwrap();
    let timed = Schedule::new(Curve::Cubic, 5, 40, at_s(&[0.0, 1.0, 2.0, 3.0, 4.0]), 10.0).unwrap();
    let (even, timed) = (values(&even, &knots), values(&timed, &knots));
    for (frame, (a, b)) in even.iter().zip(&timed).enumerate() {
        let (i, t) = (frame / 10, (frame % 10) as f32 / 10.0);
        let p = |k: isize| match k {
            -1 => 2.0 * knots[0] - knots[1],
            5 => 2.0 * knots[4] - knots[3],
            k => knots[k as usize],
        };
        let i = i as isize;
        let expected = if t == 0.0 {
            p(i)
        } else {
            let (a, b, c, d) = (p(i - 1), p(i), p(i + 1), p(i + 2));
            let (q, r) = (a - 2.5 * b + 2.0 * c - 0.5 * d, 0.5 * (d - a) + 1.5 * (b - c));
            b + t * (0.5 * (c - a) + t * (q + t * r))
        };
        assert!((a - expected).abs() < 1e-5 && (b - expected).abs() < 1e-5, "{frame}");
    }
}

#[test]
fn a_knot_holds_until_the_next_and_the_last_until_the_end() {
    // 0.1 s at 30 frames a second: three frames, though 3 x 0.1 is not 0.3.
    let times = Some(KnotTimes { times: Some(Times::PeriodS(0.1)) });
    let schedule = Schedule::new(Curve::Hold, 4, 12, times, 30.0).unwrap();
    let expected = [0, 0, 0, 1, 1, 1, 2, 2, 2, 3, 3, 3, 3].map(|k: u8| f32::from(k));
    assert_eq!(values(&schedule, &[0.0, 1.0, 2.0, 3.0]), expected);
}

#[test]
fn an_action_period_may_be_shorter_than_a_frame() {
    let times = Some(KnotTimes { times: Some(Times::PeriodS(0.02)) });
    let schedule = Schedule::new(Curve::Linear, 6, 4, times, 30.0).unwrap();
    let found = values(&schedule, &[0.0, 1.0, 2.0, 3.0, 4.0, 5.0]);
    for (frame, x) in found.iter().enumerate() {
        let expected = (frame as f32 / 30.0 / 0.02).min(5.0);
        assert!((x - expected).abs() < 1e-5, "{frame}: {x}");
    }
}

proptest! {
    #[test]
    fn every_frame_has_a_place(
        frames in 1usize..500,
        gaps in prop::collection::vec(1e-6f32..2.0, 1..30),
        curve in prop::sample::select(vec![Curve::Linear, Curve::Cubic, Curve::Hold]),
        is_even in any::<bool>(),
    ) {
        let mut times = vec![0.0];
        times.extend(gaps.iter().scan(0.0, |t, gap| { *t += gap; Some(*t) }));
        let knots = times.len();
        let times = if is_even { None } else { at_s(&times) };
        let schedule = Schedule::new(curve, knots, frames, times, 30.0).unwrap();
        prop_assert_eq!(schedule.places().len(), frames + 1);
        for place in schedule.places() {
            prop_assert!(place.knot < knots && (0.0..1.0).contains(&place.share));
            let sum: f64 = place.weights().map(|(_, weight)| weight).sum();
            prop_assert!((sum - 1.0).abs() < 1e-9, "{place:?}");
            prop_assert!(place.weights().all(|(k, _)| k < knots));
            // Rows of three values, of which each is what it is alone.
            let value = |k: usize, i: usize| [(k * k + i) as f32, 0.1 * k as f32 - i as f32];
            let rows: Vec<_> = (0..knots).map(|k| [0, 1, 2].map(|i| value(k, i))).collect();
            let mut row = Vec::new();
            place.add_row(|k| &rows[k], &mut row);
            prop_assert_eq!(row, [0, 1, 2].map(|i| place.at(|k| value(k, i))).to_vec());
        }
        if is_even {
            let last = schedule.places()[frames];
            prop_assert_eq!((last.knot, last.share), (knots - 1, 0.0));
        }
    }

    #[test]
    fn linear_stays_between_its_knots(a in -1.0f32..1.0, b in -1.0f32..1.0) {
        let schedule = Schedule::new(Curve::Linear, 2, 10, None, 30.0).unwrap();
        for x in values(&schedule, &[a, b]) {
            prop_assert!(x >= a.min(b) - 1e-6 && x <= a.max(b) + 1e-6);
        }
    }
}
