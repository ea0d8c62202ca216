use super::*;

/// Two sheets of 10 by 10 points, 2 cm apart, the second 6 cm above the first.
fn slab() -> Vec<Vector3<f64>> {
    let at = |i: usize| {
        Vector3::new(0.02 * (i % 10) as f64, 0.02 * (i / 10 % 10) as f64, 0.06 * (i / 100) as f64)
    };
    (0..200).map(at).collect()
}

#[test]
fn the_far_side_of_a_slab_is_hidden() {
    let skin = slab();
    let above = [Vector3::new(0.09, 0.09, 2.0)];
    let seen = visible(&skin, &above);
    assert!(skin[100..].iter().all(|p| seen.contains(p)));
    assert!(seen.len() < 120, "{}", seen.len());
    assert_eq!(visible(&skin, &[]), skin);
    assert!(visible(&[], &above).is_empty());
}

#[test]
fn a_part_of_many_points_stands_for_them() {
    let fine = |p: Vector3<f64>| {
        (0..25)
            .map(move |i| p + Vector3::new(0.004 * f64::from(i % 5), 0.004 * f64::from(i / 5), 0.0))
    };
    let skin: Vec<Vector3<f64>> = slab().into_iter().flat_map(fine).collect();
    let seen = visible(&skin, &[Vector3::new(0.09, 0.09, 2.0)]);
    assert!(seen.len() <= MOST);
    let above = seen.iter().filter(|p| p.z > 0.03).count();
    let all = thinned(&skin, MOST).iter().filter(|p| p.z > 0.03).count();
    assert_eq!(above, all);
    assert!(5 * (seen.len() - above) < all, "{above} of {}", seen.len());
}
