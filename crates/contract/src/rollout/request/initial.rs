//! Initial states: at rest, in a frame of a capture, or given.

use bendtwin_core::ids::CaptureId;
use bendtwin_proto::v1::{
    Grasping, InitialState,
    initial_state::{GivenState, State},
    tensor::Dtype,
};

use super::{
    Asked, Error, Price, TwinShape, grasps, mul, sum,
    tensors::{finite, given, indices, required},
};
use crate::rollout::price::INSTANCE;

const CAPTURE: &str = "initial.capture_frame.capture";
const POSITIONS: &str = "initial.given.positions";
const VELOCITIES: &str = "initial.given.velocities";
const TWISTS: &str = "initial.given.twists";
const CONTROLS: &str = "initial.given.controls";
const COMMANDED: &str = "initial.given.commanded_controls";
const PHASES: &str = "initial.given.grasping.phases";
const HOLDERS: &str = "initial.given.grasping.holders";
const PLACES: &str = "initial.given.grasping.places";
/// Phases of a grasp: open, closed, slipped.
const PHASE_COUNT: u32 = 3;
/// A control point [bytes].
const CONTROL: u64 = 12;

pub(in crate::rollout) fn check(
    initial: Option<&InitialState>,
    instances: u64,
) -> Result<(), Error> {
    match initial.and_then(|i| i.state.as_ref()) {
        None | Some(State::Rest(_) | State::Settled(_)) => Ok(()),
        Some(State::Session(at)) => {
            let slots = at.slots.len() as u64;
            if slots <= 1 || slots == instances {
                return Ok(());
            }
            let fault =
                format!("has {slots} slots for {instances} instances: give none, one, or one each");
            Err(Error::field("initial.session.slots", fault))
        }
        Some(State::CaptureFrame(at)) if at.capture.is_empty() => Ok(()),
        Some(State::CaptureFrame(at)) => {
            let name = at.capture.parse::<CaptureId>();
            name.map(drop).map_err(|e| Error::field(CAPTURE, format!("is no name: {e}")))
        }
        Some(State::Given(state)) => check_given(state, instances),
    }
}

fn check_given(state: &GivenState, instances: u64) -> Result<(), Error> {
    let (tensor, shape) = required(state.positions.as_ref(), POSITIONS, Dtype::Float32)?;
    let is_batched = match shape[..] {
        [_, 3] => false,
        [rows, _, 3] if rows == instances => true,
        _ => {
            let fault = format!("has shape {shape:?}, not [N, 3] or [{instances}, N, 3]");
            return Err(Error::field(POSITIONS, fault));
        }
    };
    finite(tensor, POSITIONS)?;
    if let Some(velocities) = given(state.velocities.as_ref()) {
        let (velocities, other) = required(Some(velocities), VELOCITIES, Dtype::Float32)?;
        if other != shape {
            let fault = format!("has shape {other:?}, not that of the positions, {shape:?}");
            return Err(Error::field(VELOCITIES, fault));
        }
        finite(velocities, VELOCITIES)?;
    }
    if let Some(twists) = given(state.twists.as_ref()) {
        let (twists, other) = required(Some(twists), TWISTS, Dtype::Float32)?;
        let fits = match other[..] {
            [_] => !is_batched,
            [rows, _] => is_batched && rows == instances,
            _ => false,
        };
        if !fits {
            let fault = format!("has shape {other:?} beside positions of shape {shape:?}");
            return Err(Error::field(TWISTS, fault));
        }
        finite(twists, TWISTS)?;
    }
    let lead: &[u64] = if is_batched { &[instances] } else { &[] };
    if let Some(controls) = given(state.controls.as_ref()) {
        let (controls, other) = required(Some(controls), CONTROLS, Dtype::Float32)?;
        row_width(&other, lead, Some(3), CONTROLS)?;
        finite(controls, CONTROLS)?;
    }
    if let Some(commanded) = given(state.commanded_controls.as_ref()) {
        let (commanded, other) = required(Some(commanded), COMMANDED, Dtype::Float32)?;
        let controls = given(state.controls.as_ref());
        if controls.is_none_or(|controls| controls.shape != commanded.shape) {
            let fault = format!("has shape {other:?}, not that of `initial.given.controls`");
            return Err(Error::field(COMMANDED, fault));
        }
        finite(commanded, COMMANDED)?;
    }
    state.grasping.as_ref().map_or(Ok(()), |grasping| check_grasping(grasping, lead, &shape))
}

