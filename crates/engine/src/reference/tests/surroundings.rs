//! Grasps, colliders and rolling clamps.

use super::*;
use crate::objective::ForceBy;
use crate::world::{Attachment, Collider, Face, Grasp, Hold, Phase, Region, Shape};

/// A body that starts at `at`, and in every frame moves by `by` and turns about z by an angle.
fn path(frames: usize, at: [f64; 3], by: [f64; 3], angle: f64) -> Vec<Pose64> {
    (0..=frames)
        .map(|f| {
            let (sine, cosine) = (angle * f as f64).sin_cos();
            let p: [f64; 3] = std::array::from_fn(|c| at[c] + by[c] * f as f64);
            [[cosine, -sine, 0.0, p[0]], [sine, cosine, 0.0, p[1]], [0.0, 0.0, 1.0, p[2]]]
        })
        .collect()
}

/// Poses of bodies, by frame and body.
fn together(paths: &[Vec<Pose64>]) -> Vec<Pose64> {
    (0..paths[0].len()).flat_map(|f| paths.iter().map(move |p| p[f])).collect()
}

fn grasp(body: u32, region: Region, attachment: Attachment) -> Grasp {
    Grasp { body, region, attachment, max_force: f32::INFINITY }
}

fn capsule(body: Option<u32>, from: [f32; 3], to: [f32; 3], radius_m: f32) -> Collider {
    let shape = Shape::Capsule { from, to, radius_m };
    Collider { body, shape, friction: 0.4, restitution: 0.3 }
}

/// Hands that close, open and hold from the start, by pins, springs and control points.
fn grasped(seed: u64) -> (Model, Reference) {
    let mut model = body(seed);
    model.environment.ground = None;
    model.params.contact.between_objects = false;
    let mut r = scene(&model, 4);
    let spring = Attachment::Spring { stiffness: 300.0, damping: 2.0 };
    let sphere = Region::Sphere { center: [0.0; 3], radius_m: 0.035 };
    let low = [-0.02, -0.02, 0.07];
    r.world.bodies = 2;
    r.world.grasps = vec![
        grasp(0, sphere, Attachment::Pin),
        grasp(1, Region::Nodes(Arc::new(vec![2, 3])), spring),
        grasp(1, Region::Controls(Arc::new(vec![0])), Attachment::Pin),
        grasp(1, Region::Box { low, high: [0.02, 0.02, 0.12] }, Attachment::Pin),
    ];
    r.poses = together(&[
        path(4, [0.05, 0.04, 0.1], [0.003, 0.001, 0.004], 0.06),
        path(4, [0.0, 0.0, 0.01], [-0.002, 0.003, 0.001], -0.05),
    ]);
    r.closed = [
        [false, true, true, true],
        [true, true, true, true],
        [true, false, false, true],
        [false, true, false, true],
    ]
    .concat();
    r.grasping.phases = vec![Phase::Open, Phase::Closed, Phase::Closed, Phase::Open];
    r.grasping.holds = vec![Hold { node: 2, grasp: 1, place: [0.0; 3] }];
    r.places = vec![[0.01, 0.05, -0.02]];
    (model, r)
}

/// No contact, so all is smooth: relative 1e-6.
#[test]
fn gradients_through_grasps_match_finite_differences() {
    for control_velocity in [ControlVelocity::True, ControlVelocity::Ignored] {
        let (mut model, mut r) = grasped(5);
        model.control_velocity = control_velocity;
        r.model = model.clone();
        let errors = errors(&r, &objective(&model, 4), 1e-5);
        assert_small(&errors, 1e-6, &CONTACT);
    }
}

