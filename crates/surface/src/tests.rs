use std::collections::HashMap;

use bendtwin_core::{
    Params, Pin, Timing, Tube,
    geometry::{cross, distance, dot, length, scaled, sub, wide},
};
use rand::{RngExt as _, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::*;

type Field = fn([f64; 3]) -> f64;

/// A toy's belly, head and limbs: signed distance of a place [m].
fn toy(p: [f64; 3]) -> f64 {
    let segment = |a: [f64; 3], b: [f64; 3], radius: f64| {
        let (along, to) = (sub(b, a), sub(p, a));
        let share = (dot(to, along) / dot(along, along)).clamp(0.0, 1.0);
        length(sub(to, scaled(along, share))) - radius
    };
    let belly = segment([-0.03, 0.0, 0.05], [0.03, 0.0, 0.05], 0.04);
    let head = length(sub(p, [0.09, 0.0, 0.06])) - 0.032;
    let limbs = [[0.05, 0.1], [0.05, -0.1], [-0.06, 0.09], [-0.06, -0.09]]
        .map(|[x, y]| segment([0.6 * x, 0.3 * y, 0.04], [x, y, 0.02], 0.015));
    limbs.into_iter().fold(belly.min(head), f64::min)
}

/// A ring with a hole of 4 cm.
fn ring(p: [f64; 3]) -> f64 {
    length([length([p[0], p[1], 0.0]) - 0.04, p[2], 0.0]) - 0.015
}

/// A cloth of 20 cm, 1 mm thick.
fn cloth(p: [f64; 3]) -> f64 {
    let beyond = [p[0].abs() - 0.1, p[1].abs() - 0.1, (p[2] - 0.01 * (20.0 * p[0]).sin()).abs()];
    length(beyond.map(|x| x.max(0.0))) - 0.0005
}

/// Points of the surface of a body, as many as asked for and evenly spread, with noise of `noise_m`.
fn scattered(field: Field, count: usize, noise_m: f64, seed: u64) -> Vec<Point> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut all: Vec<Point> = Vec::new();
    while all.len() < 20 * count {
        let mut p = [0; 3].map(|_: i32| rng.random_range(-0.15..0.15));
        // From afar few would come to hollows.
        if field(p).abs() > 0.01 {
            continue;
        }
        for _ in 0..8 {
            let step = 1e-5;
            let slope: [f64; 3] = std::array::from_fn(|a| {
                let mut q = p;
                q[a] += step;
                (field(q) - field(p)) / step
            });
            p = sub(p, scaled(slope, field(p) / dot(slope, slope).max(1e-6)));
        }
        if field(p).abs() < 1e-4 {
            all.push(p.map(|x| x as f32));
        }
    }
    let every: Vec<usize> = (0..all.len()).collect();
    let mut chosen = Vec::new();
    bendtwin_graph::farthest_points(&all, &every, &mut chosen, count, 0);
    let mut noise = |x: f32| x + (noise_m * rng.random_range(-1.7..1.7)) as f32;
    chosen.into_iter().map(|i| all[i].map(&mut noise)).collect()
}

/// Checks that a mesh is closed and faces outwards, and that most of it is within `most_m` of a surface.
fn assert_true(mesh: &Wrapped, field: Field, most_m: f64) {
    let mut edges: HashMap<[u32; 2], u32> = HashMap::new();
    let mut volume = 0.0;
    for &[a, b, c] in &mesh.triangles {
        for edge in [[a, b], [b, c], [c, a]] {
            *edges.entry(edge).or_default() += 1;
        }
        let [p, q, r] = [a, b, c].map(|i| wide(mesh.vertices[i as usize]));
        volume += dot(p, cross(q, r)) / 6.0;
    }
    assert!(!mesh.triangles.is_empty());
    let open = edges.iter().filter(|&(&[a, b], n)| *n != 1 || edges.get(&[b, a]) != Some(&1));
    assert_eq!(open.count(), 0, "every edge has two triangles, which run along it both ways");
    assert!(volume > 0.0, "triangles face outwards");
    let mut off: Vec<f64> = mesh.vertices.iter().map(|v| field(wide(*v)).abs()).collect();
    off.sort_by(f64::total_cmp);
    let p95 = off[off.len() * 95 / 100];
    assert!(
        p95 < most_m,
        "95 % within {:.2} mm, the farthest {:.2}",
        p95 * 1e3,
        off[off.len() - 1] * 1e3
    );
    // And all of the surface is there.
    let mut far: Vec<f64> = scattered(field, 300, 0.0, 99)
        .iter()
        .map(|p| {
            let to = |v: &Point| distance(wide(*v), wide(*p));
            mesh.vertices.iter().map(to).fold(f64::INFINITY, f64::min)
        })
        .collect();
    far.sort_by(f64::total_cmp);
    let missing = far[far.len() * 95 / 100];
    assert!(missing < 2.0 * most_m, "95 % of the surface within {:.2} mm", missing * 1e3);
}

