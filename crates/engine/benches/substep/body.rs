//! Bodies to measure with: an ellipsoid 1.5 : 1 : 0.8 filled on a jittered 5 mm grid, joined within
//! 0.02 m to at most 30 neighbours (about 17 springs a node), and a cable.

use std::sync::Arc;

use bendtwin_core::{
    Contact, Environment, Graph, NodeKind, Params, Point, Timing, environment::ControlVelocity,
};
use bendtwin_engine::{Model, stable_substeps};
use bendtwin_graph::{SurfacePoints, bind_skin};

const SPACING: f32 = 0.005;
const RADIUS: f32 = 0.02;
const NEIGHBOURS: usize = 30;
/// Triplets a surface node.
const TRIPLETS: usize = 6;

/// An ellipsoid of the given number of nodes; the outer shell has triplets if requested.
pub(crate) fn ellipsoid(nodes: usize, bending: bool) -> Model {
    let mut positions = filled(nodes);
    let (depth, shell) = shell(&positions);
    // Surface nodes come first.
    let mut order: Vec<usize> = (0..nodes).collect();
    order.sort_by_key(|&i| depth[i] < shell);
    let surface = depth.iter().filter(|d| **d >= shell).count();
    positions = order.iter().map(|&i| positions[i]).collect();
    let mut springs = Vec::new();
    let mut triplets = Vec::new();
    for a in 0..nodes {
        let near = neighbours(&positions, a);
        springs.extend(near.iter().map(|&b| [a.min(b) as u32, a.max(b) as u32]));
        let shell: Vec<u32> = near.iter().filter(|&&b| b < surface).map(|&b| b as u32).collect();
        if bending && a < surface {
            let pairs = shell.chunks_exact(2).take(TRIPLETS);
            triplets.extend(pairs.map(|p| [p[0], a as u32, p[1]]));
        }
    }
    springs.sort_unstable();
    springs.dedup();
    model(positions, surface, springs, triplets)
}

/// An ellipsoid of `nodes` nodes on the ground, with as few substeps as fits use, and `points` skin
/// points around its surface.
pub(crate) fn lying(nodes: usize, points: usize) -> Model {
    let mut model = ellipsoid(nodes, false);
    model.timing.substeps = stable_substeps(&model).needed * 13 / 10 + 1;
    let surface = &model.graph.rest_positions[..model.graph.surface_count()];
    let beside = |k: usize| {
        let by = [k * 7 % 5, k * 3 % 4, k * 11 % 3].map(|i| (i as f32 - 1.5) * 0.5 * SPACING);
        let [x, y, z] = surface[k % surface.len()];
        [x + by[0], y + by[1], z + by[2]]
    };
    let positions: Vec<Point> = (0..points).map(beside).collect();
    let lowest = positions.iter().map(|p| p[2]).fold(f32::INFINITY, f32::min);
    if let Some(ground) = &mut model.environment.ground {
        ground.offset_m = lowest - 1e-3;
    }
    let observed_points = vec![Graph::NOT_OBSERVED; points];
    model.skin = Arc::new(bind_skin(&model.graph, &SurfacePoints { positions, observed_points }));
    model
}

/// A straight cable with a triplet at every inner node.
pub(crate) fn cable(nodes: u32) -> Model {
    let positions = (0..nodes).map(|i| [0.04 * i as f32, 0.0, 0.5]).collect();
    let springs = (1..nodes).map(|i| [i - 1, i]).collect();
    let triplets = (1..nodes - 1).map(|i| [i - 1, i, i + 1]).collect();
    model(positions, nodes as usize, springs, triplets)
}

