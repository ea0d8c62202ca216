//! Force laws against energies, and bending against the discrete beam.

use std::f32::consts::PI;

use bendtwin_core::Timing;
use bendtwin_engine::Backend;

use crate::{
    energy,
    expect::{Outcome, close},
    random::{RandomOptions, random_model, random_motion},
    scene::{Scene, difference, dot, norm},
};

/// A random free network in a random state, to run for one substep of 0.1 ms.
fn one_substep(seed: u64) -> Scene {
    let options = RandomOptions { pins: 0, ..RandomOptions::default() };
    let mut model = random_model(seed, &options);
    model.params.drag = 0.0;
    model.timing = Timing { fps: 1e4, substeps: 1 };
    let (state, _) = random_motion(seed, &model, 1);
    let mut scene = Scene::around(model, state, Vec::new(), 1);
    scene.last(1);
    scene
}

/// After one substep from rest, v = -dt/m dE/dx. To 0.1 % of the largest force: strains of
/// 0.1 are known to 1e-6 in f32.
pub(crate) fn forces_are_minus_the_energy_gradient(backend: &dyn Backend) -> Outcome {
    for seed in 0..8 {
        let mut scene = one_substep(seed);
        scene.initial.velocities.fill([0.0; 3]);
        let forces = energy::elastic_forces(&scene, &scene.initial);
        let largest = forces.iter().map(|f| norm(*f)).fold(0.0, f64::max);
        let end = scene.end(backend)?;
        for (i, force) in forces.iter().enumerate() {
            let m = f64::from(scene.graph.masses[i]);
            for (axis, expected) in force.iter().enumerate() {
                let got = f64::from(end.velocities[i][axis]) * m / scene.dt();
                let what = format!("seed {seed}: force on node {i} along axis {axis}");
                close(&what, got, *expected, 1e-3 * largest)?;
            }
        }
    }
    Ok(())
}

/// The power of all damping forces is minus the sum of gamma (dl/dt)² and c_b (dtheta/dt)²: f.v
/// of the difference between a substep with velocities and one without. To 0.5 % of that sum
/// plus the rounding of the elastic force times the speed.
pub(crate) fn damping_forces_take_power(backend: &dyn Backend) -> Outcome {
    for seed in 0..8 {
        let mut moving = one_substep(seed);
        // Control points stand still: their own velocity adds no power.
        moving.last(1);
        moving.params.spring_stiffness.fill(0.0);
        moving.params.bend_stiffness.fill(0.0);
        for (bend, gamma) in [(0.0, 1.0), (1.0, 0.0), (1.0, 1.0)] {
            let mut scene = moving.clone();
            scene.params.spring_dashpot.iter_mut().for_each(|x| *x *= gamma);
            scene.params.bend_damping.iter_mut().for_each(|x| *x *= bend);
            let end = scene.end(backend)?;
            let power: f64 = (0..scene.graph.node_count())
                .map(|i| {
                    let kick = difference(end.velocities[i], scene.initial.velocities[i]);
                    let force = kick.map(|k| k * f64::from(scene.graph.masses[i]) / scene.dt());
                    dot(force, scene.initial.velocities[i].map(f64::from))
                })
                .sum();
            let expected = energy::dissipation(&scene, &scene.initial);
            let rounding = 24.0 * 0.2 * 1e-7 * 0.2 / scene.dt();
            let what = format!("seed {seed}: power of damping (axial {gamma}, bending {bend})");
            close(&what, power, -expected, 5e-3 * expected + rounding)?;
        }
    }
    Ok(())
}

/// A horizontal chain of `links` links along x, nodes 0 and 1 clamped, theta0 = pi.
fn cantilever(links: u32, gravity: f32) -> Scene {
    let points: Vec<_> = (0..=links).map(|i| [0.1 * i as f32, 0.0, 0.0]).collect();
    let mut scene = Scene::of(&points);
    (0..links).for_each(|i| scene.spring([i, i + 1], 1e4, 10.0));
    (1..links).for_each(|j| scene.triplet([j - 1, j, j + 1], PI, 128.0, 1.0));
    scene.environment.gravity[2] = -gravity;
    scene.params.drag = 8.0;
    scene.timing = Timing { fps: 50.0, substeps: 80 };
    scene.fix(0);
    scene.fix(1);
    scene.last(250);
    scene
}

