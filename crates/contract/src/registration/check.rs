//! The check of a registration and of a correction. Sizes come before values, so that nothing is
//! counted out before it is known to be within the limits; nothing is allocated but shapes. Most
//! numbers of options and weights are left to `bendtwin-register`, which knows what they mean.

use bendtwin_proto::v1::{
    CorrectOptions, CorrectSessionRequest, Observation, OpenSessionRequest, RegisterStateRequest,
    Tensor, initial_state::State, observation::Tracks, tensor::Dtype,
};

use super::{
    Error, correction_reply_bytes, correction_work, memory_bytes, registration_work, reply_bytes,
    settle_frames,
};
use crate::rollout::{self, Limits, TwinShape, tensors, world};

/// Most points of an observation.
pub const MAX_POINTS: u64 = 200_000;
/// Most cameras of an observation.
pub const MAX_CAMERAS: u64 = 16;
/// Most frames of physics of a registration.
pub const MAX_SETTLE_FRAMES: u32 = 1000;
/// Coordinates beyond this are no positions of an object [m].
const FARTHEST_M: f32 = 1e3;

/// Checks a registration to a twin.
///
/// # Errors
/// The first fault that is found.
pub fn check_registration(
    request: &RegisterStateRequest,
    twin: &TwinShape,
    limits: &Limits,
) -> Result<(), Error> {
    observation(request.observation.as_ref(), twin, limits)?;
    if let Some(controls) = tensors::given(request.controls.as_ref()) {
        places(controls, "controls", Some(twin.controls))?;
    }
    start(request, twin, limits)?;
    let frames = settle_frames(request);
    if frames > MAX_SETTLE_FRAMES {
        let fault = format!("is {frames}: give at most {MAX_SETTLE_FRAMES}");
        return Err(Error::field("options.settle_frames", fault));
    }
    let (work, advice) =
        (registration_work(request, twin), "settle fewer frames, or use a coarser twin");
    within("the work of the registration in element substeps", work, limits.work, advice)?;
    let bytes = reply_bytes(twin);
    within("the size of the reply in bytes", bytes, limits.reply_bytes, "use a coarser twin")
}

/// Checks a correction of slots of a twin's session, given the numbers of slots and grasps.
///
/// # Errors
/// The first fault that is found.
pub fn check_correction(
    request: &CorrectSessionRequest,
    slots: u64,
    grasps: u64,
    twin: &TwinShape,
    limits: &Limits,
) -> Result<(), Error> {
    observation(request.observation.as_ref(), twin, limits)?;
    let default = CorrectOptions::default();
    let options = request.options.as_ref().unwrap_or(&default);
    let carry = carry(options);
    if !(0.0..=1.0).contains(&carry) {
        let fault = format!("is {carry}: it is a share, and must lie in 0..=1");
        return Err(Error::field("options.carry", fault));
    }
    let grippers = options.grippers.as_ref();
    world::check_now(options.world.as_ref(), grippers, "options.grippers", limits)?;
    let work = correction_work(request.observation.as_ref(), options, slots, twin);
    let advice = "correct fewer slots at once, or without `register_if_lost`";
    within("the work of the correction in element substeps", work, limits.work, advice)?;
    let bytes = correction_reply_bytes(options, slots, grasps, twin);
    let advice = "correct fewer slots at once, or with `omit_state`";
    within("the size of the reply in bytes", bytes, limits.reply_bytes, advice)
}

/// Share of a correction that rest shapes take over.
pub fn carry(options: &CorrectOptions) -> f64 {
    options.carry.unwrap_or(1.0)
}

/// Checks the shape to start from, and what surrounds it: what a session with one slot begins in.
fn start(request: &RegisterStateRequest, twin: &TwinShape, limits: &Limits) -> Result<(), Error> {
    if matches!(request.initial.as_ref().and_then(|i| i.state.as_ref()), Some(State::Session(_))) {
        let fault = "starts no registration: correct it, or give its state";
        return Err(rollout::Error::field("initial.session", fault).into());
    }
    world::check_now(request.world.as_ref(), request.grippers.as_ref(), "grippers", limits)?;
    Ok(rollout::check_session(&begun(request), twin, limits)?)
}

/// The session with one slot that begins where a registration starts.
pub fn begun(request: &RegisterStateRequest) -> OpenSessionRequest {
    OpenSessionRequest {
        twin: request.twin.clone(),
        initial: request.initial.clone(),
        slots: 1,
        world: request.world.clone(),
        ..OpenSessionRequest::default()
    }
}

