//! Axial springs, drag, pins and control springs against closed forms.

use bendtwin_core::environment::ControlVelocity;
use bendtwin_engine::{Backend, backend::Rollout};

use crate::{
    expect::{Outcome, close, ensure},
    scene::{Scene, difference, norm},
};

const G: f64 = 9.81;

/// Two nodes of masses 1 and 2, 0.5 m apart, stretched by 5 cm.
fn pair(stiffness: f32, dashpot: f32) -> Scene {
    let mut scene = Scene::of(&[[0.0; 3], [0.5, 0.0, 0.0]]);
    scene.graph.masses[1] = 2.0;
    scene.spring([0, 1], stiffness, dashpot);
    scene.initial.positions[1][0] = 0.55;
    scene.last(100);
    scene
}

fn extensions(rollout: &Rollout) -> impl Iterator<Item = (usize, f64)> {
    let of = |p: &[[f32; 3]]| norm(difference(p[1], p[0])) - 0.5;
    rollout.frames.iter().copied().zip(rollout.positions.chunks_exact(2).map(of))
}

/// The extension e of two masses obeys e'' = -w² e with w² = (k/l0)(1/m1 + 1/m2), exactly.
/// Semi-implicit Euler from rest gives e_n = A [cos(n p) - tan(p/2) sin(n p)] with
/// cos p = 1 - (w dt)²/2: to be met to 0.2 % of A (rounding of 2,000 f32 steps at 0.5 m),
/// and cos(w t) within its phase error w dt/2 + w t (w dt)²/24.
pub(crate) fn oscillator_frequency(backend: &dyn Backend) -> Outcome {
    let scene = pair(50.0, 0.0);
    let (a, w, dt) = (0.05, (50.0_f64 / 0.5 * 1.5).sqrt(), scene.dt());
    let p = (1.0 - (w * dt).powi(2) / 2.0).acos();
    let rollout = scene.roll_out(backend)?;
    for (frame, e) in extensions(&rollout) {
        let n = frame as f64 * f64::from(scene.timing.substeps);
        let exact = a * ((n * p).cos() - (p / 2.0).tan() * (n * p).sin());
        close(&format!("extension in frame {frame}"), e, exact, 2e-3 * a)?;
        let t = n * dt;
        let phase = w * dt / 2.0 + w * t * (w * dt).powi(2) / 24.0;
        close(&format!("oscillation at {t:.2} s"), e, a * (w * t).cos(), a * (phase + 2e-3))?;
    }
    Ok(())
}

/// e'' = -w² e - 2 z w e': the closed form within 2 w dt of A, as the integrator is of first order.
pub(crate) fn damped_oscillator_decays(backend: &dyn Backend) -> Outcome {
    let scene = pair(50.0, 2.0);
    let a = 0.05;
    let w = (50.0_f64 / 0.5 * 1.5).sqrt();
    let decay = 2.0 * 1.5 / 2.0; // z w = gamma (1/m1 + 1/m2) / 2
    let wd = (w * w - decay * decay).sqrt();
    let rollout = scene.roll_out(backend)?;
    for (frame, e) in extensions(&rollout) {
        let t = frame as f64 * scene.timing.frame_s();
        let exact = a * (-decay * t).exp() * ((wd * t).cos() + decay / wd * (wd * t).sin());
        let tolerance = a * 2.0 * w * scene.dt();
        close(&format!("damped extension at {t:.2} s"), e, exact, tolerance)?;
    }
    Ok(())
}

/// Link i carries all nodes below it: k (l/l0 - 1) = g · their number. To 5 µm:
/// f32 positions resolve 0.06 µm, and each link adds its own rounding.
pub(crate) fn hanging_chain_stretches(backend: &dyn Backend) -> Outcome {
    let (links, k, l0) = (6_u32, 1000.0_f64, 0.1_f64);
    let points: Vec<_> = (0..=links).map(|i| [0.0, 0.0, -0.1 * i as f32]).collect();
    let mut scene = Scene::of(&points);
    (0..links).for_each(|i| scene.spring([i, i + 1], k as f32, 1.0));
    scene.environment.gravity[2] = -G as f32;
    scene.params.drag = 10.0;
    scene.fix(0);
    scene.last(500);
    let end = scene.end(backend)?;
    for i in 0..links as usize {
        let l = norm(difference(end.positions[i + 1], end.positions[i]));
        let expected = l0 * (1.0 + G * f64::from(links - i as u32) / k);
        close(&format!("length of link {i}"), l, expected, 5e-6)?;
    }
    Ok(())
}

