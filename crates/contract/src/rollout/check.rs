//! The check of a rollout request, at two levels: [`check`] looks at the request alone,
//! [`check_for`] also at the twin that it names. Sizes come before values, so that nothing is
//! counted out before it is known to be within the limits; nothing is allocated but shapes.

use bendtwin_proto::v1::{Fidelity, OpenSessionRequest, RollOutRequest};
use prost::Message as _;

use super::{
    Error, Limits, TwinShape,
    price::price,
    request::{
        actions, costs, grasps, initial, partial, plausibility, returns, times, vary, world,
    },
};

/// Size of the batch of a checked request.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Batch {
    /// Number of instances B.
    pub instances: u64,
    /// Number of knots of the actions K.
    pub knots: u64,
    /// Horizon F [frames].
    pub frames: u64,
}

/// Numbers of parts in the surroundings of a session, which a rollout in it has that names none itself.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SessionParts {
    /// Colliders of its world.
    pub colliders: u32,
    /// Number of grasps.
    pub grasps: u32,
}

impl SessionParts {
    /// Numbers of colliders and of grasps of a rollout in the session.
    fn of(self, request: &RollOutRequest) -> [usize; 2] {
        let world = request.world.as_ref();
        let colliders = world.map_or(self.colliders as usize, |world| world.colliders.len());
        let grasps = match request.grasps.len() {
            0 => self.grasps as usize,
            own => own,
        };
        [colliders, grasps]
    }
}

/// Facts of the actions that the surroundings of a rollout are checked against.
#[derive(Clone, Copy)]
pub(super) struct Moves {
    pub(super) instances: u64,
    /// `None` if the actions come later.
    pub(super) knots: Option<u64>,
    pub(super) grippers: Grippers,
}

/// The grippers of actions.
#[derive(Clone, Copy)]
pub(super) enum Grippers {
    /// Actions that move control points themselves.
    None,
    Count(u64),
    /// The actions come later.
    Later,
}

/// Checks what can be checked without the twin.
///
/// # Errors
/// The first fault that is found.
pub fn check(request: &RollOutRequest, limits: &Limits) -> Result<Batch, Error> {
    check_alone(request, SessionParts::default(), limits)
}

fn check_alone(
    request: &RollOutRequest,
    session: SessionParts,
    limits: &Limits,
) -> Result<Batch, Error> {
    within(
        "the size of the request in bytes",
        request.encoded_len() as u128,
        limits.request_bytes,
        "split the batch, or send fewer knots",
    )?;
    let [instances, knots] = actions::check(request.actions.as_ref(), limits)?;
    times::check(request, knots)?;
    let frames = match request.frames {
        0 => knots - 1,
        n => u64::from(n),
    };
    if !(1..=limits.frames).contains(&frames) {
        let fault = format!("is {frames}: it must lie in 1..={}", limits.frames);
        return Err(Error::field("frames", fault));
    }
    let batch = Batch { instances, knots, frames };
    fidelity(request.fidelity)?;
    costs::check(request, session.of(request), &batch, limits)?;
    returns::check(request)?;
    partial::check(request)?;
    initial::check(request.initial.as_ref(), instances)?;
    let grippers = world::grippers(request.actions.as_ref());
    let moves = Moves { instances, knots: Some(knots), grippers };
    world::check(request.world.as_ref(), &request.grasps, &moves, limits)?;
    grasps::check(&request.grasps, &moves)?;
    vary::check(request, &batch, limits)?;
    plausibility::check(request)?;
    Ok(batch)
}

/// Checks everything that can be checked before a simulation. The reply comes with `part_instances`
/// instances to a message, 0 meaning all in one.
///
/// # Errors
/// The first fault that is found; those of [`check`] come first.
pub fn check_for(
    request: &RollOutRequest,
    twin: &TwinShape,
    limits: &Limits,
    part_instances: u32,
) -> Result<Batch, Error> {
    check_in(request, SessionParts::default(), twin, limits, part_instances)
}

