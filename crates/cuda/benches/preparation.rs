//! Processor time that the host needs for a candidate of a search before a device can simulate it:
//! joining nodes, estimating stability, cutting the graph; and the kernels that the candidates need.
//! Needs no device. Prints a Markdown table.
//!
//! `cargo bench -p bendtwin-cuda`

#[path = "../../engine/benches/substep/clock.rs"]
mod clock;

use std::{collections::HashSet, hint::black_box, sync::Arc};

use bendtwin_core::{
    Environment, NodeKind, Params, Point, Timing, environment::ControlVelocity,
    settings::TripletReference,
};
use bendtwin_cuda::{Chip, prepare};
use bendtwin_engine::{Model, enough_substeps, stable_substeps};
use bendtwin_graph::{
    Connectivity, LeftOut, NodeSample, SurfacePoints, Triplets, connect, rest_geometry,
};

/// Distance of neighbours on the grid [m].
const SPACING_M: f32 = 0.005;
/// Candidates of a generation.
const CANDIDATES: usize = 11;
/// Substeps of a frame.
const SUBSTEPS: u32 = 667;

fn main() {
    println!(
        "| nodes | springs | triplets | joining, ms | enough, ms | stable, ms | alone, ms | in a batch, ms | teams | kernels |"
    );
    println!("|---|---|---|---|---|---|---|---|---|---|");
    for nodes in [500, 2_000, 4_261] {
        for bending in [false, true] {
            row(nodes, bending);
        }
    }
}

/// Means over the candidates of a generation.
fn row(nodes: usize, bending: bool) {
    let sample = ellipsoid(nodes);
    let all = candidates(bending);
    let mean = |work: &mut dyn FnMut()| clock::best_of(3, work) * 1e3 / CANDIDATES as f64;
    let joining = mean(&mut || all.iter().for_each(|c| drop(black_box(model(&sample, c)))));
    let models: Vec<Model> = all.iter().map(|c| model(&sample, c)).collect();
    let enough = mean(&mut || {
        models.iter().for_each(|m| {
            let _ = black_box(enough_substeps(m, SUBSTEPS));
        });
    });
    let stable = mean(&mut || {
        models.iter().for_each(|m| {
            black_box(stable_substeps(m));
        });
    });
    let batch_of =
        |batch: usize| move |m: &Model| prepare(m, &Chip::HOPPER, batch).expect("it is small");
    let alone = mean(&mut || models.iter().for_each(|m| drop(black_box(batch_of(1)(m)))));
    let batch = mean(&mut || models.iter().for_each(|m| drop(black_box(batch_of(CANDIDATES)(m)))));
    let launches: Vec<_> = models.iter().map(batch_of(CANDIDATES)).collect();
    let teams: HashSet<_> = launches.iter().map(|l| l.team.as_str()).collect();
    let kernels: HashSet<_> = launches.iter().map(|l| l.kernel).collect();
    let of = |count: fn(&Model) -> usize| models.iter().map(count).sum::<usize>() / models.len();
    println!(
        "| {} | {} | {} | {joining:.2} | {enough:.2} | {stable:.2} | {alone:.2} | {batch:.2} | {} | {} |",
        sample.node_count(),
        of(|m| m.graph.springs.len()),
        of(|m| m.graph.triplets.len()),
        teams.into_iter().collect::<Vec<_>>().join(", "),
        kernels.len(),
    );
}

/// Connectivities as a search proposes them, spread over its range.
fn candidates(bending: bool) -> Vec<Connectivity> {
    let triplets = Triplets { max_per_node: 4, reference: TripletReference::Nearest };
    (0..CANDIDATES)
        .map(|c| Connectivity {
            radius_m: 0.012 + 0.001 * c as f64,
            max_neighbours: 18 + (7 * c) % 24,
            control_radius_m: 0.03 + 0.002 * ((5 * c) % CANDIDATES) as f64,
            control_neighbours: 20 + 4 * ((3 * c) % CANDIDATES),
            triplets: bending.then_some(triplets),
            rods: false,
        })
        .collect()
}

fn model(sample: &NodeSample, connectivity: &Connectivity) -> Model {
    let graph = connect(sample, connectivity);
    let (rest_lengths_m, rest_angles_rad) = rest_geometry(&graph, sample);
    let (springs, triplets) = (graph.springs.len(), graph.triplets.len());
    Model {
        params: Params {
            spring_stiffness: vec![3e3; springs],
            spring_dashpot: vec![10.0; springs],
            rest_lengths_m,
            bend_stiffness: vec![1e-3; triplets],
            bend_damping: vec![1e-6; triplets],
            rest_angles_rad,
            drag: 1.0,
            ..Params::default()
        },
        graph: Arc::new(graph),
        skin: Arc::default(),
        environment: Environment { gravity: [0.0, 0.0, -9.81], ground: None },
        timing: Timing { fps: 30.0, substeps: SUBSTEPS },
        control_velocity: ControlVelocity::True,
    }
}

/// An ellipsoid 1.5 : 1 : 0.8 filled on a jittered grid, the outer nodes on the surface, with 30
/// control points at one end.
fn ellipsoid(nodes: usize) -> NodeSample {
    let mut noise = 0x9e37_79b9_u32;
    let mut jitter = || {
        noise ^= noise << 13;
        noise ^= noise >> 17;
        noise ^= noise << 5;
        (noise as f32 / u32::MAX as f32 - 0.5) * 0.4 * SPACING_M
    };
    let mut points: Vec<(f32, Point)> = Vec::new();
    let extent = -30..=30;
    for x in extent.clone() {
        for y in extent.clone() {
            for z in extent.clone() {
                let p = [x, y, z].map(|c: i32| c as f32 * SPACING_M);
                let r = (p[0] / 1.5).powi(2) + p[1].powi(2) + (p[2] / 0.8).powi(2);
                points.push((r, p.map(|c| c + jitter())));
            }
        }
    }
    points.sort_by(|a, b| a.0.total_cmp(&b.0));
    points.truncate(nodes);
    let shell = points.last().map_or(0.0, |p| 0.7 * p.0);
    let surface = points.iter().filter(|p| p.0 >= shell).count();
    points.reverse();
    let positions: Vec<Point> = points.into_iter().map(|p| p.1).collect();
    let end = positions.iter().map(|p| p[0]).fold(0.0, f32::max);
    let control =
        |c: usize| [end + 0.005, 0.003 * (c % 6) as f32 - 0.008, 0.003 * (c / 6) as f32 - 0.006];
    NodeSample {
        kinds: (0..nodes)
            .map(|i| if i < surface { NodeKind::Observed } else { NodeKind::Interior })
            .collect(),
        observed_points: (0..nodes as u32).collect(),
        object_ids: vec![0; nodes],
        control_rest: (0..30).map(control).collect(),
        pins: Vec::new(),
        edges: None,
        rest_shape: None,
        point_spacing_m: f64::from(SPACING_M),
        spacing_scale: 1.0,
        surface: SurfacePoints::default(),
        left_out: LeftOut::default(),
        positions,
    }
}
