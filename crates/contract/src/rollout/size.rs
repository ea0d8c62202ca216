//! Size of a reply, before it is computed.

use bendtwin_proto::v1::{
    ControlTrajectories, GripperPoses, RollOutRequest, returns::Encoding, roll_out_request::Actions,
};
use prost::length_delimiter_len as varint_len;

use super::{
    check::{Batch, has_gradients, has_mean_prediction, has_spread, members},
    parts::part_frames,
    points::recorded_count,
    surroundings,
    twin::TwinShape,
};

/// Tag and length of a nested message below 128 bytes.
const HEAD: u64 = 2;
/// Longest encoding of `Diagnostics`: six floats and a count.
const DIAGNOSTICS: u64 = HEAD + 7 * 5 + 6;
/// Longest encoding of a `Divergence`: three counts.
const DIVERGENCE: u64 = HEAD + 3 * 6;
/// Longest encoding of a `Window`: two counts.
const WINDOW: u64 = 1 + HEAD + 2 * 6;
/// Longest encoding of everything else: first_instance, timing, worker, fidelity, substeps,
/// deviation, mass_kg.
const REST: u64 = 6 + (HEAD + 2 * 9) + 48 + 2 + 7 + (1 + HEAD + 3 * 9 + 6) + 10;

/// Most bytes that one message of the reply to a checked request takes when encoded, with
/// `part_instances` instances to a message (0: all in one). Tensors are exact; of each instance it
/// is assumed that it diverges and that no number of its diagnostics is zero.
pub fn reply_bytes(
    request: &RollOutRequest,
    batch: &Batch,
    twin: &TwinShape,
    part_instances: u32,
) -> u64 {
    let covered = match part_instances {
        0 => batch.instances,
        part => u64::from(part).min(batch.instances),
    };
    let terms = request.costs.len() as u64;
    let names = request.costs.iter().enumerate().map(|(i, cost)| {
        let length = if cost.name.is_empty() { format!("cost{i}").len() } else { cost.name.len() };
        (1 + varint_len(length) + length) as u64
    });
    let mut sum = Sum(names.sum::<u64>().saturating_add(REST));
    sum.tensor(1, 8, &[covered]);
    sum.tensor(1, 8, &[covered, terms]);
    let members = members(request);
    sum.add(covered.saturating_mul(members).saturating_mul(DIVERGENCE));
    if request.time_limit_s.is_some() {
        sum.tensor(2, 4, &[covered.saturating_mul(members)]);
    }
    let Some(returns) = &request.returns else {
        surroundings::add_reply(request, batch, twin, [covered, 0], &mut sum);
        return sum.0;
    };

    if returns.diagnostics {
        sum.add(covered.saturating_mul(members).saturating_mul(DIAGNOSTICS));
    }
    let ranked = match returns.best {
        0 => covered,
        best => u64::from(best).min(batch.instances),
    };
    // Of an ensemble arrays are by member, or of the first with a spread, or of the mean; gradients are
    // by action.
    let by_action = has_spread(request) || has_mean_prediction(request);
    let holders = if by_action { ranked } else { ranked.saturating_mul(members) };
    let frames = part_frames(request, batch);
    if returns.part_frames > 0 {
        sum.add(WINDOW);
    }
    surroundings::add_reply(request, batch, twin, [covered, holders], &mut sum);
    let has_arrays = returns.every_frames > 0
        || returns.final_state
        || returns.forces
        || returns.frame_costs
        || returns.controls
        || has_gradients(returns);
    let boundaries = frames.saturating_add(1);
    if has_arrays || returns.best > 0 {
        sum.tensor(1, 4, &[holders]);
    }
    if let Some(recorded) = frames.checked_div(u64::from(returns.every_frames)) {
        let points = recorded_count(returns, twin);
        let is_packed = returns.encoding() == Encoding::Int16;
        sum.tensor(1, 4, &[recorded]);
        sum.tensor(1, if is_packed { 2 } else { 4 }, &[holders, recorded, points, 3]);
        // Scale and offset of 16-bit integers.
        sum.add(if is_packed { 10 } else { 0 });
        if returns.spread {
            sum.tensor(2, 4, &[ranked, recorded, points]);
        }
        if returns.velocities {
            sum.tensor(2, if is_packed { 2 } else { 4 }, &[holders, recorded, points, 3]);
            sum.add(if is_packed { 10 } else { 0 });
        }
    }
    if returns.frame_costs {
        sum.tensor(2, 8, &[holders, boundaries, terms]);
    }
    if returns.controls {
        sum.tensor(2, 4, &[holders, boundaries, twin.controls, 3]);
    }
    if returns.final_state {
        sum.tensor(1, 4, &[holders, twin.nodes, 3]);
        sum.tensor(1, 4, &[holders, twin.nodes, 3]);
        if let Some(rods @ 1..) = twin.rods {
            sum.tensor(2, 4, &[holders, rods]);
        }
        sum.tensor(2, 4, &[holders, twin.controls, 3]);
        if matches!(request.actions, Some(Actions::Poses(_))) {
            sum.tensor(2, 4, &[holders, twin.controls, 3]);
        }
        if !request.grasps.is_empty() {
            let mut grasping = Sum(0);
            grasping.tensor(1, 4, &[holders, request.grasps.len() as u64]);
            grasping.tensor(1, 4, &[holders, twin.nodes]);
            grasping.tensor(1, 4, &[holders, twin.nodes, 3]);
            sum.message(2, &grasping);
        }
    }
    if returns.control_gradients {
        sum.tensor(1, 4, &[ranked, boundaries, twin.controls, 3]);
    }
    if returns.initial_gradients {
        sum.tensor(2, 4, &[ranked, twin.nodes, 3]);
        sum.tensor(2, 4, &[ranked, twin.nodes, 3]);
    }
    if returns.gradient_norms {
        sum.tensor(2, 8, &[ranked, boundaries]);
    }
    if has_gradients(returns) {
        // Whether it exploded.
        sum.tensor(2, 4, &[ranked]);
    }
    if returns.action_gradients {
        let each = request.actions.as_ref().map_or(0, |actions| action_numbers(actions, batch));
        // The shape is as long as that of the actions, with R instead of B.
        sum.tensor(2, 4, &[ranked, batch.knots, each, 1]);
        sum.add(10);
    }
    sum.0
}

