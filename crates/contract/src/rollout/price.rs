//! Memory of a rollout at a worker, before anything is unpacked. It is an upper bound for the CPU;
//! on a GPU the state of a simulation is in the device's memory, and counted there.

use bendtwin_proto::v1::{
    Cost, Fidelity, PointSet, RollOutRequest,
    cost::{Kind, When},
    ensemble::Statistic,
    initial_state::State,
    returns::Encoding,
};
use prost::Message as _;

use super::{
    check::{
        Batch, has_gradients, has_mean_prediction, has_spread, members, own_targets, substeps,
        targets,
    },
    parts::part_frames,
    points::{is_at_skin, measures_nodes, recorded, recorded_count},
    size::reply_bytes,
    surroundings,
    twin::TwinShape,
};

/// Messages of a reply that are there at once when it is streamed: one is made, two wait, one is
/// sent.
const STREAMED_MESSAGES: u64 = 4;
/// A part of a reply while it is made: results, whose buffers may be twice as large, their
/// concatenation and the message.
const MAKING: u64 = 4;
/// The same with 16-bit integers: results are twice as large as what is sent of them.
const MAKING_INT16: u64 = 8;
/// The request: as it came, and its tensors unpacked once or twice.
const REQUEST: u64 = 3;
/// A target point with its node, its term's share and the copy that sorting makes.
const TARGET: u64 = 32;
/// An instance beside its arrays, in the batch, in a slice of it, and its result.
const INSTANCE: u64 = 1024;
/// A name of a cost beside its text.
const NAME: u64 = 64;
/// A cost in a frame: as it is added up, and as it is returned.
const FRAME_COST: u64 = 16;
/// A control point in a frame: dense controls in single precision, and as the engine reads them.
const CONTROL: u64 = 12;
const CONTROL_READ: u64 = 16;
/// A node that a grasp may hold.
const HOLD: u64 = 20;
/// A frame's place among the knots: four knots with their weights.
const CURVE: u64 = 96;
/// Its gradient, as the engine adds it up and as it is returned.
const CONTROL_GRADIENT: u64 = 28;
/// A node (or control point) of a simulation that runs: its state, forces, velocities before and
/// after contact, candidates.
const NODE: u64 = 256;
/// A point of the skin where a cost is measured there: its place, and its part of the search for the
/// nearest.
const SKIN_POINT: u64 = 128;
/// A node in a recording, whose buffer may be twice as large.
const RECORDED_NODE: u64 = 24;
/// A node's row in a recording that the skin is placed from.
const ROW: u64 = 8;
/// State of a node and of a rod at the end of a frame, kept for the way back.
const NODE_STATE: u64 = 32;
const ROD_STATE: u64 = 4;
/// A node and a control point on the tape of a substep.
const NODE_TAPED: u64 = 48;
/// A spring's, triplet's or rod's gradient as it is added up, and as it is returned.
const ELEMENT_GRADIENT: u64 = 64;
const ELEMENT_RETURNED: u64 = 16;
/// A node in a frame of a mean: its sums in double precision, the mean, and as it is measured, with the
/// gradient.
const MEAN_NODE: u64 = 128;
/// A node in a frame whose gradient is given to the engine: its target and number, twice.
const SEED: u64 = 32;
/// A tape up to this size is whole; of a larger one segments of about this size are kept.
const WHOLE_TAPE: u64 = 64 << 20;

/// Memory of a rollout at a worker [bytes].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Memory {
    /// The request.
    pub request: u64,
    /// The parts of it that are unpacked for all instances, and the reply.
    pub fixed: u64,
    /// An instance that is prepared.
    pub prepared: u64,
    /// An instance that runs, beyond that.
    pub running: u64,
}

impl Memory {
    /// Bytes beside the request, with so many instances prepared at once, on a device that runs so
    /// many at once.
    pub fn bytes(&self, prepared: usize, lanes: usize) -> u64 {
        let prepared = prepared as u64;
        let running = prepared.min(lanes as u64);
        self.fixed
            .saturating_add(self.prepared.saturating_mul(prepared))
            .saturating_add(self.running.saturating_mul(running))
    }

    /// The least that the rollout can do with, request included: one instance after another.
    pub fn least(&self) -> u64 {
        self.request.saturating_add(self.bytes(1, 1))
    }
}