fn filled(nodes: usize) -> Vec<Point> {
    let mut noise = 0x9e37_79b9_u32;
    let mut jitter = || {
        noise ^= noise << 13;
        noise ^= noise >> 17;
        noise ^= noise << 5;
        (noise as f32 / u32::MAX as f32 - 0.5) * 0.4 * SPACING
    };
    let extent = 40;
    let mut points: Vec<(f32, Point)> = Vec::new();
    for x in -extent..=extent {
        for y in -extent..=extent {
            for z in -extent..=extent {
                let p = [x, y, z].map(|c| c as f32 * SPACING);
                let r = (p[0] / 1.5).powi(2) + p[1].powi(2) + (p[2] / 0.8).powi(2);
                points.push((r, p.map(|c| c + jitter())));
            }
        }
    }
    points.sort_by(|a, b| a.0.total_cmp(&b.0));
    points.truncate(nodes);
    let mut kept: Vec<Point> = points.into_iter().map(|p| p.1).collect();
    kept.sort_by(|a, b| a[0].total_cmp(&b[0]));
    kept.iter_mut().for_each(|p| p[2] += 0.3);
    kept
}

/// Distance of each node from the centre, and the distance from which it counts as surface.
fn shell(points: &[Point]) -> (Vec<f32>, f32) {
    let out = |p: &Point| {
        let (x, y, z) = (p[0] / 1.5, p[1], (p[2] - 0.3) / 0.8);
        (x * x + y * y + z * z).sqrt()
    };
    let depth: Vec<f32> = points.iter().map(out).collect();
    let most = depth.iter().fold(0.0_f32, |m, d| m.max(*d));
    (depth, most - SPACING)
}

fn neighbours(points: &[Point], a: usize) -> Vec<usize> {
    let distance = |b: usize| {
        let d: f32 = (0..3).map(|c| (points[a][c] - points[b][c]).powi(2)).sum();
        d.sqrt()
    };
    let mut near: Vec<(f32, usize)> =
        (0..points.len()).filter(|&b| b != a).map(|b| (distance(b), b)).collect();
    near.retain(|n| n.0 < RADIUS);
    near.sort_by(|x, y| x.0.total_cmp(&y.0));
    near.truncate(NEIGHBOURS);
    near.into_iter().map(|n| n.1).collect()
}

fn model(
    positions: Vec<Point>,
    surface: usize,
    springs: Vec<[u32; 2]>,
    triplets: Vec<[u32; 3]>,
) -> Model {
    let n = positions.len();
    let arm = |a: u32, b: u32| {
        let (a, b) = (positions[a as usize], positions[b as usize]);
        [b[0] - a[0], b[1] - a[1], b[2] - a[2]]
    };
    let dot = |a: [f32; 3], b: [f32; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let length = |s: &[u32; 2]| dot(arm(s[0], s[1]), arm(s[0], s[1])).sqrt();
    let angle = |t: &[u32; 3]| {
        let (u, w) = (arm(t[1], t[0]), arm(t[1], t[2]));
        (dot(u, w) / (dot(u, u) * dot(w, w)).sqrt()).clamp(-1.0, 1.0).acos()
    };
    let kind = |i| if i < surface { NodeKind::Observed } else { NodeKind::Interior };
    Model {
        skin: Arc::default(),
        params: Params {
            spring_stiffness: vec![3e3; springs.len()],
            spring_dashpot: vec![10.0; springs.len()],
            rest_lengths_m: springs.iter().map(length).collect(),
            bend_stiffness: vec![1e-3; triplets.len()],
            bend_damping: vec![1e-5; triplets.len()],
            rest_angles_rad: triplets.iter().map(angle).collect(),
            drag: 3.0,
            contact: Contact::default(),
            ..Params::default()
        },
        graph: Arc::new(Graph {
            kinds: (0..n).map(kind).collect(),
            masses: vec![1.0; n],
            object_ids: vec![0; n],
            observed_points: vec![Graph::NOT_OBSERVED; n],
            control_rest: vec![],
            pins: vec![],
            rest_positions: positions,
            springs,
            triplets,
            ..Graph::default()
        }),
        environment: Environment::Z_UP,
        timing: Timing { fps: 30.0, substeps: 667 },
        control_velocity: ControlVelocity::True,
    }
}
