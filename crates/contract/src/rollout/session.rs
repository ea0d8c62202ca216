//! The check of what a session begins with, and the size of its states.

use bendtwin_proto::v1::{OpenSessionRequest, RollOutRequest, initial_state::State};

use super::{
    Error, Limits, TwinShape, check::check_open, message::Message,
    request::vary::has_mean_prediction,
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

/// Checks initial state, surroundings and fidelity of a session. Each rollout checks the rest,
/// which hangs on its actions, such as their number of knots.
///
/// # Errors
/// The first fault that is found.
pub fn check_session(
    request: &OpenSessionRequest,
    twin: &TwinShape,
    limits: &Limits,
) -> Result<(), Error> {
    let slots = slots(request)?;
    let state = request.initial.as_ref().and_then(|i| i.state.as_ref());
    if matches!(state, Some(State::Session(_))) {
        let fault = "is another session: fork that, or give its state";
        return Err(Error::field("initial.session", fault));
    }
    check_open(request, u64::from(slots), twin, limits)
}

/// Refuses what belongs to rollouts alone in one that advances slots, which have one state each.
///
/// # Errors
/// The first field that is set.
pub fn check_advance(request: &RollOutRequest) -> Result<(), Error> {
    if request.ensemble.is_some() && !has_mean_prediction(request) {
        let fault = "belongs to rollouts: a slot has one state. Of several members take that of their mean, with MEAN_PREDICTION";
        return Err(Error::field("rollout.ensemble", fault));
    }
    let returns = request.returns.clone().unwrap_or_default();
    let of_rollouts = [
        ("rollout.returns.best", returns.best > 0),
        ("rollout.returns.part_frames", returns.part_frames > 0),
        ("rollout.time_limit_s", request.time_limit_s.is_some()),
    ];
    if let Some((field, _)) = of_rollouts.into_iter().find(|(_, is_set)| *is_set) {
        let fault = "belongs to rollouts: every slot is advanced";
        return Err(Error::field(field, fault));
    }
    Ok(())
}

/// Largest size of the reply with the states of slots, given the numbers of slots and grasps
/// [bytes].
///
/// # Errors
/// If it is larger than a reply may be.
pub fn states_bytes(
    slots: u64,
    grasps: u64,
    twin: &TwinShape,
    limits: &Limits,
) -> Result<u64, Error> {
    let bytes = states_size(slots, grasps, twin);
    if bytes > limits.reply_bytes {
        return Err(Error::TooLarge {
            what: "the size of the states in bytes",
            asked: bytes,
            limit: limits.reply_bytes,
            advice: "ask for fewer slots at once",
        });
    }
    Ok(bytes)
}

/// Largest size of the message with the states of slots, given the numbers of slots and grasps
/// [bytes].
pub(crate) fn states_size(slots: u64, grasps: u64, twin: &TwinShape) -> u64 {
    let (n, c) = (twin.nodes, twin.controls);
    let mut grasping = Message::default();
    for width in [grasps, n, n.saturating_mul(3)] {
        grasping.tensor(1, 4, &[slots, width]);
    }
    let mut given = Message::default();
    // Rods have separate nodes.
    let rods = twin.rods.unwrap_or(n);
    let (nodes, controls) = (n.saturating_mul(3), c.saturating_mul(3));
    for width in [nodes, nodes, rods, controls, controls] {
        given.tensor(1, 4, &[slots, width]);
    }
    given.message(1, &grasping);
    let mut reply = Message::default();
    reply.message(1, &given);
    // Numbers of slots and of frames.
    reply.add(slots.saturating_mul(5 + 10).saturating_add(32));
    reply.0
}

#[cfg(test)]
mod tests;
