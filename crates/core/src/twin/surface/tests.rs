use std::collections::HashMap;

use super::*;

/// A surface that is a tube along nodes.
fn tube(nodes: &[u32], radius_m: f32) -> Surface {
    Surface { tubes: vec![Tube { nodes: nodes.to_vec(), radius_m }], ..Surface::default() }
}

/// Volume between the faces and the origin [m³], and whether every edge has two faces, one each way.
fn closed_volume(surface: &Surface, nodes: &[Point]) -> (f64, bool) {
    let (at, faces) = (surface.positions(nodes), surface.faces());
    assert_eq!(at.len(), surface.vertex_count());
    let mut edges: HashMap<[u32; 2], i32> = HashMap::new();
    let mut volume = 0.0;
    for [a, b, c] in faces {
        for edge in [[a, b], [b, c], [c, a]] {
            *edges.entry(edge).or_default() += 1;
        }
        let [p, q, r] = [a, b, c].map(|i| wide(at[i as usize]));
        volume += dot(p, cross(q, r)) / 6.0;
    }
    let is_closed = edges.iter().all(|(&[a, b], n)| *n == 1 && edges.get(&[b, a]) == Some(&1));
    (volume, is_closed)
}

/// The volume of a prism with the section of a tube, over its length and the square of its radius.
fn section() -> f64 {
    let n = f64::from(AROUND);
    n / 2.0 * (std::f64::consts::TAU / n).sin()
}

#[test]
fn a_tube_is_closed_and_has_its_volume() {
    let nodes = [[0.0, 0.0, 0.1], [0.1, 0.0, 0.1], [0.2, 0.0, 0.1], [0.3, 0.0, 0.1]];
    let (volume, is_closed) = closed_volume(&tube(&[0, 1, 2, 3], 0.01), &nodes);
    assert!(is_closed);
    assert!((volume / (0.3 * 1e-4 * section()) - 1.0).abs() < 1e-4, "{volume}");
}

#[test]
fn a_closed_tube_has_no_ends() {
    let nodes: Vec<Point> = (0..40)
        .map(|k| {
            let angle = std::f32::consts::TAU * k as f32 / 40.0;
            [0.1 * angle.cos(), 0.1 * angle.sin(), 0.2]
        })
        .collect();
    let around: Vec<u32> = (0..40).chain([0]).collect();
    let (volume, is_closed) = closed_volume(&tube(&around, 0.005), &nodes);
    assert!(is_closed);
    let expected = std::f64::consts::TAU * 0.1 * 25e-6 * section();
    assert!((volume / expected - 1.0).abs() < 0.02, "{volume} of {expected}");
}

/// Nodes in one place, and a cable that turns back, have no direction.
#[test]
fn a_tube_without_direction_is_finite() {
    for nodes in [[[0.1; 3]; 3], [[0.0; 3], [0.0, 0.0, 1.0], [0.0; 3]]] {
        let positions = tube(&[0, 1, 2], 0.01).positions(&nodes);
        assert!(positions.iter().flatten().all(|x| x.is_finite()), "{positions:?}");
    }
}

#[test]
fn contradictions_are_found() {
    let carried = Surface { carriers: Skin::at_nodes(&[0, 1, 2]), ..Surface::default() };
    let triangles = vec![[0, 1, 2]];
    let right = Surface { triangles, colors: vec![[1, 2, 3]; 3], ..carried };
    right.check(3).unwrap();
    let wrong = [
        (Surface { triangles: vec![[0, 1, 3]], ..right.clone() }, "corner 3"),
        (Surface { colors: vec![[0; 3]; 2], ..right.clone() }, "2 colours for 3"),
        (tube(&[0], 0.01), "two or more"),
        (tube(&[0, 3], 0.01), "two or more of 3"),
        (tube(&[0, 1], 0.0), "radius"),
        (tube(&[0, 1], f32::NAN), "radius"),
    ];
    for (surface, why) in wrong {
        let found = surface.check(3).unwrap_err();
        assert!(found.contains(why), "{found}");
    }
    assert!(right.check(2).is_err());
}
