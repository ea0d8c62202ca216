use proptest::prelude::*;

use super::*;

#[test]
fn dense_actions_are_taken_as_they_are() {
    for frame in 0..=7 {
        assert_eq!(Place::of(frame, 7, 8), Place { knot: frame, share: 0.0 });
    }
}

#[test]
fn cubic_passes_through_the_knots_and_is_straight_on_a_line() {
    let knots = [[0.0, 0.0, 0.0], [1.0, 2.0, 0.0], [2.0, 4.0, 0.0], [3.0, 6.0, 0.0]];
    for frame in 0..=30 {
        let p = Curve::Cubic.at(Place::of(frame, 30, 4), 4, |i| knots[i]);
        let x = frame as f32 / 10.0;
        assert!((p[0] - x).abs() < 1e-5 && (p[1] - 2.0 * x).abs() < 1e-5, "{frame}: {p:?}");
    }
}

proptest! {
    #[test]
    fn every_frame_has_a_place(frames in 1usize..5000, knots in 2usize..300, share in 0.0f64..=1.0) {
        let frame = (share * frames as f64) as usize;
        let place = Place::of(frame, frames, knots);
        prop_assert!(place.knot < knots);
        prop_assert!((0.0..1.0).contains(&place.share));
        prop_assert_eq!(Place::of(frames, frames, knots), Place { knot: knots - 1, share: 0.0 });
    }

    #[test]
    fn linear_stays_between_its_knots(a in -1.0f32..1.0, b in -1.0f32..1.0, frame in 0usize..=10) {
        let p = Curve::Linear.at(Place::of(frame, 10, 2), 2, |i| if i == 0 { [a; 3] } else { [b; 3] });
        prop_assert!(p[0] >= a.min(b) - 1e-6 && p[0] <= a.max(b) + 1e-6);
    }
}