/// Points inside a body.
fn inner(field: Field, depth_m: f64) -> Vec<Point> {
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    let place = || [0; 3].map(|_: i32| rng.random_range(-0.15..0.15));
    let places = std::iter::repeat_with(place).take(100_000);
    places.filter(|p| field(*p) < -depth_m).take(200).map(|p| p.map(|x| x as f32)).collect()
}

#[test]
fn a_toy_has_its_surface() {
    for (count, noise_m) in [(600, 0.0), (600, 0.0015), (4000, 0.001)] {
        let points = scattered(toy, count, noise_m, 1);
        assert_true(&wrap(&points, &inner(toy, 0.008)).unwrap(), toy, 0.004);
        assert_true(&wrap(&points, &[]).unwrap(), toy, 0.004);
    }
}

#[test]
fn a_ring_keeps_its_hole() {
    let mesh = wrap(&scattered(ring, 500, 0.0005, 2), &[]).unwrap();
    assert_true(&mesh, ring, 0.003);
    // Euler's number of a closed surface with a hole.
    assert_eq!(mesh.vertices.len() as i64 - mesh.triangles.len() as i64 / 2, 0);
}

#[test]
fn a_cloth_is_thin_and_closed() {
    assert_true(&wrap(&scattered(cloth, 1500, 0.0, 3), &[]).unwrap(), cloth, 0.004);
}

/// No camera saw the lower side.
#[test]
fn a_gap_is_closed() {
    let mut points = scattered(toy, 1500, 0.0005, 4);
    points.retain(|p| p[2] > 0.035 || p[0].abs() > 0.04);
    assert_true(&wrap(&points, &inner(toy, 0.008)).unwrap(), toy, 0.015);
}

#[test]
fn points_apart_by_error_are_left_out() {
    let mut points = scattered(toy, 800, 0.0, 6);
    points.extend([[0.3, 0.3, 0.3], [0.31, 0.3, 0.3]]);
    assert_true(&wrap(&points, &inner(toy, 0.008)).unwrap(), toy, 0.004);
}

#[test]
fn points_without_a_surface_have_none() {
    assert_eq!(wrap(&[], &[]), None);
    assert_eq!(wrap(&[[0.1; 3]; 7], &[]), None);
    assert_eq!(wrap(&[[0.1; 3]; 500], &[]), None);
    // The mesh is closed wherever they lie.
    let mut rng = ChaCha8Rng::seed_from_u64(8);
    let cloud: Vec<Point> = (0..300).map(|_| [0; 3].map(|_: i32| rng.random())).collect();
    assert_true(&wrap(&cloud, &[]).unwrap(), |_| 0.0, f64::INFINITY);
    let line: Vec<Point> = (0..100).map(|i| [0.01 * i as f32, 0.0, 0.0]).collect();
    assert_true(&wrap(&line, &[]).unwrap(), |_| 0.0, f64::INFINITY);
    let never = [f32::NAN, f32::INFINITY, f32::MAX].map(|x| [x, 0.0, -x]);
    let with_never: Vec<Point> = cloud.iter().copied().chain(never).collect();
    wrap(&with_never, &never);
    let crowd: Vec<Point> = (0..1_000_000).map(|_| [0; 3].map(|_: i32| rng.random())).collect();
    assert_true(&wrap(&crowd, &[]).unwrap(), |_| 0.0, f64::INFINITY);
    let far: Vec<Point> = (0..100).map(|i| [1e30 * i as f32, 0.0, 1e-30]).collect();
    wrap(&far, &[]);
    let with_far: Vec<Point> =
        cloud.iter().copied().chain([[1e4, 0.0, 0.0], [0.0, -1e30, 0.0]]).collect();
    assert_true(&wrap(&with_far, &cloud).unwrap(), |_| 0.0, f64::INFINITY);
}