/// Capsules and a box on bodies that move and turn, over the ground, with nodes flung at them.
fn flung() -> (Model, Reference) {
    let mut model = body(6);
    model.environment.ground = Some(Plane { normal: [0.6, 0.0, 0.8], offset_m: 0.0 });
    model.params.contact.between_objects = false;
    let mut r = scene(&model, 3);
    let axis = |c: usize, sign: f32| Face {
        normal: std::array::from_fn(|i| if i == c { sign } else { 0.0 }),
        offset_m: 0.03,
    };
    let faces = (0..3).flat_map(|c| [axis(c, 1.0), axis(c, -1.0)]).collect();
    r.world.bodies = 2;
    r.world.colliders = vec![
        capsule(Some(0), [-0.03, 0.0, 0.0], [0.03, 0.01, 0.0], 0.02),
        Collider {
            body: Some(1),
            shape: Shape::Convex(Arc::new(faces)),
            friction: 0.3,
            restitution: 0.2,
        },
        capsule(None, [0.075, 0.0, 0.0], [0.075, 0.0, 0.0], 0.03),
    ];
    r.poses = together(&[
        path(3, [0.02, 0.02, 0.125], [0.001, 0.001, -0.004], 0.05),
        path(3, [0.02, -0.045, 0.05], [0.0, 0.003, 0.001], -0.04),
    ]);
    r.velocities.iter_mut().for_each(|v| v[1] -= 0.3);
    r.velocities[8..].iter_mut().for_each(|v| v[2] += 0.5);
    (model, r)
}

/// Impacts are piecewise smooth, so steps are small, which costs digits: 1e-5.
#[test]
fn gradients_through_colliders_match_finite_differences() {
    let (model, r) = flung();
    let all = r.loss(&objective(&model, 3)).unwrap().total;
    for k in 0..3 {
        let mut without = r.clone();
        without.world.colliders.remove(k);
        let loss = without.loss(&objective(&model, 3)).unwrap().total;
        assert_ne!(loss, all, "collider {k} touches nothing");
    }
    let mut with_forces = objective(&model, 3);
    let by = [ForceBy::Ground, ForceBy::Collider(0), ForceBy::Collider(1), ForceBy::Collider(2)];
    terms_of_forces(&mut with_forces, 3, &by, 3);
    let errors = errors(&r, &objective(&model, 3), 1e-7);
    assert_small(&errors, 1e-5, &CONTACT[2..]);
    // Forces jump where a step moves an impact to another substep.
    let errors = least_errors(&r, &with_forces, &[1e-7, 1e-8, 1e-9]);
    assert_small(&errors, 1e-4, &CONTACT[2..]);
}

/// A layer makes contact smooth.
#[test]
fn gradients_through_smooth_contact_match_finite_differences() {
    let (model, mut r) = flung();
    r.world.smoothing_m = 4e-3;
    let mut objective = objective(&model, 3);
    let by = [ForceBy::Ground, ForceBy::Collider(0), ForceBy::Collider(1)];
    terms_of_forces(&mut objective, 3, &by, 3);
    let errors = errors(&r, &objective, 1e-6);
    assert_small(&errors, 1e-5, &CONTACT[2..]);
}

/// Terms by force and clearance, over every frame.
fn terms_of_forces(objective: &mut Objective, frames: usize, by: &[ForceBy], colliders: u32) {
    let terms = Arc::make_mut(&mut objective.terms);
    for frame in 1..=frames {
        let forces = by.iter().map(|&by| Term::Force { by, limit: 0.5 });
        let gaps = (0..colliders).map(|collider| Term::Clearance { collider, margin_m: 0.06 });
        let all = forces.map(|t| (1e-4, t)).chain(gaps.map(|t| (50.0, t)));
        let weighted = all.map(|(weight, term)| WeightedTerm { frame, weight, group: 0, term });
        terms.extend(weighted);
    }
}

/// Forces by control points, pins, springs and hands of either kind: relative 1e-6.
#[test]
fn gradients_of_forces_by_grasps_match_finite_differences() {
    let (model, r) = grasped(7);
    let mut objective = objective(&model, 4);
    let by = [ForceBy::Controls, ForceBy::Control(1), ForceBy::Grasp(0), ForceBy::Grasp(1)];
    let by = [&by[..], &[ForceBy::Grasp(2), ForceBy::Grasp(3)]].concat();
    terms_of_forces(&mut objective, 4, &by, 0);
    let errors = errors(&r, &objective, 1e-5);
    assert_small(&errors, 1e-6, &CONTACT);
}