/// Heights of the nodes of [`cantilever`] in equilibrium, exactly: link q has the slope a_q and the
/// length l_q that make E = sum k_theta (a_q - a_(q-1))²/2 + k (l_q - l0)²/(2 l0) + g z stationary,
/// with W_q = g · (nodes beyond link q) on its end: k_theta (f_q - f_(q+1)) = -W_q l_q cos a_q, f_q
/// = a_q - a_(q-1), and l_q = l0 (1 - W_q sin a_q / k).
fn exact_heights(links: usize, gravity: f64) -> Vec<f64> {
    let (k, k_theta, l0) = (1e4, 128.0, 0.1);
    let load = |q: usize| gravity * (links - q) as f64;
    let mut slopes = vec![0.0_f64; links];
    let mut lengths = vec![l0; links];
    for _ in 0..500 {
        let mut moment = 0.0;
        let mut turns = vec![0.0; links];
        for q in (1..links).rev() {
            moment -= load(q) * lengths[q] * slopes[q].cos();
            turns[q] = moment / k_theta;
        }
        for q in 1..links {
            // Half steps: the plain iteration overshoots for large loads.
            slopes[q] = 0.5 * (slopes[q] + slopes[q - 1] + turns[q]);
            lengths[q] = l0 * (1.0 - load(q) * slopes[q].sin() / k);
        }
    }
    let mut heights = vec![0.0];
    for q in 0..links {
        heights.push(heights[q] + lengths[q] * slopes[q].sin());
    }
    heights
}

/// The small-deflection discrete Euler-Bernoulli beam in closed form: the moment at node j is
/// -g h (n-j)(n-j+1)/2, and w_(j+1) = 2 w_j - w_(j-1) + h M_j / k_theta.
fn small_deflections(links: usize, gravity: f64) -> Vec<f64> {
    let h = 0.1;
    let mut w = vec![0.0, 0.0];
    for j in 1..links {
        let beyond = (links - j) as f64;
        let moment = -gravity * h * beyond * (beyond + 1.0) / 2.0;
        w.push(2.0 * w[j] - w[j - 1] + h * moment / 128.0);
    }
    w
}

/// The chain settles at the exact equilibrium of the discrete beam, for a small load
/// (deflection 1 % of the length, where the linear closed form holds to 0.1 % too) and for a large
/// one (half of the length). To 0.2 % of the tip's deflection plus 20 µm: at the small
/// load f32 resolves the angles, of 0.001 to 0.006 rad, to some 1e-6.
pub(crate) fn cantilever_bends_like_the_discrete_beam(backend: &dyn Backend) -> Outcome {
    let links = 8;
    for gravity in [0.25, 20.0] {
        let scene = cantilever(links as u32, gravity as f32);
        let exact = exact_heights(links, gravity);
        let end = scene.end(backend)?;
        let tolerance = 2e-3 * exact[links].abs() + 2e-5;
        for (i, expected) in exact.iter().enumerate() {
            let height = f64::from(end.positions[i][2]);
            close(&format!("height of node {i} at g = {gravity}"), height, *expected, tolerance)?;
        }
        if gravity < 1.0 {
            let linear = small_deflections(links, gravity)[links];
            close("the linear beam's tip", linear, exact[links], 1e-3 * linear.abs())?;
        }
    }
    Ok(())
}

/// The middle of three nodes, its neighbours fixed, swings through the straight line, where the
/// direction of the bending force is 0/0: w² = 4 k_theta / (m h²), and semi-implicit
/// Euler's solution as for the oscillator. Once with 1 mm, and once with 2 µm, where the
/// line is never left by more than 4e-5 rad. To 1 % of the amplitude: f32 resolves the
/// angle of the larger swing, 0.02 rad, to 1e-6 at best, over 2,000 substeps; the smaller one's
/// differences of coordinates are exact, as they cross zero.
pub(crate) fn straight_rod_stays_smooth_through_pi(backend: &dyn Backend) -> Outcome {
    for a in [1e-3_f64, 2e-6] {
        let mut scene = Scene::of(&[[-0.1, 0.0, 0.0], [0.0; 3], [0.1, 0.0, 0.0]]);
        scene.triplet([0, 1, 2], PI, 1.0, 0.0);
        scene.fix(0);
        scene.fix(2);
        scene.initial.positions[1][2] = a as f32;
        scene.last(100);
        let (w, dt) = (20.0_f64, scene.dt());
        let p = (1.0 - (w * dt).powi(2) / 2.0).acos();
        let rollout = scene.roll_out(backend)?;
        for (&frame, nodes) in rollout.frames.iter().zip(rollout.positions.chunks_exact(3)) {
            let n = frame as f64 * f64::from(scene.timing.substeps);
            let exact = a * ((n * p).cos() - (p / 2.0).tan() * (n * p).sin());
            let what = format!("swing of {a} m in frame {frame}");
            close(&what, f64::from(nodes[1][2]), exact, 1e-2 * a)?;
        }
    }
    Ok(())
}
