//! Rods: how clamps twist them, what a twist does, and what it costs.

use std::f64::consts::TAU;

use bendtwin_core::Point;
use bendtwin_engine::{Backend, backend::GradientRequest, model::State};

use crate::{
    energy,
    expect::{Outcome, close, ensure},
    random::{RandomOptions, random_model, random_motion, random_objective},
    scene::{Scene, cross, difference, dot, norm},
};

/// Distance of nodes along a cable [m].
const LINK_M: f32 = 0.05;

/// A cable of ten nodes between two clamps in empty space, bent in three dimensions; its rod,
/// without parameters yet, is straight and untwisted at rest.
pub(crate) fn cable() -> Scene {
    let mut points: Vec<Point> = vec![[0.0; 3]];
    for i in 0..9 {
        let t = 0.7 * i as f32;
        let [x, y, z] = [1.2, 0.6 * t.sin(), 0.6 * (1.3 * t).cos()];
        let length = (x * x + y * y + z * z).sqrt();
        let [a, b, c] = points[i];
        points.push([a + LINK_M * x / length, b + LINK_M * y / length, c + LINK_M * z / length]);
    }
    let mut scene = Scene::of(&points);
    (1..10).for_each(|i| scene.spring([i - 1, i], 300.0, 0.0));
    (1..9).for_each(|j| scene.triplet([j - 1, j, j + 1], std::f32::consts::PI, 0.1, 0.0));
    [0, 1, 8, 9].into_iter().for_each(|node| scene.fix(node));
    scene.rod((0..10).collect(), 0.0, 0.0, 0.0);
    scene.timing.substeps = 40;
    scene.last(1);
    scene
}

/// [`cable`] with one clamp only: at node 8 a branch of two nodes begins, 9 and 10, and the rod
/// ends in it; the trunk continues to node 11, which is also free.
pub(crate) fn branched_cable() -> Scene {
    let mut points = cable().graph.rest_positions;
    let [x, y, z] = points[8];
    points[9] = [x, y + LINK_M, z];
    points.push([x, y + 2.0 * LINK_M, z + 0.3 * LINK_M]);
    points.push([x + LINK_M, y, z]);
    let mut scene = Scene::of(&points);
    let edges = (1..11).map(|i| [i - 1, i]).chain([[8, 11]]);
    edges.for_each(|ends| scene.spring(ends, 300.0, 0.0));
    (1..10).for_each(|j| scene.triplet([j - 1, j, j + 1], 0.0, 0.1, 0.0));
    [[7, 8, 11], [9, 8, 11]].into_iter().for_each(|ends| scene.triplet(ends, 0.0, 0.1, 0.0));
    scene.relax();
    [0, 1].into_iter().for_each(|node| scene.fix(node));
    scene.rod((0..10).collect(), 0.0, 0.0, 0.0);
    scene.timing.substeps = 40;
    scene.last(1);
    scene
}

/// A direction at some angle from the x axis and some angle about it.
fn on_cone(half_angle: f64, about: f64) -> [f64; 3] {
    let (s, c) = half_angle.sin_cos();
    [c, s * about.cos(), s * about.sin()]
}

/// Solid angle between three directions, positive counter-clockwise as seen from outside.
fn solid_angle([a, b, c]: [[f64; 3]; 3]) -> f64 {
    2.0 * dot(a, cross(b, c)).atan2(1.0 + dot(a, b) + dot(b, c) + dot(c, a))
}

/// When a clamp's direction returns after a trip around a solid angle, and everything with it, its
/// frame has turned by that angle, and the rod is twisted by the same angle. To 1 % for the
/// quadrature over substeps, and with the opposite sign in the opposite direction.
pub(crate) fn clamps_twist_by_the_solid_angle(backend: &dyn Backend) -> Outcome {
    let (half_angle, steps) = (0.9, 60);
    for sense in [1.0, -1.0] {
        let mut scene = cable();
        scene.params.drag = 8.0;
        scene.params.bend_stiffness.fill(5.0);
        let hinge = scene.graph.rest_positions[8].map(f64::from);
        let tip = |step: usize| {
            let d = on_cone(half_angle, sense * TAU * step as f64 / steps as f64);
            [0, 1, 2].map(|k| hinge[k] + f64::from(LINK_M) * d[k])
        };
        let rest = scene.graph.control_rest.clone();
        let rows = |steps: &mut dyn Iterator<Item = usize>| -> Vec<Point> {
            let row = |step| [rest[0], rest[1], rest[2], tip(step).map(|x| x as f32)];
            steps.flat_map(row).collect()
        };
        // First to where it comes to rest, then around and to rest again.
        let calm = 250;
        (scene.frames, scene.controls) = (calm, rows(&mut (0..=calm).map(|_| 0)));
        scene.initial = scene.end(backend)?;
        let before = twist(&scene.initial)?;
        let there = (0..=4 * steps).map(|f| f / 4).chain((0..calm).map(|_| steps));
        (scene.frames, scene.controls) = (4 * steps + calm, rows(&mut there.into_iter()));
        let end = scene.end(backend)?;
        let axis = [1.0, 0.0, 0.0];
        let corner = |step: usize| on_cone(half_angle, sense * TAU * step as f64 / steps as f64);
        let around: f64 = (0..steps).map(|s| solid_angle([axis, corner(s), corner(s + 1)])).sum();
        close(
            &format!("twist after a solid angle of {around}"),
            twist(&end)? - before,
            -around,
            0.01 * around.abs(),
        )?;
        let moved = end.positions.iter().zip(&scene.initial.positions);
        let farthest = moved.map(|(a, b)| norm(difference(*a, *b))).fold(0.0, f64::max);
        ensure(farthest < 1e-3, || format!("the cable came back only to within {farthest} m"))?;
    }
    Ok(())
}

