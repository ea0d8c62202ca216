//! Work and memory of a registration or a correction: upper bounds, before anything is unpacked.

use bendtwin_proto::v1::{CorrectOptions, Observation, RegisterStateRequest, observation::Tracks};

use crate::rollout::{TwinShape, states_size, world};

/// Frames of physics where the request does not say.
const SETTLE_FRAMES: u32 = 12;
/// A point: as received and as used, its place, its match, its distance.
const POINT: u64 = 640;
/// A node or control point of the shape: positions, rotations, the vectors of conjugate gradients, and
/// a simulated state.
const ENDPOINT: u64 = 1024;
/// The part of the twin's skin that clouds are matched with.
const SKIN: u64 = 4 << 20;
/// A spring of the deformation.
const SPRING: u64 = 64;
/// Work for each spring, over all candidates and rounds, in element substeps.
const DEFORMED: u64 = 20_000;
/// Work for each point.
const MATCHED: u64 = 2_000;
/// Steps of a deformation in which a node may meet the surroundings.
const MEETINGS: u64 = 200;
/// Bytes of the reply to a correction for each slot, beside its state.
const SLOT: u64 = 160;
/// Frames that a recording is taken to have.
const RECORDED: u64 = 150;
/// Bytes of a reply beside its state.
const REPLY: u64 = 1024;

/// Number of points of an observation, as its shape says.
fn points(observation: Option<&Observation>) -> u64 {
    let points = observation.and_then(|o| o.points.as_ref());
    points.and_then(|t| t.shape.first()).copied().unwrap_or(0)
}

/// Frames of physics that a registration asks for.
pub fn settle_frames(request: &RegisterStateRequest) -> u32 {
    request.options.as_ref().and_then(|o| o.settle_frames).unwrap_or(SETTLE_FRAMES)
}

/// Work of a registration, in element substeps: its frames of physics, and what takes as long.
pub fn registration_work(request: &RegisterStateRequest, twin: &TwinShape) -> u64 {
    let frames = u64::from(settle_frames(request)) + 1;
    let surroundings = world::work_of(request.world.as_ref());
    work(points(request.observation.as_ref()), frames, surroundings, twin)
}

/// Work of registering `points` points with `frames` frames of physics in surroundings.
fn work(points: u64, frames: u64, surroundings: u64, twin: &TwinShape) -> u64 {
    let nodes = twin.nodes.saturating_mul(1 + surroundings);
    let elements = nodes.saturating_add(twin.springs).saturating_add(twin.triplets);
    let physics = frames.saturating_mul(u64::from(twin.substeps)).saturating_mul(elements);
    let met = MEETINGS.saturating_mul(surroundings).saturating_mul(twin.nodes);
    physics
        .saturating_add(DEFORMED.saturating_mul(twin.springs))
        .saturating_add(MATCHED.saturating_mul(points))
        .saturating_add(met)
}

/// Work of registering slots, if their correction may require that: twice, near the state and
/// anywhere; in element substeps.
pub fn correction_work(
    observation: Option<&Observation>,
    options: &CorrectOptions,
    slots: u64,
    twin: &TwinShape,
) -> u64 {
    if !options.register_if_lost {
        return 0;
    }
    let surroundings = world::work_of(options.world.as_ref());
    let frames = u64::from(SETTLE_FRAMES) + 1;
    let each = work(points(observation), frames, surroundings, twin);
    each.saturating_mul(2).saturating_mul(slots)
}

/// Largest size of the reply to a correction, given the session's numbers of slots and grasps
/// [bytes].
pub fn correction_reply_bytes(
    options: &CorrectOptions,
    slots: u64,
    grasps: u64,
    twin: &TwinShape,
) -> u64 {
    let state =
        if options.omit_state { 0 } else { states_size(1, grasps, twin).saturating_add(64) };
    state.saturating_add(SLOT).saturating_mul(slots).saturating_add(REPLY)
}

/// Work of an evaluation of a twin on a recording, which may be registered first, in element
/// substeps; the recording's length is not known.
pub fn evaluation_work(twin: &TwinShape) -> u64 {
    let elements = twin.nodes.saturating_add(twin.springs).saturating_add(twin.triplets);
    let physics = RECORDED.saturating_mul(u64::from(twin.substeps)).saturating_mul(elements);
    physics.saturating_add(DEFORMED.saturating_mul(twin.springs))
}

/// Memory of a registration or a correction at a worker, beside the request [bytes].
pub fn memory_bytes(observation: Option<&Observation>, twin: &TwinShape) -> u64 {
    let endpoints = twin.nodes.saturating_add(twin.controls);
    let given = match observation.and_then(|o| o.tracks.as_ref()) {
        Some(Tracks::Places(places)) => places.node_positions.is_some(),
        _ => false,
    };
    let nodes = if given { 2 } else { 1 };
    POINT
        .saturating_mul(points(observation))
        .saturating_add(ENDPOINT.saturating_mul(endpoints).saturating_mul(nodes))
        .saturating_add(SPRING.saturating_mul(twin.springs))
        .saturating_add(SKIN)
}

/// Largest size of the reply to a registration [bytes].
pub fn reply_bytes(twin: &TwinShape) -> u64 {
    let rods = twin.rods.unwrap_or(twin.nodes);
    let state = 24u64.saturating_mul(twin.nodes).saturating_add(12 * twin.controls);
    state.saturating_add(4u64.saturating_mul(rods)).saturating_add(REPLY)
}
