//! Objects with grasps, colliders, turning clamps and smooth contact around them, and costs of the
//! forces that act on them.

use std::sync::Arc;

use bendtwin_core::{CancelToken, Point};
use bendtwin_cuda::{Options, cuda};
use bendtwin_engine::{
    Model, Objective,
    backend::{GradientRequest, Instance, Outputs, Rollout},
    world::{Motion, Pose},
};
use bendtwin_engine_kit::{RandomOptions, WorldOptions, count_forces, random_model, random_world};

use super::{both, instance, relative_within, seed};

const FRAMES: usize = 3;

/// Models with surroundings of every kind.
fn cases() -> Vec<(String, Model, WorldOptions)> {
    let none = WorldOptions::default();
    let all = WorldOptions { grasps: true, colliders: 4, ..none };
    let smoothing_m = 0.004;
    let ground = RandomOptions { ground: true, pins: 3, ..RandomOptions::default() };
    let touching = RandomOptions { objects: 2, contact: true, ..ground };
    let rod = RandomOptions { rod: true, pins: 4, ..RandomOptions::default() };
    let skin = RandomOptions { skin_contact: true, ..ground };
    let kinds = [
        ("skin over ground", skin, all),
        ("skin in a layer", skin, WorldOptions { smoothing_m, ..all }),
        ("grasps", RandomOptions::default(), WorldOptions { grasps: true, ..none }),
        ("colliders", RandomOptions::default(), WorldOptions { colliders: 4, ..none }),
        ("both over ground", ground, all),
        ("smooth over ground", ground, WorldOptions { smoothing_m, ..all }),
        ("smooth ground", ground, WorldOptions { smoothing_m, ..none }),
        ("touching", touching, all),
        ("rolls", rod, WorldOptions { grasps: true, rolls: true, ..none }),
        ("slipping", ground, WorldOptions { max_force: Some(0.5), ..all }),
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

fn surrounded(mut instance: Instance, model: &Model, with: &WorldOptions) -> Instance {
    let positions = &instance.initial.positions;
    let (world, motion) = random_world(seed(), model, positions, FRAMES, with);
    (instance.world, instance.motion) = (Arc::new(world), Arc::new(motion));
    instance
}

fn flat(points: &[Point]) -> Vec<f32> {
    points.as_flattened().to_vec()
}

#[test]
#[ignore = "needs a CUDA device"]
fn surrounded_objects_move_as_on_the_cpu() {
    let outputs = Outputs { every: 1, final_state: true, forces: true, ..Outputs::default() };
    for (name, model, with) in cases() {
        let [expected, found]: [Rollout; 2] = both(&model, seed(), FRAMES).map(|(b, i)| {
            let instance = surrounded(i, &model, &with);
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
            rolls: motion.rolls.iter().take(2 * (frames + 1) * graph.rods.len()).copied().collect(),
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
            let whole = surrounded(instance(&*backend, &model, seed(), FRAMES), &model, &with);
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

/// Compares gradients on both, which are to agree to this share of their norms.
fn compare_gradients(
    name: &str,
    model: &Model,
    within: f64,
    surround: impl Fn(Instance) -> Instance,
) {
    let request =
        GradientRequest { controls: true, initial: true, motion: true, ..GradientRequest::PARAMS };
    let [expected, found] = both(model, seed(), FRAMES).map(|(b, i)| {
        b.gradients(&[surround(i)], &request, &CancelToken::default()).expect("valid").remove(0)
    });
    let mut worst = 0.0_f64;
    let mut compare = |what: &str, a: &[f32], b: &[f32]| {
        worst = worst.max(relative_within(within, name, what, a, b));
    };
    let poses = |p: &[Pose]| p.as_flattened().as_flattened().to_vec();
    compare("poses", &poses(&expected.poses), &poses(&found.poses));
    compare("rolls", &expected.rolls, &found.rolls);
    compare("controls", &flat(&expected.controls), &flat(&found.controls));
    let [a, b] = [&expected, &found].map(|g| g.initial.clone().expect("it was asked for"));
    compare("positions", &flat(&a.positions), &flat(&b.positions));
    compare("velocities", &flat(&a.velocities), &flat(&b.velocities));
    let [a, b] = [&expected.params, &found.params];
    compare("stiffness", &a.spring_stiffness, &b.spring_stiffness);
    println!("{name}: {worst:.1e}");
}

#[test]
#[ignore = "needs a CUDA device"]
fn surrounded_objects_have_the_gradients_of_the_cpu() {
    for (name, model, with) in cases() {
        compare_gradients(&name, &model, 1e-3, |i| surrounded(i, &model, &with));
    }
}

/// Costs of forces and clearances, where impacts do not make them jump: a force is a small difference
/// of velocities, which costs digits.
#[test]
#[ignore = "needs a CUDA device"]
fn forces_have_the_gradients_of_the_cpu() {
    let is_smooth = |with: &WorldOptions| {
        with.smoothing_m > 0.0 || with.colliders == 0 && with.max_force.is_none()
    };
    for (name, model, with) in cases().into_iter().filter(|(.., with)| is_smooth(with)) {
        let has_ground = model.environment.ground.is_some();
        compare_gradients(&format!("forces, {name}"), &model, 1e-2, |instance| {
            let mut instance = surrounded(instance, &model, &with);
            count_forces(&mut instance.objective, &instance.world, has_ground, FRAMES);
            instance
        });
    }
}