/// [`check_for`] of a rollout that may be in a session, which has the surroundings that the request
/// does not name.
///
/// # Errors
/// As [`check_for`].
pub fn check_in(
    request: &RollOutRequest,
    session: SessionParts,
    twin: &TwinShape,
    limits: &Limits,
    part_instances: u32,
) -> Result<Batch, Error> {
    let batch = check_alone(request, session, limits)?;
    partial::check_for(request, part_instances)?;
    actions::check_for(request.actions.as_ref(), twin)?;
    costs::check_for(&request.costs, twin)?;
    returns::check_for(request.returns.as_ref(), twin)?;
    let grasps = &request.grasps;
    initial::check_for(request.initial.as_ref(), batch.instances, twin, grasps.len())?;
    grasps::check_for(grasps, twin)?;
    has_variant(request.fidelity(), &request.twin, twin)?;
    sizes(request, &batch, twin, limits, part_instances)?;
    Ok(batch)
}

/// Checks the work of a checked request, the size of its reply and its memory, for a batch that may be
/// larger than the request's own.
pub(crate) fn sizes(
    request: &RollOutRequest,
    batch: &Batch,
    twin: &TwinShape,
    limits: &Limits,
    part_instances: u32,
) -> Result<(), Error> {
    let (work, reply_bytes, memory) = price(request, batch, twin, part_instances);
    within(
        "the work (instances x frames x substeps x (nodes + springs + triplets))",
        work,
        limits.work,
        "send fewer instances or a shorter horizon, or use a coarser twin",
    )?;
    within(
        "the size of the reply in bytes",
        reply_bytes.into(),
        limits.reply_bytes,
        "ask for fewer points (returns.nodes or returns.skin_points), every k-th frame (returns.every_frames) or the best few (returns.best), or stream it",
    )?;
    let least = memory.least();
    if least > limits.memory_bytes {
        return Err(too_much_memory(least, limits.memory_bytes));
    }
    Ok(())
}

/// Checks what the slots of a session begin with, as far as that is known before their actions.
pub(super) fn check_open(
    request: &OpenSessionRequest,
    slots: u64,
    twin: &TwinShape,
    limits: &Limits,
) -> Result<(), Error> {
    fidelity(request.fidelity)?;
    initial::check(request.initial.as_ref(), slots)?;
    let moves = Moves { instances: slots, knots: None, grippers: Grippers::Later };
    world::check(request.world.as_ref(), &request.grasps, &moves, limits)?;
    grasps::check(&request.grasps, &moves)?;
    initial::check_for(request.initial.as_ref(), slots, twin, request.grasps.len())?;
    grasps::check_for(&request.grasps, twin)?;
    has_variant(request.fidelity(), &request.twin, twin)
}

fn has_variant(fidelity: Fidelity, name: &str, twin: &TwinShape) -> Result<(), Error> {
    if fidelity == Fidelity::Fast && twin.fast_substeps.is_none() {
        return Err(Error::NoFastVariant { twin: name.to_owned() });
    }
    if fidelity == Fidelity::Planner && twin.planner.is_none() {
        return Err(Error::NoPlannersTwin { twin: name.to_owned() });
    }
    Ok(())
}

/// The refusal of a rollout that takes too much memory.
pub fn too_much_memory(asked: u64, limit: u64) -> Error {
    Error::TooLarge {
        what: "the memory at a worker in bytes",
        asked,
        limit,
        advice: "ask for a shorter horizon, fewer targets or smaller arrays of the reply, stream it, or use a twin with fewer control points",
    }
}

/// Fidelity that a request asks for.
///
/// # Errors
/// If this build does not know the value.
pub fn fidelity(wire: i32) -> Result<bendtwin_core::Fidelity, Error> {
    match Fidelity::try_from(wire) {
        Ok(Fidelity::Unspecified | Fidelity::Exact) => Ok(bendtwin_core::Fidelity::Exact),
        Ok(Fidelity::Fast) => Ok(bendtwin_core::Fidelity::Fast),
        Ok(Fidelity::Planner) => Ok(bendtwin_core::Fidelity::Planner),
        Err(_) => {
            let fault = format!("has the unknown value {wire}: use EXACT, FAST or PLANNER");
            Err(Error::field("fidelity", fault))
        }
    }
}

/// Refuses a quantity beyond its limit.
pub(crate) fn within(
    what: &'static str,
    asked: u128,
    limit: u64,
    advice: &'static str,
) -> Result<(), Error> {
    if asked > u128::from(limit) {
        let asked = u64::try_from(asked).unwrap_or(u64::MAX);
        return Err(Error::TooLarge { what, asked, limit, advice });
    }
    Ok(())
}
