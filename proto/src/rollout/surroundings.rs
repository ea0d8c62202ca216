//! Size and memory of what surrounds an object in a rollout: moving bodies, forces, parameters that
//! differ by instance, implausible instances.

use super::{
    check::{Batch, bodies_of, members, sets},
    size::Sum,
    twin::TwinShape,
};
use crate::v1::RollOutRequest;

/// Longest encoding of an `Implausible`: tag and length, an index, the longest reason, two numbers
/// and a frame; and the reasons that an instance can have.
const IMPLAUSIBLE: u64 = 3 + 6 + (2 + 19) + 2 * 9 + 6;
const REASONS: u64 = 4;
/// A pose of a body, and its gradient.
const POSE: u64 = 48;
/// A parameter of an element in the engine and in the model that keeps it.
const PARAMETER: u64 = 16;
/// A set of parameters beside its arrays.
const SET: u64 = 4096;
/// A face of a collider, and faces of all of them at most.
const FACES: u64 = 16 * 32 * 128;

/// Adds what surroundings and ensembles add to a message of the reply that covers `covered` actions
/// and holds arrays of `held` instances.
pub(super) fn add_reply(
    request: &RollOutRequest,
    batch: &Batch,
    twin: &TwinShape,
    [covered, held]: [u64; 2],
    sum: &mut Sum,
) {
    let members = members(request);
    let instances = covered.saturating_mul(members);
    sum.add(instances.saturating_mul(REASONS * IMPLAUSIBLE));
    if request.ensemble.is_some() {
        sum.tensor(2, 8, &[covered, members]);
    }
    if request.returns.as_ref().is_some_and(|returns| returns.forces) {
        let mut forces = Sum(0);
        let (grasps, colliders) = parts(request);
        forces.tensor(1, 4, &[held, batch.frames, twin.controls, 3]);
        forces.tensor(1, 4, &[held, batch.frames, grasps, 6]);
        forces.tensor(1, 4, &[held, batch.frames, 3]);
        forces.tensor(1, 4, &[held, batch.frames, colliders, 6]);
        sum.message(2, &forces);
    }
}

/// Memory that all instances share [bytes]: sets of parameters and what they surround.
pub(super) fn fixed_bytes(request: &RollOutRequest, batch: &Batch, twin: &TwinShape) -> u64 {
    let elements = sum(&[twin.springs, twin.triplets, twin.rods.unwrap_or(0)]);
    let each = sum(&[elements.saturating_mul(3 * PARAMETER), SET]);
    let own = if request.world.is_some() { 1 } else { 0 };
    sum(&[
        each.saturating_mul(sets(request, batch).saturating_add(own)),
        if bodies_of(request) > 0 || own > 0 { FACES } else { 0 },
        // Costs of members, kept until all are there.
        batch.instances.saturating_mul(members(request)).saturating_mul(64),
    ])
}

/// Memory of an instance that is prepared [bytes]: poses of bodies and what is closed.
pub(super) fn prepared_bytes(request: &RollOutRequest, batch: &Batch) -> u64 {
    let (grasps, _) = parts(request);
    let boundaries = batch.frames.saturating_add(1);
    let frame = sum(&[bodies_of(request).saturating_mul(POSE), grasps]);
    boundaries.saturating_mul(frame)
}

/// Memory of an instance that runs, beyond that [bytes]: forces by frame, and gradients of poses.
pub(super) fn running_bytes(request: &RollOutRequest, batch: &Batch, twin: &TwinShape) -> u64 {
    let (grasps, colliders) = parts(request);
    let returns = request.returns.clone().unwrap_or_default();
    let forces = 12 * (twin.controls.saturating_add(1)) + 24 * (grasps + colliders);
    let poses = bodies_of(request).saturating_mul(POSE);
    let frame = if returns.forces { forces } else { 0 };
    batch.frames.saturating_add(1).saturating_mul(frame.saturating_add(poses))
}

/// Number of grasps and of colliders.
fn parts(request: &RollOutRequest) -> (u64, u64) {
    let colliders = request.world.as_ref().map_or(0, |world| world.colliders.len());
    (request.grasps.len() as u64, colliders as u64)
}

fn sum(terms: &[u64]) -> u64 {
    terms.iter().fold(0, |sum, term| sum.saturating_add(*term))
}

#[cfg(test)]
mod tests;
