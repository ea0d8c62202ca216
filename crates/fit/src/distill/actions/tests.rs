use bendtwin_core::{Contact, Graph, Params, Plane};
use bendtwin_core_kit::twin_of;

use super::*;

/// A twin that two hands of two control points hold, 20 cm apart, 2 cm above the ground.
fn twin() -> Twin {
    let controls = [[0.0, 0.0, 0.02], [0.02, 0.0, 0.02], [0.2, 0.0, 0.02], [0.22, 0.0, 0.02]];
    let graph = Graph { control_rest: controls.to_vec(), ..Graph::default() };
    let params = Params { contact: Contact::default(), ..Params::default() };
    Twin {
        environment: Environment {
            ground: Some(Plane { normal: [0.0, 0.0, 1.0], offset_m: 0.0 }),
            ..Environment::Z_UP
        },
        control_hands: vec![0, 0, 1, 1],
        ..twin_of(graph, params)
    }
}

#[test]
fn actions_begin_at_rest_stay_together_and_are_as_fast_as_hands() {
    let twin = twin();
    let hands = Hands::new(&twin, None);
    let actions = hands.actions(16, 1, 0);
    let mut moved = 0.0_f64;
    for action in &actions {
        assert_eq!(action.controls.len(), (LENGTH + 1) * 4);
        assert_eq!(&action.controls[..4], &twin.graph.control_rest[..]);
        for frame in action.controls.chunks(4) {
            let at = |c: usize| wide(frame[c]);
            assert!((distance(at(0), at(1)) - 0.02).abs() < 1e-5, "a hand is rigid");
            let apart = distance(at(1), at(2));
            assert!((0.1..0.3).contains(&apart), "{apart}");
            moved = moved.max(distance(at(0), wide(twin.graph.control_rest[0])));
        }
        for (before, after) in action.controls.iter().zip(&action.controls[4..]) {
            let speed = 30.0 * distance(wide(*before), wide(*after));
            // A smooth way between knots is faster than its mean, and hands turn.
            assert!(speed < 4.0 * SPEED, "{speed}");
        }
    }
    assert!(moved > 0.1, "{moved}");
}

#[test]
fn hands_stay_above_the_ground() {
    let hands = Hands::new(&twin(), None);
    let lowest =
        |action: &Action| action.controls.iter().map(|p| p[2]).fold(f32::INFINITY, f32::min);
    let least = hands.actions(32, 7, 0).iter().map(lowest).fold(f32::INFINITY, f32::min);
    // They turn about their middle, which a control point is a centimetre from.
    assert!(least > -0.011, "{least}");
}

#[test]
fn seeds_and_streams_have_distinct_actions() {
    let hands = Hands::new(&twin(), None);
    let first = |seed, stream| hands.actions(1, seed, stream).remove(0).controls;
    assert_eq!(first(1, 0), first(1, 0));
    assert_ne!(first(1, 0), first(2, 0));
    assert_ne!(first(1, 0), first(1, 1));
}