/// A message of the reply, with the arrays of the members that only their spread or mean is returned of.
fn made_bytes(
    request: &RollOutRequest,
    batch: &Batch,
    twin: &TwinShape,
    part_instances: u32,
) -> u64 {
    let sent = reply_bytes(request, batch, twin, part_instances);
    if !has_spread(request) && !has_mean_prediction(request) {
        return sent;
    }
    let mut all = request.clone();
    all.returns.iter_mut().for_each(|returns| returns.spread = false);
    all.ensemble.iter_mut().for_each(|ensemble| ensemble.set_statistic(Statistic::Mean));
    sent.saturating_add(reply_bytes(&all, batch, twin, part_instances))
}

/// Memory of a request that has passed the other checks, with `part_instances` instances to a
/// message of its reply (0: all in one).
pub fn memory(
    request: &RollOutRequest,
    batch: &Batch,
    twin: &TwinShape,
    part_instances: u32,
) -> Memory {
    let Batch { instances, frames, .. } = *batch;
    let rods = twin.rods.unwrap_or(0);
    // Its nodes are among the twin's, and are counted as all of them.
    let of_planner = request.fidelity() == Fidelity::Planner;
    let boundaries = frames.saturating_add(1);
    let returns = request.returns.clone().unwrap_or_default();
    let names = request.costs.iter().map(|cost| cost.name.len() as u64 + NAME);
    let names = names.sum::<u64>();

    let part = made_bytes(request, batch, twin, part_instances);
    let making = if returns.encoding() == Encoding::Int16 { MAKING_INT16 } else { MAKING };
    let messages = making + if part_instances == 0 { 0 } else { STREAMED_MESSAGES };
    let narrow = |count: u128| u64::try_from(count).unwrap_or(u64::MAX);
    let targets = narrow(targets(&request.costs, batch));
    let soft_min = request.costs.iter().any(|cost| cost.when() == When::SoftMin);
    // A soft minimum weighs frames differently in each instance's gradient.
    let own = own_targets(&request.costs, batch, soft_min && has_gradients(&returns));
    let own = narrow(own);
    let frame_costs = mul(&[FRAME_COST, boundaries, request.costs.len() as u64]);
    let holds = if request.grasps.is_empty() { 0 } else { mul(&[HOLD, twin.nodes]) };
    let state = sum(&[
        mul(&[24, twin.nodes]),
        mul(&[4, rods]),
        mul(&[CONTROL, twin.controls]),
        holds,
        INSTANCE,
    ]);
    let starts = match request.initial.as_ref().and_then(|initial| initial.state.as_ref()) {
        Some(State::Given(_)) => mul(&[state, instances]),
        _ => state,
    };
    let fixed = sum(&[
        mul(&[messages, part]),
        mul(&[TARGET, targets]),
        // Place and curve of each frame among the knots, shared by all instances.
        mul(&[CURVE, boundaries]),
        // Costs by instance, of all parts where the best are chosen.
        mul(&[instances, 16]),
        starts,
        surroundings::fixed_bytes(request, batch, twin),
        // Of all instances of a part, until its gradients are there.
        if soft_min { mul(&[instances, members(request), frame_costs]) } else { 0 },
    ]);

    let endpoints = twin.nodes.saturating_add(twin.controls);
    let elements = twin.most_elements(request.fidelity());
    let mut prepared =
        sum(&[mul(&[CONTROL, boundaries, twin.controls]), mul(&[2, names]), INSTANCE]);
    prepared = sum(&[prepared, mul(&[TARGET, own]), frame_costs]);
    prepared = sum(&[prepared, surroundings::prepared_bytes(request, batch)]);
    // What grasps hold at the end says which nodes they took.
    let end = if request.grasps.is_empty() { 0 } else { state };
    prepared = sum(&[prepared, end]);
    if has_mean_prediction(request) && !(request.costs.is_empty() && returns.every_frames == 0) {
        // Members with all their nodes in all frames, and with gradients targets that stand for those.
        let gradients = if has_gradients(&returns) { SEED } else { 0 };
        let kinds = if returns.velocities { 2 } else { 1 };
        let node = sum(&[mul(&[RECORDED_NODE, kinds]), gradients]);
        prepared = sum(&[prepared, mul(&[node, twin.nodes, boundaries])]);
    }
    let mut running = sum(&[
        mul(&[CONTROL_READ, boundaries, twin.controls]),
        mul(&[NODE, endpoints]),
        // Terms in the order of their frames.
        targets,
        surroundings::running_bytes(request, batch, twin),
    ]);
    // Keypoints at nodes are points of the planner's skin, behind those of the twin's own.
    let nodes_at_skin = of_planner && request.costs.iter().any(measures_nodes);
    if nodes_at_skin || request.costs.iter().any(is_at_skin) {
        let nodes = if nodes_at_skin { twin.nodes } else { 0 };
        let points = twin.most_skin_points().saturating_add(nodes);
        running = sum(&[running, mul(&[SKIN_POINT, points])]);
    }
    if has_gradients(&returns) {
        prepared = sum(&[
            prepared,
            mul(&[CONTROL, boundaries, twin.controls]),
            mul(&[ELEMENT_RETURNED, elements]),
            // By the initial state, and norms.
            mul(&[24, twin.nodes]),
            mul(&[8, boundaries]),
        ]);
        let kept = sum(&[mul(&[NODE_STATE, twin.nodes]), mul(&[ROD_STATE, rods]), NAME]);
        running = sum(&[
            running,
            mul(&[CONTROL_GRADIENT, boundaries, twin.controls]),
            mul(&[kept, boundaries]),
            mul(&[ELEMENT_GRADIENT, elements]),
            mul(&[NODE, endpoints]),
            tape(endpoints, rods, substeps(request, twin.substeps(request.fidelity())).most),
        ]);
    }
    // Parts in time: all instances of a part wait at the end of a window, with what is added up.
    let waiting = if returns.part_frames == 0 {
        0
    } else {
        let count = instances.min(part_instances.into());
        // A cost that looks back records every frame.
        let looks_back = |cost: &Cost| matches!(cost.kind, Some(Kind::Smoothness(_)));
        let recorded = match request.costs.iter().any(looks_back) {
            true => mul(&[making, RECORDED_NODE, twin.nodes, part_frames(request, batch)]),
            false => 0,
        };
        mul(&[count, members(request), sum(&[prepared, mul(&[2, state]), recorded])])
    };
    let mut fixed = sum(&[fixed, waiting]);
    if has_mean_prediction(request) {
        // The mean of one action: as it is added up, and as it is measured; and the model that tells strains.
        let kinds = if returns.velocities { 2 } else { 1 };
        let mean = mul(&[MEAN_NODE, kinds, twin.nodes, boundaries]);
        fixed = sum(&[fixed, mean, mul(&[ELEMENT_GRADIENT, elements])]);
        if has_gradients(&returns) {
            // All members of an action, however few are prepared at once otherwise.
            fixed = sum(&[fixed, mul(&[members(request), prepared])]);
        }
    }
    if of_planner || recorded(&returns) == PointSet::Skin {
        // Recordings of nodes, until the skin is placed from them: the planner's has the twin's nodes, too.
        let rows = part_frames(request, batch).checked_div(returns.every_frames.into());
        let kinds = if returns.velocities { 2 } else { 1 };
        let nodes = mul(&[RECORDED_NODE, kinds, twin.nodes, rows.unwrap_or(0)]);
        prepared = sum(&[prepared, nodes]);
        fixed = sum(&[fixed, mul(&[ROW, twin.nodes])]);
        if of_planner {
            // The points that the request becomes.
            fixed = sum(&[fixed, mul(&[ROW, recorded_count(&returns, twin)])]);
        }
    }
    Memory { request: request_bytes(request.encoded_len() as u64), fixed, prepared, running }
}

/// Memory of an encoded request of so many bytes.
pub fn request_bytes(encoded: u64) -> u64 {
    encoded.saturating_mul(REQUEST)
}

/// Most bytes of a tape. A frame whose tape is too large is cut into segments, no shorter than the
/// root of their number; marks are kept of their starts.
fn tape(endpoints: u64, rods: u64, substeps: u32) -> u64 {
    let substep = sum(&[mul(&[NODE_TAPED, endpoints]), mul(&[ROD_STATE, rods])]);
    let root = u64::from(substeps.isqrt()) + 1;
    mul(&[substep, u64::from(substeps)]).min(WHOLE_TAPE.saturating_add(mul(&[2, root, substep])))
}

/// What overflows stays at the largest number, which exceeds every limit.
fn sum(terms: &[u64]) -> u64 {
    terms.iter().fold(0, |sum, term| sum.saturating_add(*term))
}

fn mul(factors: &[u64]) -> u64 {
    factors.iter().fold(1, |product, factor| product.saturating_mul(*factor))
}

#[cfg(test)]
mod tests;
