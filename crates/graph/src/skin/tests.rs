use bendtwin_core::{NodeKind, geometry::point_distance};
use proptest::prelude::*;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::*;

/// A graph of nodes with springs between those nearer than a distance.
fn graph(positions: Vec<Point>, reach_m: f64) -> Graph {
    let n = positions.len() as u32;
    let near =
        |&[a, b]: &[u32; 2]| point_distance(positions[a as usize], positions[b as usize]) < reach_m;
    let pairs = (0..n).flat_map(|a| (a + 1..n).map(move |b| [a, b]));
    let springs = pairs.filter(near).collect();
    Graph {
        kinds: vec![NodeKind::Observed; n as usize],
        masses: vec![1.0; n as usize],
        object_ids: vec![0; n as usize],
        observed_points: (0..n).collect(),
        springs,
        rest_positions: positions,
        ..Graph::default()
    }
}

fn surface(positions: Vec<Point>) -> SurfacePoints {
    SurfacePoints { observed_points: (0..positions.len() as u32).collect(), positions }
}

/// A grid of nodes, 2 cm apart, with the given counts along each axis.
fn grid(counts: [u32; 3]) -> Vec<Point> {
    let at = |i: u32| 0.02 * i as f32;
    let [nx, ny, nz] = counts;
    (0..nx)
        .flat_map(|x| (0..ny).flat_map(move |y| (0..nz).map(move |z| [at(x), at(y), at(z)])))
        .collect()
}

fn bound(nodes: Vec<Point>, points: Vec<Point>) -> (Graph, Skin) {
    let graph = graph(nodes, 0.04);
    let skin = bind_skin(&graph, &surface(points));
    assert_eq!(skin.check(graph.node_count()), Ok(()));
    (graph, skin)
}

/// Points are where they were bound, in any surroundings.
#[track_caller]
fn is_at(skin: &Skin, nodes: &[Point], expected: &[Point]) {
    for (m, (found, expected)) in skin.positions(nodes).iter().zip(expected).enumerate() {
        let off = point_distance(*found, *expected);
        assert!(off < 2e-6, "point {m} is {off} m off");
    }
}

/// A rotation about an oblique axis, and a shift.
fn turned(p: Point) -> Point {
    let axis = nalgebra::Unit::new_normalize(nalgebra::Vector3::new(0.3, -0.5, 0.8));
    let turn = nalgebra::Rotation3::from_axis_angle(&axis, 1.1);
    let q = turn * nalgebra::Vector3::from(p.map(f64::from));
    [q.x + 0.2, q.y - 0.1, q.z + 0.3].map(|x| x as f32)
}

fn map(points: &[Point], by: impl Fn(Point) -> Point) -> Vec<Point> {
    points.iter().map(|p| by(*p)).collect()
}

proptest! {
    /// Inside a body no offset is left, and every affine motion is followed.
    #[test]
    fn a_body_carries_its_points_affinely(
        points in prop::collection::vec([0.01..0.09_f32, 0.01..0.09, 0.01..0.05], 1..20),
        rows in [[-1.0..1.0_f32, -1.0..1.0, -1.0..1.0], [-1.0..1.0, -1.0..1.0, -1.0..1.0],
                 [-1.0..1.0, -1.0..1.0, -1.0..1.0]],
    ) {
        let (graph, skin) = bound(grid([6, 6, 4]), points.clone());
        is_at(&skin, &graph.rest_positions, &points);
        let affine = |p: Point| -> Point {
            std::array::from_fn(|i| 0.1 + (0..3).map(|k| rows[i][k] * p[k]).sum::<f32>())
        };
        prop_assert!(skin.offsets_m.iter().all(|o| *o == [0.0; 3]));
        is_at(&skin, &map(&graph.rest_positions, affine), &map(&points, affine));
    }
}

/// Above a sheet the height is an offset, which turns with the sheet.
#[test]
fn a_flat_neighbourhood_carries_heights_in_its_frame() {
    let points = vec![[0.05, 0.05, 0.004], [0.03, 0.07, -0.006], [0.052, 0.01, 0.0]];
    let (graph, skin) = bound(grid([7, 7, 1]), points.clone());
    is_at(&skin, &graph.rest_positions, &points);
    assert!(skin.frames[..2].iter().all(|f| f[0] != Skin::NO_FRAME));
    assert_eq!(skin.offsets_m[2], [0.0; 3], "a point in the sheet has none");
    is_at(&skin, &map(&graph.rest_positions, turned), &map(&points, turned));
    // No weight is large where the sheet says nothing.
    assert!(skin.weights.iter().all(|w| w.abs() < 2.0));
}