fn twist(state: &State) -> Result<f64, String> {
    match state.twists[..] {
        [twist] => Ok(f64::from(twist)),
        ref twists => Err(format!("{} twists of one rod", twists.len())),
    }
}

fn total(scene: &Scene, state: &State) -> f64 {
    let p = &scene.params;
    let rods = p.twist_stiffness.iter().zip(&p.rest_twists_rad).zip(&state.twists);
    let of = |((k, rest), twist): ((&f32, &f32), &f32)| {
        f64::from(*k) * (f64::from(*twist) - f64::from(*rest)).powi(2) / 2.0
    };
    energy::elastic(scene, &energy::endpoints(scene, state))
        + energy::kinetic(scene, state)
        + rods.map(of).sum::<f64>()
}

/// A twisted cable whips about when released; the sum of kinetic, elastic and twist energy is
/// conserved. Means over a second do not drift over four seconds: to 2 %, as for other networks,
/// including the quadrature of the twist.
pub(crate) fn energy_of_a_twisted_rod(backend: &dyn Backend) -> Outcome {
    for scene in [cable(), branched_cable()] {
        energy_stays(backend, scene)?;
    }
    Ok(())
}

fn energy_stays(backend: &dyn Backend, mut scene: Scene) -> Outcome {
    scene.params.twist_stiffness[0] = 0.05;
    scene.initial.twists = vec![4.0];
    scene.last(400);
    let states = scene.states(backend)?;
    let energies: Vec<f64> = states.iter().map(|s| total(&scene, s)).collect();
    let mean = |span: &[f64]| span.iter().sum::<f64>() / span.len() as f64;
    let (first, last) = (mean(&energies[1..100]), mean(&energies[300..]));
    close("energy after 3 s", last, first, 0.02 * first)?;
    let least = states.iter().map(|s| f64::from(s.twists[0])).fold(f64::INFINITY, f64::min);
    ensure(least < 3.9, || format!("the twist never fell below {least}: it does nothing"))
}

/// A straight cable between a clamp and a branch that stands off it at a right angle is a torsion
/// pendulum: its branch of mass m swings about the cable with k / (m r²), and as far to one side as
/// to the other. To 2 %.
pub(crate) fn a_branch_swings_about_its_rod(backend: &dyn Backend) -> Outcome {
    let (arm_m, stiffness) = (0.1, 0.5);
    let mut points: Vec<Point> = (0..5).map(|i| [LINK_M * i as f32, 0.0, 0.0]).collect();
    points.push([4.0 * LINK_M, arm_m, 0.0]);
    let mut scene = Scene::of(&points);
    (1..6).for_each(|i| scene.spring([i - 1, i], 5e3, 0.0));
    (1..5).for_each(|j| scene.triplet([j - 1, j, j + 1], 0.0, 200.0, 0.0));
    scene.relax();
    [0, 1].into_iter().for_each(|node| scene.fix(node));
    scene.rod((0..6).collect(), stiffness, 0.0, 0.0);
    let amplitude = 0.1;
    scene.initial.twists = vec![amplitude];
    let rate = f64::from(stiffness).sqrt() / f64::from(arm_m);
    let period_frames = (TAU / rate * scene.timing.fps).round() as usize;
    scene.timing.substeps = 200;
    scene.last(period_frames);
    let states = scene.states(backend)?;
    let half = twist(&states[period_frames / 2])?;
    close("twist after half a period", half, -f64::from(amplitude), 0.02 * f64::from(amplitude))?;
    let whole = twist(&states[period_frames])?;
    close("twist after a period", whole, amplitude.into(), 0.02 * f64::from(amplitude))?;
    // Where it was not twisted at the start it is now to the side.
    let side = f64::from(states[period_frames / 2].positions[5][2]);
    close("way to the side", side.abs(), 0.2 * f64::from(arm_m), 0.02 * f64::from(arm_m))
}

