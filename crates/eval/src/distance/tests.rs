use proptest::prelude::*;

use super::*;

fn brute(points: &[Point], nodes: &[Point], distance: impl Fn(Point, Point) -> f64) -> f64 {
    let to_nearest =
        |p: &Point| nodes.iter().map(|n| distance(*p, *n)).fold(f64::INFINITY, f64::min);
    points.iter().map(to_nearest).sum::<f64>() / points.len() as f64
}

fn l1(a: Point, b: Point) -> f64 {
    a.iter().zip(b).map(|(x, y)| f64::from((x - y).abs())).sum()
}

#[test]
fn the_nearest_node_depends_on_the_norm() {
    // (1, 1, 0) is nearer in space, (0, 0, 1.9) along the axes.
    let d = chamfer(&[[0.0; 3]], &[[1.0, 1.0, 0.0], [0.0, 0.0, 1.9]]).unwrap();
    assert!((d.l1_m - 1.9).abs() < 1e-6 && (d.l2_m - 2_f64.sqrt()).abs() < 1e-6, "{d:?}");
}

#[test]
fn nothing_has_no_distance() {
    assert_eq!(chamfer(&[], &[[0.0; 3]]), None);
    assert_eq!(chamfer(&[[0.0; 3]], &[]), None);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn agrees_with_brute_force(
        points in prop::collection::vec(prop::array::uniform3(-1_f32..1.0), 1..20),
        nodes in prop::collection::vec(prop::array::uniform3(-1_f32..1.0), 1..80),
        flat: bool,
    ) {
        // Flat objects, where many coordinates are equal, are the hard case of a k-d tree.
        let nodes: Vec<Point> =
            nodes.into_iter().map(|n| if flat { [n[0], 0.25, n[2]] } else { n }).collect();
        let d = chamfer(&points, &nodes).unwrap();
        prop_assert!((d.l1_m - brute(&points, &nodes, l1)).abs() < 1e-5);
        prop_assert!((d.l2_m - brute(&points, &nodes, euclidean)).abs() < 1e-5);
    }
}
