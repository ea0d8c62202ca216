//! Returns: what the reply is to hold, and what making it takes.

use bendtwin_proto::v1::{
    PointSet, Returns, RollOutRequest, returns::Encoding, roll_out_request::Actions,
};

use super::{
    Asked, Error, Message, Price, TwinShape,
    gradients::has_gradients,
    mul,
    plausibility::limits_grasp_force,
    sum,
    tensors::{given, index_list, known_nodes, known_skin_points},
    vary::members,
};
use crate::rollout::{
    points::{point_set, recorded, recorded_count},
    price::{HEAD, RECORDED_NODE},
};

const NODES: &str = "returns.nodes";
const SKIN_POINTS: &str = "returns.skin_points";
const POINT_SET: &str = "returns.point_set";
/// Messages of a streamed reply that exist together: one is made, two wait, one is sent.
const STREAMED_MESSAGES: u64 = 4;
/// A part of a reply while it is made: results, whose buffers may be twice as large, their
/// concatenation and the message.
const MAKING: u64 = 4;
/// The same with 16-bit integers: results are twice as large as what is sent of them.
const MAKING_INT16: u64 = 8;
/// A node's row in a recording that the skin is placed from [bytes].
const ROW: u64 = 8;
/// Longest encoding of `Diagnostics`: six floats and a count.
const DIAGNOSTICS: u64 = HEAD + 7 * 5 + 6;

pub(in crate::rollout) fn check(request: &RollOutRequest) -> Result<(), Error> {
    let Some(returns) = &request.returns else { return Ok(()) };
    if Encoding::try_from(returns.encoding).is_err() {
        let fault = format!("has the unknown value {}: use FLOAT32 or INT16", returns.encoding);
        return Err(Error::field("returns.encoding", fault));
    }
    point_set(returns.point_set, POINT_SET)?;
    let chosen = [
        (NODES, &returns.nodes, PointSet::Nodes),
        (SKIN_POINTS, &returns.skin_points, PointSet::Skin),
    ];
    for (field, tensor, of) in chosen {
        if let Some(tensor) = given(tensor.as_ref()) {
            index_list(Some(tensor), field)?;
            if recorded(returns) != of {
                let set = of.as_str_name();
                let fault = format!("are of another point set: set `{POINT_SET}` to {set}");
                return Err(Error::field(field, fault));
            }
        }
    }
    let gradients = [
        ("returns.control_gradients", returns.control_gradients),
        ("returns.action_gradients", returns.action_gradients),
        ("returns.initial_gradients", returns.initial_gradients),
        ("returns.gradient_norms", returns.gradient_norms),
    ];
    if let Some((field, _)) = gradients.into_iter().find(|(_, wanted)| *wanted)
        && request.costs.is_empty()
    {
        let fault = "needs at least one cost to differentiate: add one to `costs`";
        return Err(Error::field(field, fault));
    }
    if returns.velocities && returns.every_frames == 0 {
        let fault = "are recorded with positions: set `returns.every_frames`, 1 say";
        return Err(Error::field("returns.velocities", fault));
    }
    if returns.spread && returns.every_frames == 0 {
        let fault = "is of recorded points: set `returns.every_frames`, 1 say";
        return Err(Error::field("returns.spread", fault));
    }
    if returns.spread && members(request) < 2 {
        let fault = "is between the members of an ensemble: give an `ensemble` of two or more";
        return Err(Error::field("returns.spread", fault));
    }
    Ok(())
}

/// True if a reply has the spread of an ensemble, and arrays of its first member alone.
pub fn has_spread(request: &RollOutRequest) -> bool {
    request.returns.as_ref().is_some_and(|returns| returns.spread)
}

pub(in crate::rollout) fn check_for(
    returns: Option<&Returns>,
    twin: &TwinShape,
) -> Result<(), Error> {
    let Some(returns) = returns else { return Ok(()) };
    if recorded(returns) == PointSet::Skin {
        has_skin(twin, POINT_SET)?;
    }
    if let Some(nodes) = given(returns.nodes.as_ref()) {
        known_nodes(nodes, NODES, twin.nodes)?;
    }
    match given(returns.skin_points.as_ref()) {
        Some(points) => known_skin_points(points, SKIN_POINTS, twin.skin_points),
        None => Ok(()),
    }
}

/// Refuses the skin of a twin that has neither a skin nor surface nodes.
pub(super) fn has_skin(twin: &TwinShape, field: &str) -> Result<(), Error> {
    if twin.skin_points == Some(0) {
        let fault = "is SKIN, and the twin has no surface: use NODES";
        return Err(Error::field(field, fault));
    }
    Ok(())
}

/// Messages of the reply that exist together, with their sources, as a multiple of the message's
/// size.
pub(in crate::rollout) fn messages(asked: &Asked<'_>) -> u64 {
    making(asked) + if asked.part_instances == 0 { 0 } else { STREAMED_MESSAGES }
}

