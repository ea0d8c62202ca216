use super::*;

#[test]
fn the_far_side_of_a_slab_is_hidden() {
    let at = |i: usize| {
        Vector3::new(0.02 * (i % 10) as f64, 0.02 * (i / 10 % 10) as f64, 0.06 * (i / 100) as f64)
    };
    let nodes: Vec<_> = (0..200).map(at).collect();
    let above = [Vector3::new(0.09, 0.09, 2.0)];
    let seen = visible(&nodes, &above, 0.02);
    assert!((100..200).all(|i| seen.contains(&i)));
    assert!(seen.len() < 120, "{}", seen.len());
    assert_eq!(visible(&nodes, &[], 0.02).len(), 200);
    assert!(visible(&[], &above, 0.02).is_empty());
}
