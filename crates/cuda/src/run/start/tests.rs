use super::*;

fn state(twists: &[f32]) -> State {
    let points = |z: f32| vec![[1.0, 2.0, z], [4.0, 5.0, z]];
    State {
        positions: points(3.0),
        velocities: points(6.0),
        twists: twists.to_vec(),
        ..State::default()
    }
}

/// A fit compares a model with rods and one without from the same state, and leaves its twists
/// open.
#[test]
fn models_that_share_a_state_have_separate_twists() {
    let (untwisted, twisted) = (state(&[]), state(&[0.5, -0.5]));
    let shared = [(&untwisted, 0), (&untwisted, 2), (&twisted, 2), (&untwisted, 2)];
    let (planes, places) = initial_planes(shared.into_iter());
    assert_eq!(places[1], places[3], "the same state of models alike is there once");
    for ((at, twists_at), (state, rods)) in places.into_iter().zip(shared) {
        assert_eq!(planes[at..at + 4], [1.0, 4.0, 2.0, 5.0]);
        let expected: Vec<f32> =
            if state.twists.is_empty() { vec![0.0; rods] } else { state.twists.clone() };
        assert_eq!(planes[twists_at..twists_at + rods], expected);
    }
    assert_eq!(planes.len(), 3 * 12 + 4);
}
