//! Forces beyond a limit.

use crate::{
    cpu::{
        arithmetic::{Quad, Real, add, add_scaled, dot},
        surroundings::force::{ForceSeeds, FrameForces},
    },
    objective::ForceBy,
};

/// The mean force over the frame.
fn force<T: Real>(forces: &FrameForces<T>, by: ForceBy) -> Quad<T> {
    match by {
        ForceBy::Controls => forces.controls.iter().fold([T::ZERO; 4], |sum, f| add(sum, *f)),
        ForceBy::Control(c) => forces.controls[c as usize],
        ForceBy::Grasp(g) => forces.grasps[g as usize][0],
        ForceBy::Ground => forces.ground,
        ForceBy::Collider(k) => forces.colliders[k as usize][0],
    }
}

/// Square of the excess over the limit.
pub(super) fn value<T: Real>(forces: &FrameForces<T>, by: ForceBy, limit: f32) -> f64 {
    let f = force(forces, by);
    (dot(f, f).to_f64().sqrt() - f64::from(limit)).max(0.0).powi(2)
}

/// Adds the gradient of [`value`].
pub(super) fn add_gradient<T: Real>(
    forces: &FrameForces<T>,
    by: ForceBy,
    limit: f32,
    weight: f64,
    seeds: &mut ForceSeeds<T>,
) {
    let f = force(forces, by);
    let size = dot(f, f).to_f64().sqrt();
    let excess = size - f64::from(limit);
    if excess <= 0.0 || size <= 0.0 {
        return;
    }
    let by_force = T::from_f64(2.0 * weight * excess / size);
    let add_to = |seed: &mut Quad<T>| *seed = add_scaled(*seed, by_force, f);
    match by {
        ForceBy::Controls => seeds.controls.iter_mut().for_each(add_to),
        ForceBy::Control(c) => add_to(&mut seeds.controls[c as usize]),
        ForceBy::Grasp(g) => add_to(&mut seeds.grasps[g as usize]),
        ForceBy::Ground => add_to(&mut seeds.ground),
        ForceBy::Collider(k) => add_to(&mut seeds.colliders[k as usize]),
    }
}
