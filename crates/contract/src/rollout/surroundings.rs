//! Size and memory of what surrounds an object in a rollout: moving bodies, forces, parameters that
//! differ by instance, implausible instances.

use bendtwin_proto::v1::RollOutRequest;

use super::{
    check::{Batch, bodies_of, members, sets, substeps},
    implausible::ImplausibleReason,
    parts::part_frames,
    size::{Sum, length},
    twin::TwinShape,
};

/// A pose of a body, and its gradient.
const POSE: u64 = 48;
/// A parameter of an element in the engine and in the model that keeps it.
const PARAMETER: u64 = 16;
/// A set of parameters beside its arrays.
const SET: u64 = 4096;
/// Numbers of substeps that variants of a model have, at most.
const MOST_FINER: u64 = 64;
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
    sum.add(instances.saturating_mul(implausible(request, batch)));
    if request.ensemble.is_some() {
        sum.tensor(2, 8, &[covered, members]);
    }
    if request.returns.as_ref().is_some_and(|returns| returns.forces) {
        let mut forces = Sum(0);
        let (grasps, colliders) = parts(request);
        let frames = part_frames(request, batch);
        forces.tensor(1, 4, &[held, frames, twin.controls, 3]);
        forces.tensor(1, 4, &[held, frames, grasps, 6]);
        forces.tensor(1, 4, &[held, frames, 3]);
        forces.tensor(1, 4, &[held, frames, colliders, 6]);
        sum.message(2, &forces);
    }
}

/// Most bytes of what is implausible of an instance. What is found is in single precision, so a limit
/// beyond that is never exceeded.
fn implausible(request: &RollOutRequest, batch: &Batch) -> u64 {
    let limits = request.plausibility.unwrap_or_default();
    let last = batch.instances.saturating_mul(members(request)).saturating_sub(1);
    let can_be = |r: &ImplausibleReason| r.limit(&limits) != Some(f64::INFINITY);
    let each = ImplausibleReason::ALL.into_iter().filter(can_be).map(|reason| {
        let frame = if reason.names_frame() { 1 + length(batch.frames) } else { 0 };
        // Tag and length, an index, the reason, what was found and the limit.
        3 + (1 + length(last)) + (2 + reason.as_str().len() as u64) + 2 * 9 + frame
    });
    each.sum()
}

/// Memory that all instances share [bytes]: sets of parameters and what they surround.
pub(super) fn fixed_bytes(request: &RollOutRequest, batch: &Batch, twin: &TwinShape) -> u64 {
    let each = set_bytes(request, twin);
    let own_substeps = twin.substeps(request.fidelity());
    let own = if request.world.is_some() { 1 } else { 0 };
    let sets = sets(request, batch);
    // Models with more substeps, from which others are made.
    let finer = if substeps(request, own_substeps).most > own_substeps {
        sets.min(MOST_FINER.saturating_mul(members(request)))
    } else {
        0
    };
    sum(&[
        each.saturating_mul(sets.saturating_add(finer).saturating_add(own)),
        if bodies_of(request) > 0 || own > 0 { FACES } else { 0 },
        // Costs of members, kept until all are there.
        batch.instances.saturating_mul(members(request)).saturating_mul(64),
    ])
}

/// Memory of the models of a request whose instances have so many rest shapes beside the twin's own
/// [bytes]: each is varied as the request says.
pub fn models_bytes(request: &RollOutRequest, rests: u64, twin: &TwinShape) -> u64 {
    set_bytes(request, twin).saturating_mul(rests).saturating_mul(members(request))
}

/// Memory of a set of parameters.
fn set_bytes(request: &RollOutRequest, twin: &TwinShape) -> u64 {
    let elements = twin.most_elements(request.fidelity());
    sum(&[elements.saturating_mul(3 * PARAMETER), SET])
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
