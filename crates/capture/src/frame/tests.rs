use super::*;

#[test]
fn every_axis_is_turned_up_by_a_rotation() {
    for (axis, up) in [
        ("+x", [1.0, 0.0, 0.0]),
        ("-x", [-1.0, 0.0, 0.0]),
        ("+y", [0.0, 1.0, 0.0]),
        ("-y", [0.0, -1.0, 0.0]),
        ("+z", [0.0, 0.0, 1.0]),
        ("-z", [0.0, 0.0, -1.0]),
    ] {
        let frame = Frame::from_up(axis).unwrap();
        assert!(is_rotation(&frame.rotation), "{axis}");
        assert_eq!(frame.turn(up), [0.0, 0.0, 1.0], "{axis}");
    }
    assert_eq!(Frame::from_up("up"), None);
}

#[test]
fn mirrors_are_no_rotations() {
    let mirror = [[-1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    assert!(!is_rotation(&mirror));
    assert_eq!(determinant(&mirror), -1.0);
    assert_eq!(compose(&mirror, &mirror), IDENTITY);
}

#[test]
fn points_are_scaled_and_turned() {
    let frame = Frame { metres: 0.001, ..Frame::from_up("-z").unwrap() };
    let mut points = vec![[1000.0, 2000.0, -500.0]];
    frame.apply(&mut points);
    assert_eq!(points, [[1.0, -2.0, 0.5]]);
}