/// A message while it is made, as a multiple of its size.
pub(super) fn making(asked: &Asked<'_>) -> u64 {
    if asked.returns.encoding() == Encoding::Int16 { MAKING_INT16 } else { MAKING }
}

/// Recordings, arrays by frame and final states.
pub(in crate::rollout) fn price(asked: &Asked<'_>) -> Price {
    let (returns, twin) = (&asked.returns, asked.twin);
    let (grasps, colliders) = parts(asked);
    // By control point and the ground, and with torques by grasp and collider.
    let points = mul(&[12, twin.controls.saturating_add(1)]);
    let forces = sum(&[points, mul(&[24, sum(&[grasps, colliders])])]);
    let limits_force = limits_grasp_force(asked.request);
    let measured =
        if returns.forces || limits_force { mul(&[asked.boundaries, forces]) } else { 0 };
    let mut price = Price {
        reply: reply(asked),
        running: measured,
        // Until they are compared with the limit.
        recorded: if limits_force { measured } else { 0 },
        ..Price::default()
    };
    if asked.is_of_planner() || recorded(returns) == PointSet::Skin {
        // Recordings of nodes, until the skin is placed from them: the planner's has the twin's nodes, too.
        let rows = asked.part_frames.checked_div(returns.every_frames.into()).unwrap_or(0);
        let recorded = mul(&[RECORDED_NODE, asked.kinds(), twin.nodes, rows]);
        price.recorded = sum(&[price.recorded, recorded]);
        price.fixed = mul(&[ROW, twin.nodes]);
    }
    if asked.is_of_planner() {
        // The points that the request becomes.
        price.fixed = sum(&[price.fixed, mul(&[ROW, recorded_count(returns, twin)])]);
    }
    price
}

/// Number of grasps and of colliders.
fn parts(asked: &Asked<'_>) -> (u64, u64) {
    let colliders = asked.request.world.as_ref().map_or(0, |world| world.colliders.len());
    (asked.request.grasps.len() as u64, colliders as u64)
}

fn reply(asked: &Asked<'_>) -> Message {
    let Asked { request, returns, twin, .. } = asked;
    let (holders, frames, boundaries) =
        (asked.holders, asked.part_frames, asked.part_frames.saturating_add(1));
    let mut reply = Message::default();
    if returns.diagnostics {
        reply.add(mul(&[asked.covered, asked.members, DIAGNOSTICS]));
    }
    let has_arrays = returns.every_frames > 0
        || returns.final_state
        || returns.forces
        || returns.frame_costs
        || returns.controls
        || has_gradients(returns);
    if has_arrays || returns.best > 0 {
        reply.tensor(1, 4, &[holders]);
    }
    if let Some(rows) = frames.checked_div(u64::from(returns.every_frames)) {
        let points = recorded_count(returns, twin);
        let is_packed = returns.encoding() == Encoding::Int16;
        reply.tensor(1, 4, &[rows]);
        let mut points_of = |tag| {
            reply.tensor(tag, if is_packed { 2 } else { 4 }, &[holders, rows, points, 3]);
            // Scale and offset of 16-bit integers.
            reply.add(if is_packed { 10 } else { 0 });
        };
        points_of(1);
        if returns.velocities {
            points_of(2);
        }
        if returns.spread {
            reply.tensor(2, 4, &[asked.ranked, rows, points]);
        }
    }
    if returns.frame_costs {
        reply.tensor(2, 8, &[holders, boundaries, request.costs.len() as u64]);
    }
    if returns.controls {
        reply.tensor(2, 4, &[holders, boundaries, twin.controls, 3]);
    }
    if returns.forces {
        let (grasps, colliders) = parts(asked);
        let mut forces = Message::default();
        forces.tensor(1, 4, &[holders, frames, twin.controls, 3]);
        forces.tensor(1, 4, &[holders, frames, grasps, 6]);
        forces.tensor(1, 4, &[holders, frames, 3]);
        forces.tensor(1, 4, &[holders, frames, colliders, 6]);
        reply.message(2, &forces);
    }
    if returns.final_state {
        final_state(asked, &mut reply);
    }
    reply
}

fn final_state(asked: &Asked<'_>, reply: &mut Message) {
    let Asked { request, twin, holders, .. } = asked;
    let holders = *holders;
    reply.tensor(1, 4, &[holders, twin.nodes, 3]);
    reply.tensor(1, 4, &[holders, twin.nodes, 3]);
    if let Some(rods @ 1..) = twin.rods {
        reply.tensor(2, 4, &[holders, rods]);
    }
    reply.tensor(2, 4, &[holders, twin.controls, 3]);
    if matches!(request.actions, Some(Actions::Poses(_))) {
        reply.tensor(2, 4, &[holders, twin.controls, 3]);
    }
    if !request.grasps.is_empty() {
        let mut grasping = Message::default();
        grasping.tensor(1, 4, &[holders, request.grasps.len() as u64]);
        grasping.tensor(1, 4, &[holders, twin.nodes]);
        grasping.tensor(1, 4, &[holders, twin.nodes, 3]);
        reply.message(2, &grasping);
    }
}