/// v(t) = v0 exp(-drag t) and x(t) = v0 (1 - exp(-drag t)) / drag: drag is applied
/// exactly each substep, so v to 0.01 % (rounding) and x to a substep's motion.
pub(crate) fn drag_decays_exponentially(backend: &dyn Backend) -> Outcome {
    let mut scene = Scene::of(&[[0.1, 0.2, 0.3]]);
    scene.params.drag = 3.0;
    scene.initial.velocities[0] = [1.0, -2.0, 0.5];
    scene.last(100);
    let end = scene.end(backend)?;
    for (axis, v0) in [1.0_f64, -2.0, 0.5].into_iter().enumerate() {
        let v = f64::from(end.velocities[0][axis]);
        close("velocity after 1 s", v, v0 * (-3.0_f64).exp(), 1e-4 * v0.abs())?;
        let moved = f64::from(end.positions[0][axis] - scene.initial.positions[0][axis]);
        let expected = v0 * (1.0 - (-3.0_f64).exp()) / 3.0;
        close("path in 1 s", moved, expected, 2.0 * v0.abs() * scene.dt())?;
    }
    Ok(())
}

/// A pinned node is where its control point is, plus its offset, at every frame end and at the
/// start even if the initial state has it elsewhere. To 1 µm: rounding of one sum.
pub(crate) fn pinned_node_follows_its_control(backend: &dyn Backend) -> Outcome {
    let mut scene = Scene::of(&[[0.0; 3], [0.1, 0.0, 0.0]]);
    scene.spring([0, 1], 100.0, 1.0);
    scene.environment.gravity[2] = -9.81;
    scene.control([0.0, 0.0, 0.05]);
    scene.pin(0, 0);
    let path = |f: usize| [0.01 * f as f32, (0.3 * f as f32).sin() * 0.05, 0.002 * f as f32];
    scene.drive(30, path);
    scene.initial.positions[0] = [0.3, 0.2, 0.1];
    let rollout = scene.roll_out(backend)?;
    ensure(rollout.frames.len() == 31, || format!("{} frames", rollout.frames.len()))?;
    for (&frame, nodes) in rollout.frames.iter().zip(rollout.positions.chunks_exact(2)) {
        let off = norm(difference(nodes[0], path(frame)));
        close(&format!("distance of the pinned node in frame {frame}"), off, 0.0, 1e-6)?;
    }
    Ok(())
}

/// A node on a damped control spring, the control moving at constant velocity.
fn towed(control_velocity: ControlVelocity) -> Scene {
    let mut scene = Scene::of(&[[0.0; 3]]);
    let control = scene.control([0.2, 0.0, 0.0]);
    scene.spring([0, control], 100.0, 20.0);
    scene.control_velocity = control_velocity;
    scene.drive(200, |f| [0.005 * f as f32, 0.0, 0.0]); // 0.5 m/s
    scene
}

/// Towed at constant velocity the node ends at rest length behind its control, at its
/// velocity. To 0.4 mm: one substep's motion (the control steps before or after the node does).
pub(crate) fn control_spring_drags_a_node(backend: &dyn Backend) -> Outcome {
    let end = towed(ControlVelocity::True).end(backend)?;
    close("final velocity", f64::from(end.velocities[0][0]), 0.5, 1e-3)?;
    close("final position", f64::from(end.positions[0][0]), 1.0, 4e-4)
}

/// With the control's velocity counted as zero, the dashpot holds the node back by gamma v, which
/// the spring balances at an extension of gamma v l0 / k = 2 cm. To 0.4 mm: one substep's motion
/// as above.
pub(crate) fn ignored_control_velocity_leaves_a_lag(backend: &dyn Backend) -> Outcome {
    let end = towed(ControlVelocity::Ignored).end(backend)?;
    close("final velocity", f64::from(end.velocities[0][0]), 0.5, 1e-3)?;
    close("final position", f64::from(end.positions[0][0]), 1.0 - 0.02, 4e-4)
}