/// What grasps hold, beside positions of shape `positions`.
fn check_grasping(wire: &Grasping, lead: &[u64], positions: &[u64]) -> Result<(), Error> {
    let (phases, shape) = required(wire.phases.as_ref(), PHASES, Dtype::Uint32)?;
    let grasps = row_width(&shape, lead, None, PHASES)?;
    if let Some(phase) = indices(phases).find(|phase| *phase >= PHASE_COUNT) {
        let fault = format!("has {phase}: 0 is open, 1 closed, 2 slipped");
        return Err(Error::field(PHASES, fault));
    }
    let (holders, shape) = required(wire.holders.as_ref(), HOLDERS, Dtype::Uint32)?;
    let nodes = &positions[..positions.len() - 1];
    if shape != nodes {
        return Err(Error::field(HOLDERS, format!("has shape {shape:?}, not {nodes:?}")));
    }
    if let Some(holder) = indices(holders).find(|holder| u64::from(*holder) > grasps) {
        let fault = format!("has {holder}: there are {grasps} grasps, and 0 stands for none");
        return Err(Error::field(HOLDERS, fault));
    }
    let (places, shape) = required(wire.places.as_ref(), PLACES, Dtype::Float32)?;
    if shape != positions {
        return Err(Error::field(PLACES, format!("has shape {shape:?}, not {positions:?}")));
    }
    finite(places, PLACES)
}

/// Checks a shape [n] or, with `inner`, [n, inner], after the dimensions `lead`. Returns n.
fn row_width(shape: &[u64], lead: &[u64], inner: Option<u64>, field: &str) -> Result<u64, Error> {
    let after = shape.strip_prefix(lead);
    match (after, inner) {
        (Some([n]), None) => Ok(*n),
        (Some([n, last]), Some(inner)) if *last == inner => Ok(*n),
        _ => {
            let mut names: Vec<String> = lead.iter().map(u64::to_string).collect();
            names.push("n".to_owned());
            names.extend(inner.map(|inner| inner.to_string()));
            let fault = format!("has shape {shape:?}, not [{}] as the positions", names.join(", "));
            Err(Error::field(field, fault))
        }
    }
}

pub(in crate::rollout) fn check_for(
    initial: Option<&InitialState>,
    instances: u64,
    twin: &TwinShape,
    grasps: usize,
) -> Result<(), Error> {
    match initial.and_then(|i| i.state.as_ref()) {
        Some(State::CaptureFrame(at)) if at.capture.is_empty() && !twin.has_capture => {
            let fault = "is missing, and the twin was imported without its own capture: name one";
            Err(Error::field(CAPTURE, fault))
        }
        Some(State::Given(state)) => {
            let (b, n) = (instances, twin.nodes);
            let shape = state.positions.as_ref().map(|t| t.shape.as_slice()).unwrap_or_default();
            if shape.iter().rev().nth(1) != Some(&n) {
                let fault = format!(
                    "has shape {shape:?}: the twin has {n} nodes and the batch {b} instances, so [{n}, 3] or [{b}, {n}, 3] is needed"
                );
                return Err(Error::field(POSITIONS, fault));
            }
            if let Some(rods) = twin.rods
                && let Some(twists) = given(state.twists.as_ref())
                && twists.shape.last() != Some(&rods)
            {
                let fault = format!("has shape {:?}: the twin has {rods} rods", twists.shape);
                return Err(Error::field(TWISTS, fault));
            }
            let (c, g) = (twin.controls, grasps as u64);
            if let Some(controls) = given(state.controls.as_ref())
                && controls.shape.iter().rev().nth(1) != Some(&c)
            {
                let shape = &controls.shape;
                let fault = format!("has shape {shape:?}: the twin has {c} control points");
                return Err(Error::field(CONTROLS, fault));
            }
            if let Some(phases) = state.grasping.as_ref().and_then(|s| given(s.phases.as_ref()))
                && phases.shape.last() != Some(&g)
            {
                let shape = &phases.shape;
                let fault = format!("has shape {shape:?}: the request has {g} grasps");
                return Err(Error::field(PHASES, fault));
            }
            Ok(())
        }
        _ => Ok(()),
    }
}

/// The states that instances begin in.
pub(in crate::rollout) fn price(asked: &Asked<'_>) -> Price {
    let states = match asked.request.initial.as_ref().and_then(|initial| initial.state.as_ref()) {
        Some(State::Given(_)) => asked.batch.instances,
        _ => 1,
    };
    Price { fixed: mul(&[state_bytes(asked), states]), ..Price::default() }
}

/// Memory of a state with its control points [bytes].
pub(super) fn state_bytes(asked: &Asked<'_>) -> u64 {
    let twin = asked.twin;
    sum(&[
        mul(&[24, twin.nodes]),
        mul(&[4, twin.rods.unwrap_or(0)]),
        mul(&[CONTROL, twin.controls]),
        grasps::hold_bytes(asked),
        INSTANCE,
    ])
}
