use bendtwin_core::{NodeKind, geometry::distance};

use super::{
    rotation::{nearest_rotation, normalized},
    *,
};

/// A graph of nodes at these places with these springs.
fn graph(rest: &[Point], springs: &[[u32; 2]]) -> Graph {
    let n = rest.len();
    Graph {
        rest_positions: rest.to_vec(),
        kinds: vec![NodeKind::Observed; n],
        masses: vec![1.0; n],
        object_ids: vec![0; n],
        observed_points: vec![Graph::NOT_OBSERVED; n],
        springs: springs.to_vec(),
        ..Graph::default()
    }
}

fn cube() -> Graph {
    let corner = |i: u32| [i & 1, i >> 1 & 1, i >> 2].map(|x| x as f32 * 0.1);
    let rest: Vec<Point> = (0..8).map(corner).collect();
    let springs: Vec<[u32; 2]> = (0..8).flat_map(|a| (0..a).map(move |b| [a, b])).collect();
    graph(&rest, &springs)
}

fn middle(graph: &Graph) -> Skin {
    let mut skin = Skin::default();
    let n = graph.node_count();
    let weights: Vec<(u32, f32)> = (0..n as u32).map(|i| (i, 1.0 / n as f32)).collect();
    skin.push(u32::MAX, &weights, [Skin::NO_FRAME; 3], [0.0; 3]);
    skin
}

fn about(axis: [f64; 3], angle: f64) -> [f64; 4] {
    let length = axis.iter().map(|x| x * x).sum::<f64>().sqrt();
    let s = (0.5 * angle).sin() / length;
    [axis[0] * s, axis[1] * s, axis[2] * s, (0.5 * angle).cos()]
}

fn moved(graph: &Graph, q: [f64; 4], by: Vector) -> Vec<Point> {
    let place = |x: &Point| add(turn(q, wide(*x)), by).map(|x| x as f32);
    graph.rest_positions.iter().map(place).collect()
}

/// Largest difference of two rotations; a quaternion and its opposite are one.
fn difference(a: [f32; 4], b: [f64; 4]) -> f64 {
    let off = |sign: f64| (0..4).map(|k| (f64::from(a[k]) - sign * b[k]).abs()).fold(0.0, f64::max);
    off(1.0).min(off(-1.0))
}

#[test]
fn at_rest_nothing_turns() {
    let graph = cube();
    let carrier = Carrier::new(&graph, &middle(&graph)).unwrap();
    let carried = carrier.at(&graph.rest_positions).unwrap();
    assert!(difference(carried.rotations[0], rotation::IDENTITY) < 1e-6);
    assert_eq!(carried.means_m, carried.rest_means_m);
}

#[test]
fn rigid_motions_carry_exactly() {
    let graph = cube();
    let carrier = Carrier::new(&graph, &middle(&graph)).unwrap();
    for k in 1..=17 {
        let q = about([0.3, -0.5, 0.8], f64::from(k) * 10.0_f64.to_radians());
        let carried = carrier.at(&moved(&graph, q, [0.1, 0.2, 0.3])).unwrap();
        assert!(difference(carried.rotations[0], q) < 1e-5, "{k}: {:?}", carried.rotations[0]);
        let expected = add(turn(q, [0.05; 3]), [0.1, 0.2, 0.3]);
        assert!(distance(wide(carried.means_m[0]), expected) < 1e-6);
    }
}

#[test]
fn a_line_keeps_its_roll() {
    let rest: Vec<Point> = (0..5).map(|i| [i as f32 * 0.1, 0.0, 0.0]).collect();
    let springs: Vec<[u32; 2]> = (1..5).map(|i| [i - 1, i]).collect();
    let graph = graph(&rest, &springs);
    let carrier = Carrier::new(&graph, &middle(&graph)).unwrap();
    // The shortest rotation of x to y is about z.
    let along_y: Vec<Point> = (0..5).map(|i| [0.0, i as f32 * 0.1, 0.0]).collect();
    let carried = carrier.at(&along_y).unwrap();
    let expected = about([0.0, 0.0, 1.0], std::f64::consts::FRAC_PI_2);
    assert!(difference(carried.rotations[0], expected) < 1e-6, "{:?}", carried.rotations[0]);
}

#[test]
fn the_nearest_rotation_ignores_stretch() {
    let q = about([1.0, 2.0, -1.0], 1.2);
    let stretch = [[2.0, 0.3, 0.0], [0.3, 1.0, 0.1], [0.0, 0.1, 0.2]];
    let columns: [Vector; 3] = stretch.map(|c| turn(q, c));
    let a = [0, 1, 2].map(|i| [0, 1, 2].map(|k| columns[k][i]));
    assert!(difference(nearest_rotation(&a).map(|x| x as f32), q) < 1e-6);
    assert_eq!(nearest_rotation(&[[0.0; 3]; 3]), rotation::IDENTITY);
    assert!(nearest_rotation(&[[f64::MAX; 3]; 3]).iter().all(|x| x.is_finite()));
}

#[test]
fn the_adjoint_is_that_of_placing() {
    let graph = cube();
    let carrier = Carrier::new(&graph, &middle(&graph)).unwrap();
    let q = about([0.3, -0.5, 0.8], 0.9);
    let carried = carrier.at(&moved(&graph, q, [0.1, 0.2, 0.3])).unwrap();
    let rest = Gaussians {
        means_m: vec![[0.06, 0.04, 0.05]],
        scales_m: vec![[0.01; 3]],
        rotations: vec![[0.5, -0.1, 0.2, 0.8]],
        opacities: vec![0.5],
        colors: vec![[0.5; 3]],
    };
    let bar = GaussiansBar {
        means_m: vec![[1.0, -2.0, 0.5]],
        rotations: vec![[0.3, 0.7, -0.4, 0.2]],
        ..GaussiansBar::zeros(1)
    };
    let loss = |g: &Gaussians| {
        let placed = carried.place(g).unwrap();
        let means = (0..3).map(|k| f64::from(placed.means_m[0][k] * bar.means_m[0][k]));
        let turns = (0..4).map(|k| f64::from(placed.rotations[0][k] * bar.rotations[0][k]));
        means.chain(turns).sum::<f64>()
    };
    let got = carried.adjoint(&bar).unwrap();
    // Linear: a whole unit is a difference without truncation; f32 rounds at 1e-6.
    let base = loss(&rest);
    for k in 0..3 {
        let mut other = rest.clone();
        other.means_m[0][k] += 1.0;
        assert!((loss(&other) - base - f64::from(got.means_m[0][k])).abs() < 1e-5);
    }
    for k in 0..4 {
        let mut other = rest.clone();
        other.rotations[0][k] += 1.0;
        assert!((loss(&other) - base - f64::from(got.rotations[0][k])).abs() < 1e-5);
    }
}

#[test]
fn wrong_nodes_are_refused() {
    let graph = cube();
    let carrier = Carrier::new(&graph, &middle(&graph)).unwrap();
    assert!(carrier.at(&graph.rest_positions[1..]).is_err());
    let mut nodes = graph.rest_positions.clone();
    nodes[3][1] = f32::NAN;
    assert!(carrier.at(&nodes).unwrap_err().to_string().contains("node 3"));
    let carried = carrier.at(&graph.rest_positions).unwrap();
    assert!(carried.place(&Gaussians::default()).is_err());
    assert!(normalized([0.0; 4]).is_none());
}