/// Beside a line there is no frame: the offset keeps its direction in the world.
#[test]
fn a_thin_neighbourhood_carries_points_along() {
    let points = vec![[0.05, 0.003, 0.001], [0.071, 0.0, 0.0]];
    let (graph, skin) = bound(grid([9, 1, 1]), points.clone());
    is_at(&skin, &graph.rest_positions, &points);
    assert_eq!(skin.frames[0][0], Skin::NO_FRAME);
    let shifted = |p: Point| [p[0] + 0.3, p[1] - 0.1, p[2]];
    is_at(&skin, &map(&graph.rest_positions, shifted), &map(&points, shifted));
    // Stretched along itself, the line takes points along.
    let stretched = |p: Point| [1.2 * p[0], p[1], p[2]];
    is_at(&skin, &map(&graph.rest_positions, stretched), &map(&points, stretched));
}

#[test]
fn one_node_carries_everything() {
    let points = vec![[0.1, 0.2, 0.3], [0.0; 3]];
    let (graph, skin) = bound(vec![[0.0; 3]], points.clone());
    is_at(&skin, &graph.rest_positions, &points);
    is_at(&skin, &[[1.0, 0.0, 0.0]], &[[1.1, 0.2, 0.3], [1.0, 0.0, 0.0]]);
}

#[test]
fn without_nodes_there_is_no_skin() {
    assert!(bind_skin(&Graph::default(), &surface(vec![[0.0; 3]])).is_empty());
}

/// A point far off hangs on by its offset; weights stay small, so noise of nodes does not grow with
/// the distance.
#[test]
fn points_far_off_do_not_amplify_noise() {
    let points = vec![[2.0, 0.3, 0.4], [-0.5, -0.5, -0.5]];
    let (graph, skin) = bound(grid([5, 5, 4]), points.clone());
    is_at(&skin, &graph.rest_positions, &points);
    assert!(skin.weights.iter().all(|w| w.abs() < 2.0), "{:?}", skin.weights);
    is_at(&skin, &map(&graph.rest_positions, turned), &map(&points, turned));
}

/// A point on one of two leaves that touch is carried by that leaf alone.
#[test]
fn what_touches_does_not_carry() {
    let mut nodes = grid([6, 6, 1]);
    let leaf = nodes.len();
    nodes.extend(grid([6, 6, 1]).iter().map(|p| [p[0], p[1], 0.005]));
    let mut graph = graph(nodes, 0.04);
    graph.springs.retain(|s| {
        (s[0] as usize) < leaf && (s[1] as usize) < leaf || s.iter().all(|&i| i as usize >= leaf)
    });
    let skin = bind_skin(&graph, &surface(vec![[0.05, 0.05, 0.001], [0.05, 0.05, 0.0045]]));
    let carriers = |m| skin.weights_of(m).map(|(i, _)| i as usize).collect::<Vec<_>>();
    assert!(carriers(0).iter().all(|&i| i < leaf), "{:?}", carriers(0));
    assert!(carriers(1).iter().all(|&i| i >= leaf), "{:?}", carriers(1));
}

/// Nodes of the surface are its points, with weight 1.
#[test]
fn points_at_nodes_are_these_nodes() {
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    let nodes: Vec<Point> =
        (0..40).map(|_| std::array::from_fn(|_| 0.1 * rng.random::<f32>())).collect();
    let (graph, skin) = bound(nodes.clone(), nodes);
    assert!(skin.is_nodes(&graph));
}

#[test]
fn nodes_in_one_place_carry_a_point_beside_them() {
    let nodes = vec![[1.0; 3]; 40];
    let (_, skin) = bound(nodes.clone(), vec![[1.0, 1.0, 1.5]]);
    is_at(&skin, &nodes, &[[1.0, 1.0, 1.5]]);
    is_at(&skin, &[[2.0; 3]; 40], &[[2.0, 2.0, 2.5]]);
}

#[test]
fn points_are_bound_where_the_nodes_are() {
    let graph = graph(grid([6, 3, 3]), 0.04);
    let bent: Vec<Point> =
        graph.rest_positions.iter().map(|p| [p[0], p[1], p[2] + 3.0 * p[0] * p[0]]).collect();
    let points = vec![[0.05, 0.02, 0.02], [0.09, 0.01, 0.06]];
    let bound = bind_points(&graph, &bent, &surface(points.clone()));
    is_at(&bound, &bent, &points);
    assert_ne!(bound, bind_skin(&graph, &surface(points)));
}