/// Twist damping alone only takes kinetic energy, rounding aside, and takes a good part of it.
pub(crate) fn twist_damping_never_raises_energy(backend: &dyn Backend) -> Outcome {
    let mut scene = cable();
    scene.params.spring_stiffness.fill(0.0);
    scene.params.bend_stiffness.fill(0.0);
    scene.params.twist_damping[0] = 0.5;
    for (i, v) in scene.initial.velocities.iter_mut().enumerate() {
        // To and fro in pairs, which is how a bent rod twists most.
        let t = if i % 4 < 2 { 0.02 } else { -0.02 };
        *v = [0.0, t, t];
    }
    [0, 1, 8, 9].into_iter().for_each(|i| scene.initial.velocities[i] = [0.0; 3]);
    scene.last(50);
    let energies: Vec<f64> =
        scene.states(backend)?.iter().map(|s| energy::kinetic(&scene, s)).collect();
    for (frame, pair) in energies.windows(2).enumerate() {
        ensure(pair[1] <= pair[0] * (1.0 + 1e-6), || {
            format!("kinetic energy rises from {} to {} in frame {frame}", pair[0], pair[1])
        })?;
    }
    let (first, last) = (energies[0], energies[energies.len() - 1]);
    ensure(last < 0.99 * first, || format!("it takes next to nothing: {first} to {last}"))
}

/// A twisted bow, more curved at its top than at its feet, turns out of its plane, one half to each
/// side, and the other way around if it is twisted the other way. (A straight rod or an even arc
/// would stay where it is.)
pub(crate) fn twist_turns_a_bow_out_of_its_plane(backend: &dyn Backend) -> Outcome {
    let bow = |twist: f32| -> Result<f64, String> {
        let points: Vec<Point> = (0..9)
            .map(|i| {
                let x = 0.04 * (i as f32 - 4.0);
                [x, 0.1 * (9.0 * x).cos(), 0.0]
            })
            .collect();
        let mut scene = Scene::of(&points);
        (1..9).for_each(|i| scene.spring([i - 1, i], 300.0, 0.3));
        (1..8).for_each(|j| scene.triplet([j - 1, j, j + 1], 0.0, 0.1, 1e-3));
        scene.relax();
        [0, 1, 7, 8].into_iter().for_each(|node| scene.fix(node));
        scene.rod((0..9).collect(), 0.02, 1e-4, 0.0);
        scene.params.drag = 5.0;
        scene.timing.substeps = 40;
        scene.initial.twists = vec![twist];
        scene.last(200);
        let end = scene.end(backend)?;
        Ok(f64::from(end.positions[3][2]) - f64::from(end.positions[5][2]))
    };
    let (left, none, right) = (bow(-1.0)?, bow(0.0)?, bow(1.0)?);
    ensure(left * right < 0.0 && left.abs() > 1e-3, || format!("moved by {left} and {right} m"))?;
    close("mirrored", left, -right, 0.01 * left.abs())?;
    close("without twist", none, 0.0, 1e-6)
}

/// A rod without stiffness and damping changes no bit of anything else.
pub(crate) fn rods_without_stiffness_change_nothing(backend: &dyn Backend) -> Outcome {
    let options = RandomOptions { rod: true, pins: 4, ..RandomOptions::default() };
    let model = random_model(2, &options);
    let (state, controls) = random_motion(2, &model, 4);
    let objective = random_objective(2, &model, 4);
    let mut with = Scene::around(model, state, controls, 4);
    with.objective = objective;
    with.params.twist_stiffness.fill(0.0);
    with.params.twist_damping.fill(0.0);
    let mut without = with.clone();
    without.graph.rods.clear();
    without.params.twist_stiffness.clear();
    without.params.twist_damping.clear();
    without.params.rest_twists_rad.clear();
    without.initial.twists.clear();
    let (a, b) = (with.end(backend)?, without.end(backend)?);
    ensure(a.positions == b.positions && a.velocities == b.velocities, || {
        "a rod without stiffness moves nodes".into()
    })?;
    ensure(a.twists.len() == 1 && a.twists != with.initial.twists, || {
        format!("its twist is {:?}", a.twists)
    })?;
    let request = GradientRequest { initial: true, controls: true, ..GradientRequest::default() };
    let (a, b) = (with.gradient(backend, &request)?, without.gradient(backend, &request)?);
    ensure(a.params.spring_stiffness == b.params.spring_stiffness && a.loss == b.loss, || {
        "a rod without stiffness changes gradients".into()
    })
}
