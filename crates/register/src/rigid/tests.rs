use super::*;
use crate::{scene, surface::spacing};

fn recovered(turn: Rotation3<f64>) -> f64 {
    let model = scene::model();
    let rest = &model.graph.rest_positions;
    let nodes: Vec<Vector3<f64>> = rest.iter().map(|p| vector3(*p)).collect();
    let surface = Surface::new(&nodes, spacing(rest)).unwrap();
    let shift = Vector3::new(0.3, -0.2, 0.5);
    let image: Vec<Point> = nodes.iter().map(|p| point(turn * p + shift)).collect();
    let mut points = scene::noisy(&image, 0.001, 2);
    // A twelfth of them is of something else.
    points.iter_mut().step_by(12).for_each(|p| p[2] += 0.3);
    let target =
        Target { surface: &surface, skin: &nodes, points: &points, known: &[], up: Vector3::z() };
    let best = target.motions(&CancelToken::default()).unwrap()[0];
    let moved: Vec<Point> = rest.iter().map(|p| best.apply(*p)).collect();
    scene::apart(&moved, &image).0
}

#[test]
fn any_turn_is_found_half_turns_too() {
    use std::f64::consts::PI;
    let turns = [
        Vector3::new(0.0, 0.0, PI),
        Vector3::new(PI, 0.0, 0.0),
        Vector3::new(0.0, PI, 0.0),
        Vector3::new(0.0, 0.0, 1.9),
        Vector3::new(1.3, 0.4, -2.0),
        Vector3::zeros(),
    ];
    for turn in turns {
        let error = recovered(Rotation3::new(turn));
        assert!(error < 0.003, "{turn:?}: {error}");
    }
}

#[test]
fn two_tracks_do_not_change_the_turn_about_their_line() {
    let pair = |before: Point, after: Point| Pair { before, after, weight: 1.0 };
    let one = of_tracks(&[pair([0.0; 3], [1.0, 2.0, 3.0])], 0.001).unwrap();
    assert!((one.rotation - Matrix3::identity()).norm() < 1e-9);
    let pairs = [pair([0.0; 3], [0.0; 3]), pair([1.0, 0.0, 0.0], [0.0, 1.0, 0.0])];
    let two = of_tracks(&pairs, 0.001).unwrap();
    assert!((two.rotation * Vector3::z() - Vector3::z()).norm() < 1e-3, "{two:?}");
    assert_eq!(of_tracks(&[], 0.001), None);
}
