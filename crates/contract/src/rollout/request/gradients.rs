//! Gradients: what a run backward costs.

use bendtwin_proto::v1::{ControlTrajectories, GripperPoses, Returns, roll_out_request::Actions};

use super::{Asked, Message, Price, mul, sum};
use crate::rollout::{
    price::{ELEMENT_GRADIENT, NODE},
    request::vary::substeps,
};

/// A control point in a frame: its prepared gradient, and the gradient that the engine sums and
/// returns.
const CONTROL: u64 = 12;
const CONTROL_GRADIENT: u64 = 28;
/// State of a node and of a rod at the end of a frame, kept for the way back, and the rest of a frame.
const NODE_STATE: u64 = 32;
const ROD_STATE: u64 = 4;
const FRAME: u64 = 64;
/// A node and a control point on the tape of a substep.
const NODE_TAPED: u64 = 48;
/// Returned gradient of a spring, triplet or rod.
const ELEMENT_RETURNED: u64 = 16;
/// A tape up to this size is whole; of a larger one segments of about this size are kept.
const WHOLE_TAPE: u64 = 64 << 20;

/// True if a reply needs a run backward.
pub fn has_gradients(returns: &Returns) -> bool {
    returns.control_gradients
        || returns.action_gradients
        || returns.initial_gradients
        || returns.gradient_norms
}

/// The run backward, and its arrays in the reply.
pub(in crate::rollout) fn price(asked: &Asked<'_>) -> Price {
    if !has_gradients(&asked.returns) {
        return Price::default();
    }
    let (twin, boundaries) = (asked.twin, asked.boundaries);
    let (endpoints, elements) = (asked.endpoints(), asked.elements());
    let rods = twin.rods.unwrap_or(0);
    let substeps = substeps(asked.request, twin.substeps(asked.request.fidelity()));
    let kept = sum(&[mul(&[NODE_STATE, twin.nodes]), mul(&[ROD_STATE, rods]), FRAME]);
    Price {
        reply: reply(asked),
        prepared: sum(&[
            mul(&[CONTROL, boundaries, twin.controls]),
            mul(&[ELEMENT_RETURNED, elements]),
            // By the initial state, and norms.
            mul(&[24, twin.nodes]),
            mul(&[8, boundaries]),
        ]),
        running: sum(&[
            mul(&[CONTROL_GRADIENT, boundaries, twin.controls]),
            mul(&[kept, boundaries]),
            mul(&[ELEMENT_GRADIENT, elements]),
            mul(&[NODE, endpoints]),
            tape(endpoints, rods, substeps.most),
        ]),
        ..Price::default()
    }
}

/// Most bytes of a tape. A frame whose tape is too large is cut into segments, no shorter than the
/// root of their number; marks are kept of their starts.
fn tape(endpoints: u64, rods: u64, substeps: u32) -> u64 {
    let substep = sum(&[mul(&[NODE_TAPED, endpoints]), mul(&[ROD_STATE, rods])]);
    let root = u64::from(substeps.isqrt()) + 1;
    mul(&[substep, u64::from(substeps)]).min(WHOLE_TAPE.saturating_add(mul(&[2, root, substep])))
}

fn reply(asked: &Asked<'_>) -> Message {
    let Asked { returns, ranked, twin, batch, .. } = asked;
    let (ranked, boundaries) = (*ranked, asked.part_frames.saturating_add(1));
    let mut reply = Message::default();
    if returns.control_gradients {
        reply.tensor(1, 4, &[ranked, boundaries, twin.controls, 3]);
    }
    if returns.initial_gradients {
        reply.tensor(2, 4, &[ranked, twin.nodes, 3]);
        reply.tensor(2, 4, &[ranked, twin.nodes, 3]);
    }
    if returns.gradient_norms {
        reply.tensor(2, 8, &[ranked, boundaries]);
    }
    // Whether it exploded.
    reply.tensor(2, 4, &[ranked]);
    if returns.action_gradients {
        let each = asked.request.actions.as_ref().map_or(0, |actions| {
            let all = numbers(actions);
            all.checked_div(batch.instances.saturating_mul(batch.knots)).unwrap_or(0)
        });
        // The shape is as long as that of the actions, with R instead of B.
        reply.tensor(2, 4, &[ranked, batch.knots, each, 1]);
        reply.add(10);
    }
    reply
}

/// Numbers of the actions of all instances.
fn numbers(actions: &Actions) -> u64 {
    let (Actions::Trajectories(ControlTrajectories { positions: tensor, .. })
    | Actions::Poses(GripperPoses { poses: tensor, .. })) = actions;
    tensor.as_ref().map_or(0, |t| t.data.len() as u64 / 4)
}