fn observation(wire: Option<&Observation>, twin: &TwinShape, limits: &Limits) -> Result<(), Error> {
    let wire = wire.ok_or_else(|| Error::field("observation", "is missing"))?;
    let points = required(wire.points.as_ref(), "observation.points")?;
    let count = rows(points, "observation.points", None)?;
    if !(1..=MAX_POINTS).contains(&count) {
        let fault = format!("has {count} points: give 1 to {MAX_POINTS}, thinned out evenly");
        return Err(Error::field("observation.points", fault));
    }
    let (what, memory) = ("the memory at a worker in bytes", memory_bytes(Some(wire), twin));
    within(what, memory, limits.memory_bytes, "thin out the points, or use a coarser twin")?;
    positions(points, "observation.points")?;
    tracks(wire.tracks.as_ref(), count, twin)?;
    if let Some(weights) = tensors::given(wire.weights.as_ref()) {
        self::weights(weights, count)?;
    }
    if let Some(velocities) = tensors::given(wire.velocities.as_ref()) {
        places(velocities, "observation.velocities", Some(count))?;
    }
    if let Some(cameras) = tensors::given(wire.cameras.as_ref()) {
        const CAMERAS: &str = "observation.cameras";
        let count = rows(cameras, CAMERAS, None)?;
        if count > MAX_CAMERAS {
            let fault = format!("has {count} cameras: at most {MAX_CAMERAS} are possible");
            return Err(Error::field(CAMERAS, fault));
        }
        positions(cameras, CAMERAS)?;
    }
    Ok(())
}

fn tracks(tracks: Option<&Tracks>, count: u64, twin: &TwinShape) -> Result<(), Error> {
    const NODES: &str = "observation.nodes";
    match tracks {
        None => Ok(()),
        Some(Tracks::Nodes(nodes)) => {
            let observed = Error::Observation;
            let tensor = tensors::index_list(Some(nodes), NODES).map_err(observed)?;
            if tensor.shape != [count] {
                let fault = format!("has shape {:?} beside {count} points", tensor.shape);
                return Err(Error::field(NODES, fault));
            }
            tensors::known_nodes(tensor, NODES, twin.nodes).map_err(observed)
        }
        Some(Tracks::Places(wire)) => {
            const POINTS: &str = "observation.places.points";
            places(required(wire.points.as_ref(), POINTS)?, POINTS, Some(count))?;
            match tensors::given(wire.node_positions.as_ref()) {
                None => Ok(()),
                Some(nodes) => places(nodes, "observation.places.node_positions", Some(twin.nodes)),
            }
        }
    }
}

fn weights(tensor: &Tensor, count: u64) -> Result<(), Error> {
    const WEIGHTS: &str = "observation.weights";
    let (_, shape) =
        tensors::required(Some(tensor), WEIGHTS, Dtype::Float32).map_err(Error::Observation)?;
    if shape != [count] {
        let fault = format!("has shape {shape:?} beside {count} points");
        return Err(Error::field(WEIGHTS, fault));
    }
    Ok(())
}

fn required<'t>(tensor: Option<&'t Tensor>, field: &str) -> Result<&'t Tensor, Error> {
    tensors::given(tensor).ok_or_else(|| Error::field(field, "is missing"))
}

/// Checks a list of positions, of that length if one is given.
fn places(tensor: &Tensor, field: &str, count: Option<u64>) -> Result<(), Error> {
    rows(tensor, field, count)?;
    positions(tensor, field)
}

/// Number of rows of a FLOAT32 tensor [M, 3].
fn rows(tensor: &Tensor, field: &str, count: Option<u64>) -> Result<u64, Error> {
    let (_, shape) =
        tensors::required(Some(tensor), field, Dtype::Float32).map_err(Error::Observation)?;
    match (&shape[..], count) {
        ([rows, 3], None) => Ok(*rows),
        ([rows, 3], Some(count)) if *rows == count => Ok(count),
        (_, count) => {
            let rows = count.map_or("M".to_owned(), |count| count.to_string());
            Err(Error::field(field, format!("has shape {shape:?}, not [{rows}, 3]")))
        }
    }
}

/// Refuses what is no position of an object.
fn positions(tensor: &Tensor, field: &str) -> Result<(), Error> {
    let is_far = |x: &f32| !x.is_finite() || x.abs() > FARTHEST_M;
    match tensors::floats(tensor).enumerate().find(|(_, x)| is_far(x)) {
        None => Ok(()),
        Some((i, x)) => {
            let row = i / 3;
            let fault = format!(
                "row {row} has {x}: leave out what was not seen, and give at most {FARTHEST_M} in SI units"
            );
            Err(Error::field(field, fault))
        }
    }
}

fn within(what: &'static str, asked: u64, limit: u64, advice: &'static str) -> Result<(), Error> {
    if asked > limit {
        return Err(rollout::Error::TooLarge { what, asked, limit, advice }.into());
    }
    Ok(())
}
