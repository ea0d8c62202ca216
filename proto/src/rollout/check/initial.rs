//! Initial states: at rest, in a frame of a capture, or given.

use bendtwin_core::ids::CaptureId;

use super::{
    Batch, Error, TwinShape,
    tensors::{finite, given, required},
};
use crate::v1::{
    InitialState,
    initial_state::{GivenState, State},
    tensor::Dtype,
};

const CAPTURE: &str = "initial.capture_frame.capture";
const POSITIONS: &str = "initial.given.positions";
const VELOCITIES: &str = "initial.given.velocities";
const TWISTS: &str = "initial.given.twists";

pub(super) fn check(initial: Option<&InitialState>, batch: &Batch) -> Result<(), Error> {
    match initial.and_then(|i| i.state.as_ref()) {
        None | Some(State::Rest(_) | State::Settled(_) | State::Session(_)) => Ok(()),
        Some(State::CaptureFrame(at)) if at.capture.is_empty() => Ok(()),
        Some(State::CaptureFrame(at)) => {
            let name = at.capture.parse::<CaptureId>();
            name.map(drop).map_err(|e| Error::field(CAPTURE, format!("is no name: {e}")))
        }
        Some(State::Given(state)) => check_given(state, batch),
    }
}

fn check_given(state: &GivenState, batch: &Batch) -> Result<(), Error> {
    let (tensor, shape) = required(state.positions.as_ref(), POSITIONS, Dtype::Float32)?;
    let is_batched = match shape[..] {
        [_, 3] => false,
        [instances, _, 3] if instances == batch.instances => true,
        _ => {
            let b = batch.instances;
            let fault = format!("has shape {shape:?}, not [N, 3] or [{b}, N, 3]");
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
            [instances, _] => is_batched && instances == batch.instances,
            _ => false,
        };
        if !fits {
            let fault = format!("has shape {other:?} beside positions of shape {shape:?}");
            return Err(Error::field(TWISTS, fault));
        }
        finite(twists, TWISTS)?;
    }
    Ok(())
}

pub(super) fn check_for(
    initial: Option<&InitialState>,
    batch: &Batch,
    twin: &TwinShape,
) -> Result<(), Error> {
    match initial.and_then(|i| i.state.as_ref()) {
        Some(State::CaptureFrame(at)) if at.capture.is_empty() && !twin.has_capture => {
            let fault = "is missing, and the twin was imported without its own capture: name one";
            Err(Error::field(CAPTURE, fault))
        }
        Some(State::Given(state)) => {
            let (b, n) = (batch.instances, twin.nodes);
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
            Ok(())
        }
        _ => Ok(()),
    }
}
