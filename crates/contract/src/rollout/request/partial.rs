//! Replies in parts: parts in time, and the instances done within a time limit.

use bendtwin_proto::v1::{Cost, RollOutRequest, cost::Kind};

use super::{
    Asked, Error, Message, Price, gradients::has_gradients, initial::state_bytes, mul,
    returns::making, sum,
};
use crate::rollout::price::{HEAD, RECORDED_NODE};

const PART_FRAMES: &str = "returns.part_frames";
const TIME_LIMIT: &str = "time_limit_s";
/// Longest time limit [s].
const LONGEST_S: f64 = 1e5;
/// Longest encoding of a `Window`: two counts.
const WINDOW: u64 = 1 + HEAD + 2 * 6;

pub(in crate::rollout) fn check(request: &RollOutRequest) -> Result<(), Error> {
    let returns = request.returns.clone().unwrap_or_default();
    if returns.part_frames > 0 {
        part_frames(request)?;
    }
    let Some(limit) = request.time_limit_s else { return Ok(()) };
    // Also refuses what is no number.
    if !(limit > 0.0 && limit <= LONGEST_S) {
        let fault = format!("is {limit}: it must be above 0 and at most {LONGEST_S} seconds");
        return Err(Error::field(TIME_LIMIT, fault));
    }
    let with = if has_gradients(&returns) {
        "gradients, which are of whole batches"
    } else if returns.part_frames > 0 {
        "`returns.part_frames`: what has come by then is what is done, so stop reading"
    } else {
        return Ok(());
    };
    Err(Error::field(TIME_LIMIT, format!("does not go with {with}")))
}

fn part_frames(request: &RollOutRequest) -> Result<(), Error> {
    let returns = request.returns.clone().unwrap_or_default();
    let with = if has_gradients(&returns) {
        "gradients, which need the whole horizon"
    } else if returns.best > 0 {
        "`returns.best`, which is known only at the end"
    } else if returns.every_frames > 0 && !returns.part_frames.is_multiple_of(returns.every_frames)
    {
        let (part, every) = (returns.part_frames, returns.every_frames);
        let fault =
            format!("is {part}: it must be a multiple of `returns.every_frames`, which is {every}");
        return Err(Error::field(PART_FRAMES, fault));
    } else {
        return Ok(());
    };
    Err(Error::field(PART_FRAMES, format!("does not go with {with}: leave either out")))
}

/// Refuses parts in time of a reply that comes in one message.
pub(in crate::rollout) fn check_for(
    request: &RollOutRequest,
    part_instances: u32,
) -> Result<(), Error> {
    let is_divided = request.returns.as_ref().is_some_and(|returns| returns.part_frames > 0);
    if is_divided && part_instances == 0 {
        let fault = "divides a streamed reply: call StreamRollOut, or leave it out";
        return Err(Error::field(PART_FRAMES, fault));
    }
    Ok(())
}

/// Parts in time: all instances of a part wait at the end of a window, with what is added up.
pub(in crate::rollout) fn price(asked: &Asked<'_>) -> Price {
    let mut reply = Message::default();
    if asked.request.time_limit_s.is_some() {
        reply.tensor(2, 4, &[mul(&[asked.covered, asked.members])]);
    }
    if asked.returns.part_frames == 0 {
        return Price { reply, ..Price::default() };
    }
    reply.add(WINDOW);
    // A cost that looks back records every frame.
    let looks_back = |cost: &Cost| matches!(cost.kind, Some(Kind::Smoothness(_)));
    let recorded = match asked.request.costs.iter().any(looks_back) {
        true => mul(&[making(asked), RECORDED_NODE, asked.twin.nodes, asked.part_frames]),
        false => 0,
    };
    let waiting = mul(&[asked.batch.instances.min(asked.part_instances.into()), asked.members]);
    let states = mul(&[2, state_bytes(asked)]);
    Price { reply, waiting, fixed: mul(&[waiting, sum(&[states, recorded])]), ..Price::default() }
}