fn twin(graph: Graph) -> Twin {
    let params = Params {
        spring_stiffness: vec![1e3; graph.springs.len()],
        spring_dashpot: vec![1.0; graph.springs.len()],
        rest_lengths_m: vec![0.02; graph.springs.len()],
        ..Params::default()
    };
    Twin::new(graph, params, Timing { fps: 30.0, substeps: 50 })
}

fn graph(rest_positions: Vec<Point>, springs: Vec<[u32; 2]>) -> Graph {
    let n = rest_positions.len();
    Graph {
        rest_positions,
        kinds: vec![NodeKind::Observed; n],
        masses: vec![1.0; n],
        object_ids: vec![0; n],
        observed_points: (0..n as u32).collect(),
        control_rest: vec![[0.0; 3]],
        springs,
        triplets: Vec::new(),
        pins: vec![Pin { node: 0, control: 0, offset_m: [0.0; 3] }],
        rods: Vec::new(),
    }
}

#[test]
fn a_cable_has_a_tube() {
    let nodes = (0..10).map(|i| [0.02 * i as f32, 0.0, 0.1]).collect();
    let cable = twin(graph(nodes, (0..9).map(|i| [i, i + 1]).collect()));
    let surface = surface_of(&cable, &[]).unwrap();
    surface.check(10).unwrap();
    assert_eq!(surface.tubes, [Tube { nodes: (0..10).collect(), radius_m: 0.005 }]);
}

#[test]
fn a_body_carries_its_surface_and_colours() {
    let nodes = scattered(toy, 300, 0.0, 7);
    let tree = bendtwin_near::PointTree::new(nodes.iter().copied());
    let mut springs: Vec<[u32; 2]> = Vec::new();
    for (p, i) in nodes.iter().zip(0_u32..) {
        let near = tree.within(*p, 0.05, 8);
        springs.extend(near.iter().filter(|n| n.number > i).map(|n| [i, n.number]));
    }
    let colors: Vec<[u8; 3]> =
        nodes.iter().map(|p| if p[0] > 0.0 { [200, 10, 10] } else { [10, 10, 200] }).collect();
    let twin = twin(graph(nodes.clone(), springs));
    let surface = surface_of(&twin, &colors).unwrap();
    surface.check(300).unwrap();
    let rest = surface.positions(&nodes);
    let vertices = rest.iter().zip(&surface.colors);
    for (vertex, color) in vertices.filter(|(v, _)| v[0].abs() > 0.03) {
        assert_eq!(*color, if vertex[0] > 0.0 { [200, 10, 10] } else { [10, 10, 200] });
    }
    let mut off: Vec<f64> = rest.iter().map(|v| toy(wide(*v)).abs()).collect();
    off.sort_by(f64::total_cmp);
    assert!(off[off.len() * 95 / 100] < 0.005);
    // A motion of the whole body moves its surface.
    let moved: Vec<Point> = nodes.iter().map(|p| [p[1], -p[0], p[2] + 1.0]).collect();
    for (before, after) in rest.iter().zip(surface.positions(&moved)) {
        let expected = [before[1], -before[0], before[2] + 1.0];
        assert!(distance(wide(after), wide(expected)) < 1e-4);
    }
    // The file keeps the surface.
    let dressed = Twin { surface: Some(surface), ..twin };
    let file = dressed.encode().unwrap();
    assert_eq!(Twin::decode(&file).unwrap(), dressed);
}
