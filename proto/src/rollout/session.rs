//! The check of what a session begins with: that of a rollout that begins there.

use super::{Error, Limits, TwinShape, check_for};
use crate::v1::{
    ControlTrajectories, GripperPoses, OpenSessionRequest, RollOutRequest, Tensor,
    initial_state::State, roll_out_request::Actions,
};

/// Most slots of a session.
pub const MOST_SLOTS: u32 = 4096;

/// Number of slots that a request asks for.
///
/// # Errors
/// If it is too large.
pub fn slots(request: &OpenSessionRequest) -> Result<u32, Error> {
    match request.slots {
        0 => Ok(1),
        n if n <= MOST_SLOTS => Ok(n),
        n => Err(Error::TooLarge {
            what: "the number of slots",
            asked: u64::from(n),
            limit: u64::from(MOST_SLOTS),
            advice: "open several sessions",
        }),
    }
}

/// Checks initial state, surroundings and fidelity of a session.
///
/// # Errors
/// The first fault that is found.
pub fn check_session(
    request: &OpenSessionRequest,
    twin: &TwinShape,
    limits: &Limits,
) -> Result<(), Error> {
    let slots = slots(request)? as usize;
    let state = request.initial.as_ref().and_then(|i| i.state.as_ref());
    if matches!(state, Some(State::Session(_))) {
        let fault = "is another session: fork that, or give its state";
        return Err(Error::field("initial.session", fault));
    }
    let is_each = matches!(state, Some(State::Given(given))
        if given.positions.as_ref().is_some_and(|t| t.shape.len() == 3));
    // One instance stands for all where they begin alike.
    let slots = if is_each { slots } else { 1 };
    let limits = Limits { work: u64::MAX, ..*limits };
    check_for(&first_rollout(request, twin, slots), twin, &limits, 1).map(drop)
}

/// A rollout of one frame in which nothing is moved.
fn first_rollout(request: &OpenSessionRequest, twin: &TwinShape, slots: usize) -> RollOutRequest {
    let grippers = request.grasps.iter().map(|g| u64::from(g.gripper) + 1);
    let carriers =
        request.world.iter().flat_map(|w| &w.colliders).filter_map(|c| match c.carrier {
            Some(crate::v1::collider::Carrier::Gripper(g)) => Some(u64::from(g) + 1),
            _ => None,
        });
    let grippers = grippers.chain(carriers).max().unwrap_or(0).min(u64::from(MOST_SLOTS)) as usize;
    let actions = if grippers == 0 {
        let count = 2 * slots * twin.controls as usize;
        let shape = [slots, 2, twin.controls as usize];
        Actions::Trajectories(ControlTrajectories {
            positions: Some(Tensor::pack_points(&shape, &vec![[0.0; 3]; count])),
            interpolation: 0,
        })
    } else {
        // No gripper is anywhere; their rotations must be some.
        let pose = [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0f32];
        let poses = pose.repeat(2 * slots * grippers);
        Actions::Poses(GripperPoses {
            poses: Some(Tensor::pack(&[slots, 2, grippers, 7], &poses)),
            ..GripperPoses::default()
        })
    };
    RollOutRequest {
        twin: request.twin.clone(),
        actions: Some(actions),
        initial: request.initial.clone(),
        frames: 1,
        fidelity: request.fidelity,
        world: request.world.clone(),
        grasps: request.grasps.clone(),
        ..RollOutRequest::default()
    }
}
