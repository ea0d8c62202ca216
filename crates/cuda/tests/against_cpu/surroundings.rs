//! Objects with grasps, colliders, turning clamps and smooth contact around them.

use std::{f32::consts::TAU, sync::Arc};

use bendtwin_core::{CancelToken, Point};
use bendtwin_cuda::{Options, cuda};
use bendtwin_engine::{
    Model, Objective,
    backend::{GradientRequest, Instance, Outputs, Rollout},
    conformance::{RandomOptions, random_model},
    world::{
        Attachment, Collider, Face, Grasp, Motion, Pose, Region, Shape, World, largest_stiffness,
    },
};

use super::{both, instance, relative, seed};

const FRAMES: usize = 3;

/// Numbers in 0..1 that depend on a seed.
struct Numbers(u64);

impl Numbers {
    fn next(&mut self) -> f32 {
        self.0 =
            self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 40) as f32 / (1_u64 << 24) as f32
    }

    fn around(&mut self, x: f32) -> f32 {
        x * (2.0 * self.next() - 1.0)
    }

    fn node(&mut self, positions: &[Point]) -> usize {
        ((self.next() * positions.len() as f32) as usize).min(positions.len() - 1)
    }
}

/// What a world has beside bodies.
#[derive(Clone, Copy, Default)]
struct With {
    grasps: bool,
    colliders: bool,
    smooth: bool,
    rolls: bool,
    max_force: Option<f32>,
}

fn pose(at: Point, tilt: f32) -> Pose {
    let (s, c) = tilt.sin_cos();
    let turn = [[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]];
    std::array::from_fn(|i| [turn[i][0], turn[i][1], turn[i][2], at[i]])
}

fn cuboid(half: f32) -> Shape {
    let face = |c: usize, sign: f32| Face {
        normal: std::array::from_fn(|i| if i == c { sign } else { 0.0 }),
        offset_m: half,
    };
    Shape::Convex(Arc::new((0..3).flat_map(|c| [face(c, 1.0), face(c, -1.0)]).collect()))
}

fn surround(seed: u64, model: &Model, positions: &[Point], with: With) -> (World, Motion) {
    let mut numbers = Numbers(seed);
    let starts: [Point; 2] = std::array::from_fn(|_| {
        let node = positions[numbers.node(positions)];
        node.map(|x| x + numbers.around(0.004))
    });
    let steps: [Point; 2] = std::array::from_fn(|_| std::array::from_fn(|_| numbers.around(0.002)));
    let turns: [f32; 2] = std::array::from_fn(|_| numbers.around(0.05));
    let tilts: [f32; 2] = std::array::from_fn(|_| numbers.around(TAU / 2.0));
    let poses = (0..=FRAMES).flat_map(|f| {
        (0..2).map(move |b| {
            let at = std::array::from_fn(|k| starts[b][k] + f as f32 * steps[b][k]);
            pose(at, tilts[b] + f as f32 * turns[b])
        })
    });
    let mut motion = Motion { poses: poses.collect(), ..Motion::default() };
    let mut world = World { bodies: 2, ..World::default() };
    if with.grasps {
        let max_force = with.max_force.unwrap_or(f32::INFINITY);
        let some: Vec<u32> = (0..3).map(|_| numbers.node(positions) as u32).collect();
        let spring =
            Attachment::Spring { stiffness: 0.3 * largest_stiffness(model), damping: 0.02 };
        let mut grasps = vec![
            (
                Region::Sphere { center: [0.0; 3], radius_m: 0.035 },
                Attachment::Pin,
                [true, true, false],
            ),
            (Region::Nodes(Arc::new(some)), spring, [false, true, true]),
            (
                Region::Box { low: [-0.02; 3], high: [0.03; 3] },
                Attachment::Pin,
                [false, false, true],
            ),
        ];
        if model.graph.control_count() > 0 {
            let all = Region::Controls(Arc::new(vec![0]));
            grasps.push((all, Attachment::Pin, [true, false, false]));
        }
        for (g, (region, attachment, _)) in grasps.iter().enumerate() {
            let (region, body) = (region.clone(), g as u32 % 2);
            world.grasps.push(Grasp { body, region, attachment: *attachment, max_force });
        }
        motion.closed = (0..FRAMES).flat_map(|f| grasps.iter().map(move |g| g.2[f])).collect();
    }
    if with.colliders {
        let aside = |x: Point| [x[0] + 0.015, x[1] - 0.01, x[2]];
        let capsule =
            Shape::Capsule { from: [0.01, 0.0, -0.03], to: [0.02, 0.0, 0.03], radius_m: 0.008 };
        let parts = [
            (Some(1), capsule),
            (Some(0), cuboid(0.012)),
            (
                None,
                Shape::Capsule {
                    from: aside(positions[0]),
                    to: aside(positions[0]),
                    radius_m: 0.012,
                },
            ),
        ];
        world.colliders = parts
            .into_iter()
            .map(|(body, shape)| Collider { body, shape, friction: 0.4, restitution: 0.2 })
            .collect();
    }
    if with.smooth {
        world.smoothing_m = 0.004;
    }
    if with.rolls {
        let rods = model.graph.rods.len();
        motion.rolls = (0..(FRAMES + 1) * rods).map(|i| 0.05 * (i / rods.max(1)) as f32).collect();
    }
    (world, motion)
}