/// Numbers of the actions of one instance in one knot.
pub(super) fn action_numbers(actions: &Actions, batch: &Batch) -> u64 {
    let (Actions::Trajectories(ControlTrajectories { positions: tensor, .. })
    | Actions::Poses(GripperPoses { poses: tensor, .. })) = actions;
    let all = tensor.as_ref().map_or(0, |t| t.data.len() as u64 / 4);
    all.checked_div(batch.instances.saturating_mul(batch.knots)).unwrap_or(0)
}

/// Bytes of the encoding of a length.
pub(super) fn length(n: u64) -> u64 {
    varint_len(usize::try_from(n).unwrap_or(usize::MAX)) as u64
}

/// Bytes so far; what overflows stays at the largest number, which exceeds every limit.
pub(super) struct Sum(pub(super) u64);

impl Sum {
    pub(super) fn add(&mut self, bytes: u64) {
        self.0 = self.0.saturating_add(bytes);
    }

    /// A tensor field whose tag takes `tag` bytes and whose elements take `width` each.
    pub(super) fn tensor(&mut self, tag: u64, width: u64, shape: &[u64]) {
        let data = shape.iter().fold(width, |product, d| product.saturating_mul(*d));
        let dims: u64 = shape.iter().map(|d| length(*d)).sum();
        let inside = (2 + 2 + dims).saturating_add(data).saturating_add(1 + length(data));
        self.add(inside.saturating_add(tag + length(inside)));
    }

    /// A message inside this one, whose tag takes `tag` bytes.
    pub(super) fn message(&mut self, tag: u64, inside: &Self) {
        self.add(inside.0.saturating_add(tag + length(inside.0)));
    }
}

#[cfg(test)]
mod tests;
