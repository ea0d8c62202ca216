//! Seeded random surroundings of a random model: bodies that move and turn, grasps of every kind that
//! open and close, colliders of every shape, and costs of their forces.

use std::{f32::consts::TAU, sync::Arc};

use bendtwin_core::Point;
use bendtwin_engine::{
    Model, Objective, Term,
    objective::{ForceBy, WeightedTerm},
    world::{
        Attachment, Collider, Face, Grasp, Motion, Pose, Region, Shape, World, largest_stiffness,
    },
};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::SPACING_M;

/// Composition of random surroundings.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct WorldOptions {
    /// With grasps, by pins and springs, of every region.
    pub grasps: bool,
    /// Colliders: spheres, capsules, boxes and other convex shapes in turn.
    pub colliders: usize,
    /// Width of smooth contact [m]; 0 for impacts.
    pub smoothing_m: f32,
    /// With clamps that turn the model's rods.
    pub rolls: bool,
    /// Mean force above which grasps release [N at unit node mass], if limited.
    pub max_force: Option<f32>,
}

/// Bodies of every random world.
const BODIES: usize = 2;
/// Weight of squared forces, such that they count about as much as squared distances.
const FORCE_WEIGHT: f32 = 1e-7;

/// Random surroundings of a model whose nodes start at these positions: a pure function of its
/// arguments.
pub fn random_world(
    seed: u64,
    model: &Model,
    positions: &[Point],
    frames: usize,
    options: &WorldOptions,
) -> (World, Motion) {
    let mut rng = ChaCha8Rng::seed_from_u64(seed ^ 0x0077_6f72_6c64);
    let poses = paths(&mut rng, positions, frames);
    let mut motion = Motion { poses, ..Motion::default() };
    let smoothing_m = options.smoothing_m;
    let mut world = World { bodies: BODIES, smoothing_m, ..World::default() };
    if options.grasps {
        world.grasps = grasps(&mut rng, model, positions.len(), options.max_force);
        let count = frames * world.grasps.len();
        motion.closed = (0..count).map(|_| rng.random::<f32>() < 0.65).collect();
    }
    for k in 0..options.colliders {
        let shape = shape(&mut rng, k);
        let body = (k % 3 < 2).then_some(k as u32 % 2);
        let shape = match body {
            Some(_) => shape,
            None => shifted(&shape, near(&mut rng, positions, 0.02)),
        };
        let (friction, restitution) = (0.8 * rng.random::<f32>(), 0.4 * rng.random::<f32>());
        world.colliders.push(Collider { body, shape, friction, restitution });
    }
    if options.rolls {
        let ends = 2 * model.graph.rods.len();
        let rates: Vec<f32> = (0..ends).map(|_| 0.1 * (rng.random::<f32>() - 0.5)).collect();
        motion.rolls =
            (0..=frames).flat_map(|f| rates.iter().map(move |rate| rate * f as f32)).collect();
    }
    (world, motion)
}

/// Costs of the forces of control points, grasps, ground and colliders, and of the clearance of
/// colliders, at the end of the last frame, in the first group.
pub fn count_forces(objective: &mut Objective, world: &World, has_ground: bool, frame: usize) {
    let grasps = (0..world.grasps.len() as u32).map(ForceBy::Grasp);
    let colliders = (0..world.colliders.len() as u32).map(ForceBy::Collider);
    let by = grasps.chain(colliders).chain(has_ground.then_some(ForceBy::Ground));
    let forces = by.chain([ForceBy::Controls]).map(|by| Term::Force { by, limit: 0.5 });
    let clearance = |collider| Term::Clearance { collider, margin_m: 0.02 };
    let gaps = (0..world.colliders.len() as u32).map(clearance);
    let all = forces.map(|term| (FORCE_WEIGHT, term)).chain(gaps.map(|term| (1.0, term)));
    let terms = Arc::make_mut(&mut objective.terms);
    terms.extend(all.map(|(weight, term)| WeightedTerm { frame, weight, group: 0, term }));
    terms.sort_by_key(|t| t.frame);
}

fn around(rng: &mut ChaCha8Rng, size: f32) -> Point {
    std::array::from_fn(|_| size * (2.0 * rng.random::<f32>() - 1.0))
}

/// A point near a node.
fn near(rng: &mut ChaCha8Rng, positions: &[Point], within: f32) -> Point {
    let node = positions.get(rng.random_range(0..positions.len().max(1)));
    let (at, by) = (node.copied().unwrap_or_default(), around(rng, within));
    std::array::from_fn(|c| at[c] + by[c])
}