/// Models with surroundings of every kind.
fn cases() -> Vec<(String, Model, With)> {
    let all = With { grasps: true, colliders: true, ..With::default() };
    let ground = RandomOptions { ground: true, pins: 3, ..RandomOptions::default() };
    let touching = RandomOptions { objects: 2, contact: true, ..ground };
    let rod = RandomOptions { rod: true, pins: 4, ..RandomOptions::default() };
    let kinds = [
        ("grasps", RandomOptions::default(), With { colliders: false, ..all }),
        ("colliders", RandomOptions::default(), With { grasps: false, ..all }),
        ("both over ground", ground, all),
        ("smooth over ground", ground, With { smooth: true, ..all }),
        ("smooth ground", ground, With { smooth: true, ..With::default() }),
        ("touching", touching, all),
        ("rolls", rod, With { grasps: true, rolls: true, ..With::default() }),
        ("slipping", ground, With { max_force: Some(0.5), ..all }),
    ];
    let each = kinds.into_iter().enumerate().flat_map(|(k, (name, options, with))| {
        [8, 120, 900].into_iter().map(move |nodes| {
            let seed = seed() + 1_000 * (k as u64 + 1) + nodes as u64;
            let mut model = random_model(seed, &RandomOptions { nodes, ..options });
            if k % 2 == 1 {
                model.params.spring_dashpot.fill(0.4);
            }
            (format!("{name}, {nodes} nodes, seed {seed}"), model, with)
        })
    });
    each.collect()
}

fn surrounded(mut instance: Instance, model: &Model, with: With) -> Instance {
    let (world, motion) = surround(seed(), model, &instance.initial.positions, with);
    (instance.world, instance.motion) = (Arc::new(world), Arc::new(motion));
    instance
}

fn flat(points: &[Point]) -> Vec<f32> {
    points.as_flattened().to_vec()
}

#[test]
#[ignore = "needs a CUDA device"]
fn surrounded_objects_move_alike() {
    let outputs = Outputs { every: 1, final_state: true, forces: true, ..Outputs::default() };
    for (name, model, with) in cases() {
        let [expected, found]: [Rollout; 2] = both(&model, seed(), FRAMES).map(|(b, i)| {
            let instance = surrounded(i, &model, with);
            b.roll_out(&[instance], &outputs, &CancelToken::default()).expect("valid").remove(0)
        });
        let most = |a: &[Point], b: &[Point]| {
            let apart = flat(a).into_iter().zip(flat(b)).map(|(x, y)| f64::from((x - y).abs()));
            apart.fold(0.0_f64, f64::max)
        };
        let n = model.graph.node_count();
        let each = expected.positions.chunks(n).zip(found.positions.chunks(n));
        let apart: Vec<f64> = each.map(|(a, b)| most(a, b)).collect();
        println!("{name}: {apart:?} m apart at most");
        assert!(apart.iter().all(|x| *x < 5e-5), "{name}");
        let [a, b] = [&expected, &found].map(|r| r.final_state.clone().expect("it ended").grasping);
        assert_eq!(a.phases, b.phases, "{name}");
        let nodes = |g: &bendtwin_engine::world::Grasping| {
            g.holds.iter().map(|h| (h.node, h.grasp)).collect::<Vec<_>>()
        };
        assert_eq!(nodes(&a), nodes(&b), "{name}");
        let [a, b] = [&expected, &found].map(|r| r.forces.clone().expect("they were asked for"));
        // A sum of many impulses is as exact as the largest of them.
        let size = flat(&a.controls).into_iter().chain(a.grasps.as_flattened().iter().copied());
        let size = size.fold(1.0_f32, |m, x| m.max(x.abs()));
        let worst = |a: &[f32], b: &[f32]| {
            assert_eq!(a.len(), b.len(), "{name}");
            a.iter().zip(b).map(|(x, y)| (x - y).abs() / size).fold(0.0, f32::max)
        };
        let forces = [
            worst(&flat(&a.controls), &flat(&b.controls)),
            worst(a.grasps.as_flattened(), b.grasps.as_flattened()),
            worst(&flat(&a.ground), &flat(&b.ground)),
            worst(a.colliders.as_flattened(), b.colliders.as_flattened()),
        ];
        println!("    forces {forces:?} of {size:.1e}");
        assert!(forces.iter().all(|x| *x < 1e-2), "{name}");
    }
}

