use super::*;

fn line(count: usize, step_m: f32) -> Vec<Point> {
    (0..count).map(|i| [i as f32 * step_m, 0.0, 0.0]).collect()
}

#[test]
fn the_worthiest_track_of_a_spot_stays() {
    let points = line(6, 0.002);
    let tracks = Tracks { count: 6, frames: 1, seen: vec![true; 6], points, colors: Vec::new() };
    assert_eq!(one_per_spot(&tracks, &[1, 9, 1, 1, 9, 1], 0.003), [1, 4]);
    assert_eq!(one_per_spot(&tracks, &[1; 6], 0.003), [0, 2, 4]);
    assert_eq!(one_per_spot(&tracks, &[1; 6], 0.0), [0, 1, 2, 3, 4, 5]);
}

#[test]
fn the_farthest_points_come_first() {
    assert_eq!(farthest_first(&line(11, 0.1), 3), [0, 10, 5]);
    assert_eq!(farthest_first(&line(2, 0.1), 5).len(), 2);
    assert!(farthest_first(&[], 5).is_empty());
    assert_eq!(farthest_first(&[[1.0; 3]; 4], 3), [0, 1, 2], "equal points are distinguished");
}