/// Poses of bodies that start near nodes, upright or on their side, and move and turn steadily.
fn paths(rng: &mut ChaCha8Rng, positions: &[Point], frames: usize) -> Vec<Pose> {
    let bodies: [(Point, Point, f32, f32); BODIES] = std::array::from_fn(|_| {
        let angle = TAU * rng.random::<f32>();
        (near(rng, positions, 0.004), around(rng, 0.002), angle, around(rng, 0.05)[0])
    });
    let pose = |f: usize, b: usize| {
        let (start, step, angle, turn) = bodies[b];
        let (s, c) = (angle + turn * f as f32).sin_cos();
        let rows = match b {
            0 => [[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]],
            _ => [[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]],
        };
        std::array::from_fn(|i| [rows[i][0], rows[i][1], rows[i][2], start[i] + f as f32 * step[i]])
    };
    (0..=frames).flat_map(|f| (0..BODIES).map(move |b| (f, b))).map(|(f, b)| pose(f, b)).collect()
}

fn grasps(rng: &mut ChaCha8Rng, model: &Model, nodes: usize, max_force: Option<f32>) -> Vec<Grasp> {
    let mut some: Vec<u32> = (0..3).map(|_| rng.random_range(0..nodes.max(1)) as u32).collect();
    some.sort_unstable();
    some.dedup();
    let stiffness = 0.3 * largest_stiffness(model);
    let spring = Attachment::Spring { stiffness, damping: 0.02 };
    let radius_m = SPACING_M * (0.8 + 0.5 * rng.random::<f32>());
    let low = [-0.7 * SPACING_M; 3];
    let mut kinds = vec![
        (Region::Sphere { center: around(rng, 0.005), radius_m }, Attachment::Pin),
        (Region::Nodes(Arc::new(some)), spring),
        (Region::Box { low, high: [SPACING_M; 3] }, Attachment::Pin),
    ];
    if model.graph.control_count() > 0 {
        kinds.push((Region::Controls(Arc::new(vec![0])), Attachment::Pin));
    }
    let max_force = max_force.unwrap_or(f32::INFINITY);
    let grasp = |(g, (region, attachment)): (usize, (Region, Attachment))| Grasp {
        body: g as u32 % BODIES as u32,
        region,
        attachment,
        max_force,
    };
    kinds.into_iter().enumerate().map(grasp).collect()
}

/// The `k`-th shape, about half as large as the distance of nodes.
fn shape(rng: &mut ChaCha8Rng, k: usize) -> Shape {
    let mut size = || SPACING_M * (0.25 + 0.25 * rng.random::<f32>());
    let radius_m = size();
    let half: Point = std::array::from_fn(|_| size());
    let faces = |normals: &[Point], offsets: &[f32]| {
        let face = |(n, o): (&Point, &f32)| Face { normal: *n, offset_m: *o };
        Shape::Convex(Arc::new(normals.iter().zip(offsets).map(face).collect()))
    };
    match k % 4 {
        0 => Shape::Capsule { from: [0.0; 3], to: [0.0; 3], radius_m },
        1 => Shape::Capsule { from: half.map(|x| -x), to: half, radius_m },
        2 => {
            let axis = |i: usize| -> Point {
                let sign = if i.is_multiple_of(2) { 1.0 } else { -1.0 };
                std::array::from_fn(|c| if c == i / 2 { sign } else { 0.0 })
            };
            let normals: [Point; 6] = std::array::from_fn(axis);
            faces(&normals, &std::array::from_fn::<f32, 6, _>(|i| half[i / 2]))
        }
        // A roof on a slab.
        _ => {
            let normals = [
                [0.0, 0.0, -1.0],
                [0.6, 0.0, 0.8],
                [-0.6, 0.0, 0.8],
                [0.0, 1.0, 0.0],
                [0.0, -1.0, 0.0],
            ];
            faces(&normals, &[half[0], half[1], half[1], half[2], half[2]])
        }
    }
}

/// A shape put elsewhere.
pub(crate) fn shifted(shape: &Shape, by: Point) -> Shape {
    let add = |p: &Point| std::array::from_fn(|c| p[c] + by[c]);
    match shape {
        Shape::Capsule { from, to, radius_m } => {
            Shape::Capsule { from: add(from), to: add(to), radius_m: *radius_m }
        }
        Shape::Convex(faces) => {
            let face = |f: &Face| {
                let along: f32 = f.normal.iter().zip(by).map(|(n, b)| n * b).sum();
                Face { normal: f.normal, offset_m: f.offset_m + along }
            };
            Shape::Convex(Arc::new(faces.iter().map(face).collect()))
        }
    }
}
