use super::*;

/// A forearm along x, and an object at its end.
fn arm(from_mm: u32, to_mm: u32) -> Vec<Point> {
    (from_mm..to_mm).step_by(2).map(|x| [x as f32 * 1e-3, 0.0, 0.0]).collect()
}

fn contact() -> Contact {
    Contact::new(vec![[0.0; 3], [0.0, 0.005, 0.0]], Vec::new())
}

#[test]
fn control_points_lie_where_the_hand_meets_the_object() {
    let places = arm(1, 300);
    let (picked, distances) = contact().choose(&places, 30);
    // Within the reach there are 10 places, all of which hold.
    assert_eq!((picked.len(), holding(&distances)), (10, 10));
    // More than enough are near: the choice is spread over them, and no distant point is chosen.
    let (picked, distances) = contact().choose(&places, 3);
    assert_eq!(picked.len(), 3);
    assert!(distances.iter().all(|d| *d <= NEAR_M + 1e-6), "{distances:?}");
}

#[test]
fn a_hand_that_is_far_away_keeps_its_nearest_points() {
    let places = arm(60, 300);
    let (mut picked, distances) = contact().choose(&places, 30);
    picked.sort_unstable();
    assert_eq!((picked, holding(&distances)), (vec![0, 1, 2, 3], 0));
}

#[test]
fn without_an_object_all_places_count() {
    let places = arm(0, 300);
    let (picked, distances) = Contact::new(Vec::new(), Vec::new()).choose(&places, 30);
    assert_eq!((picked.len(), holding(&distances)), (30, 0));
    assert_eq!(Contact::new(Vec::new(), Vec::new()).choose(&[], 3), (vec![], vec![]));
}