/// The first frames of an instance.
fn shortened(instance: &Instance, frames: usize) -> Instance {
    let graph = &instance.model.model().graph;
    let (motion, world) = (&instance.motion, &instance.world);
    let terms = instance.objective.terms.iter().filter(|t| t.frame <= frames).cloned();
    Instance {
        frames,
        controls: Arc::new(instance.controls[..(frames + 1) * graph.control_count()].to_vec()),
        motion: Arc::new(Motion {
            poses: motion.poses[..(frames + 1) * world.bodies].to_vec(),
            closed: motion.closed[..frames * world.grasps.len()].to_vec(),
            rolls: motion.rolls.iter().take((frames + 1) * graph.rods.len()).copied().collect(),
        }),
        objective: Objective {
            terms: Arc::new(terms.collect()),
            ..Objective::clone(&instance.objective)
        },
        ..instance.clone()
    }
}

#[test]
#[ignore = "needs a CUDA device"]
fn surrounded_objects_do_not_see_what_is_simulated_beside_them() {
    let outputs = Outputs { every: 1, forces: true, ..Outputs::default() };
    for team in ["block4", "cluster4"] {
        let options = Options { team: Some(team.into()), ..Options::default() };
        let backend = cuda(&options).expect("a CUDA device");
        let all = cases().into_iter();
        for (name, model, with) in all.filter(|(_, model, _)| model.graph.node_count() == 120) {
            let whole = surrounded(instance(&*backend, &model, seed(), FRAMES), &model, with);
            let batch = [1, FRAMES, 2, FRAMES, 1].map(|frames| shortened(&whole, frames));
            let run = |b: &[Instance]| {
                backend.roll_out(b, &outputs, &CancelToken::default()).expect("valid")
            };
            for (beside, one) in run(&batch).into_iter().zip(&batch) {
                let alone = run(std::slice::from_ref(one)).remove(0);
                assert_eq!(beside.positions, alone.positions, "{name}, {team}");
                assert_eq!(beside.forces, alone.forces, "{name}, {team}");
            }
        }
    }
}

#[test]
#[ignore = "needs a CUDA device"]
fn surrounded_objects_have_alike_gradients() {
    let request =
        GradientRequest { controls: true, initial: true, motion: true, ..GradientRequest::PARAMS };
    for (name, model, with) in cases() {
        let [expected, found] = both(&model, seed(), FRAMES).map(|(b, i)| {
            let instance = surrounded(i, &model, with);
            b.gradients(&[instance], &request, &CancelToken::default()).expect("valid").remove(0)
        });
        let mut worst = 0.0_f64;
        let poses = |p: &[Pose]| p.as_flattened().as_flattened().to_vec();
        worst = worst.max(relative(&name, "poses", &poses(&expected.poses), &poses(&found.poses)));
        worst = worst.max(relative(&name, "rolls", &expected.rolls, &found.rolls));
        let [a, b] = [&expected.controls, &found.controls].map(|c| flat(c));
        worst = worst.max(relative(&name, "controls", &a, &b));
        let [a, b] = [&expected, &found].map(|g| g.initial.clone().expect("it was asked for"));
        worst = worst.max(relative(&name, "positions", &flat(&a.positions), &flat(&b.positions)));
        worst =
            worst.max(relative(&name, "velocities", &flat(&a.velocities), &flat(&b.velocities)));
        let [a, b] = [&expected.params, &found.params].map(|p| p.spring_stiffness.clone());
        worst = worst.max(relative(&name, "stiffness", &a, &b));
        println!("{name}: {worst:.1e}");
    }
}
