//! Further recordings of a scene's body: held elsewhere, moved in other ways, and lying turned on the
//! table.

use std::f32::consts::TAU;

use bendtwin_core::{Capture, Point};

use super::{
    Scene,
    pose::{Pose, smoothstep},
    scene::{RING_RADIUS_M, Setup},
};

/// Changes a scene's setup to that of another recording of its body.
pub(super) fn vary(setup: &mut Setup, scene: Scene, take: u32) {
    let Some(index) = take.checked_sub(1) else { return };
    let hand = &mut setup.hand;
    let [x, y, z] = hand.grasp;
    // Of a long body the other end, the middle and near an end; of the toy its limbs and its back; of
    // the ring the far side, then either side.
    let length = setup.body.positions.iter().map(|p| p[0]).fold(f32::MIN, f32::max);
    let (grasp, forearm): (Point, Point) = match (scene, index % 3) {
        (Scene::Toy, 0) => ([0.033, 0.082, 0.02], [0.2, 0.8, 1.0]),
        (Scene::Toy, 1) => ([-0.048, -0.072, 0.02], [-0.4, -0.7, 1.0]),
        (Scene::Toy, _) => ([-0.045, 0.0, 0.055], [-0.5, 0.0, 1.0]),
        (Scene::Ring, 1) => ([0.5 * length, RING_RADIUS_M, z], [0.0, 1.0, 0.5]),
        (Scene::Ring, 2) => ([0.5 * length, -RING_RADIUS_M, z], [0.0, -1.0, 0.5]),
        (_, 0) => ([length - x, y, z], [1.0, 0.0, 0.5]),
        (_, 1) => ([0.5 * length, y, z], [0.0, 0.6, 1.0]),
        (_, _) => ([0.25 * length, y, z], [-0.6, 0.5, 1.0]),
    };
    (hand.grasp, hand.forearm) = (grasp, forearm);
    setup.motion = match index % 3 {
        0 => sway,
        1 => circle,
        _ => jerk,
    };
}

/// Lifts the far end's way and sways widely.
fn sway(t: f32) -> Pose {
    let after = |start: f32, ramp: f32| smoothstep((t - start) / ramp);
    let swing = |start: f32, hz: f32| (TAU * hz * (t - start)).sin() * after(start, 0.4);
    let shift = [
        0.05 * swing(0.9, 0.6),
        0.06 * swing(1.0, 0.8),
        0.26 * smoothstep(t / 1.2) + 0.03 * swing(1.3, 1.2),
    ];
    Pose::new(0.2 * swing(1.0, 0.5), -0.35 * smoothstep(t / 1.2), shift)
}

/// Lifts straight up and moves in circles.
fn circle(t: f32) -> Pose {
    let on = smoothstep((t - 0.8) / 0.5);
    let (s, c) = (TAU * 0.9 * (t - 0.8)).sin_cos();
    let shift = [0.05 * on * s, 0.05 * on * (1.0 - c), 0.27 * smoothstep(t / 1.0)];
    Pose::new(0.3 * on * s, 0.1 * on * c, shift)
}

/// Lifts fast, tilts and jerks up and down.
fn jerk(t: f32) -> Pose {
    let after = |start: f32, ramp: f32| smoothstep((t - start) / ramp);
    let swing = |start: f32, hz: f32| (TAU * hz * (t - start)).sin() * after(start, 0.3);
    let shift = [
        0.02 * swing(0.8, 1.4),
        0.03 * swing(1.1, 0.9),
        0.25 * smoothstep(t / 0.8) + 0.04 * swing(0.9, 1.6),
    ];
    Pose::new(-0.25 * swing(1.0, 0.7), 0.25 * smoothstep(t / 0.9), shift)
}

/// Lays a recording down elsewhere on the table.
pub(super) fn lay_down(capture: &mut Capture, take: u32) {
    if take == 0 {
        return;
    }
    let n = take as f32;
    let pose = Pose::new(1.7 * n, 0.0, [0.3 * (1.1 * n).sin(), 0.3 * (1.1 * n).cos(), 0.0]);
    let turn = |points: &mut Vec<Point>| {
        points.iter_mut().for_each(|p| *p = pose.carry([0.0; 3], *p));
    };
    turn(&mut capture.object.completed_surface);
    turn(&mut capture.object.interior);
    for sequence in &mut capture.sequences {
        turn(&mut sequence.points);
        turn(&mut sequence.controls);
        turn(&mut sequence.truth_tracks);
    }
}
