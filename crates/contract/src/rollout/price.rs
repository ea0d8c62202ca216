//! The price of a rollout before anything is unpacked: its work, the size of its reply, and its memory
//! at a worker. Each part of a request says its own; here is what they have in common, and the sum.

use std::ops::Add;

use bendtwin_proto::v1::{Fidelity, Returns, RollOutRequest, ensemble::Statistic};
use prost::Message as _;

use super::{
    check::Batch,
    memory::{Memory, request_bytes},
    message::Message,
    parts::part_frames,
    request::{
        actions, costs, gradients, grasps, initial, partial, plausibility,
        returns::{self, has_spread},
        vary::{self, has_mean_prediction, members, substeps},
        world,
    },
    twin::TwinShape,
};

/// An instance beside its arrays, in the batch, in a slice of it, and its result.
pub(super) const INSTANCE: u64 = 1024;
/// A node (or control point) of a simulation that runs: its state, forces, velocities before and
/// after contact, candidates.
pub(super) const NODE: u64 = 256;
/// A node in a recording, whose buffer may be twice as large.
pub(super) const RECORDED_NODE: u64 = 24;
/// Sum of an element's gradient.
pub(super) const ELEMENT_GRADIENT: u64 = 64;
/// Tag and length of a nested message below 128 bytes.
pub(super) const HEAD: u64 = 2;
/// Longest encoding of a `Divergence`: three counts.
const DIVERGENCE: u64 = HEAD + 3 * 6;
/// Longest encoding of what every reply has: first_instance, timing, worker, fidelity, substeps,
/// deviation, mass_kg.
const REST: u64 = 6 + (HEAD + 2 * 9) + 48 + 2 + 7 + (1 + HEAD + 3 * 9 + 6) + 10;

/// A request that has passed the other checks, beside its twin.
pub(super) struct Asked<'a> {
    pub(super) request: &'a RollOutRequest,
    pub(super) returns: Returns,
    pub(super) batch: &'a Batch,
    pub(super) twin: &'a TwinShape,
    /// Instances of one message of the reply; 0: all in one.
    pub(super) part_instances: u32,
    /// Sets of parameters under which each action is simulated.
    pub(super) members: u64,
    /// Frame boundaries F + 1.
    pub(super) boundaries: u64,
    /// Frames of one part of the reply.
    pub(super) part_frames: u64,
    /// Actions that one message of the reply covers.
    pub(super) covered: u64,
    /// Actions whose arrays one message has.
    pub(super) ranked: u64,
    /// Instances whose arrays one message has: all members of an ensemble, or one with a spread or a mean.
    pub(super) holders: u64,
}

impl<'a> Asked<'a> {
    fn new(
        request: &'a RollOutRequest,
        batch: &'a Batch,
        twin: &'a TwinShape,
        part_instances: u32,
    ) -> Self {
        let returns = request.returns.clone().unwrap_or_default();
        let members = members(request);
        let covered = match part_instances {
            0 => batch.instances,
            part => u64::from(part).min(batch.instances),
        };
        let ranked = match returns.best {
            0 => covered,
            best => u64::from(best).min(batch.instances),
        };
        let by_action = has_spread(request) || has_mean_prediction(request);
        Self {
            request,
            batch,
            twin,
            part_instances,
            members,
            boundaries: batch.frames.saturating_add(1),
            part_frames: part_frames(request, batch),
            covered,
            ranked,
            holders: if by_action { ranked } else { ranked.saturating_mul(members) },
            returns,
        }
    }

    /// True if a planner's twin answers.
    pub(super) fn is_of_planner(&self) -> bool {
        self.request.fidelity() == Fidelity::Planner
    }

    /// Nodes and control points.
    pub(super) fn endpoints(&self) -> u64 {
        self.twin.nodes.saturating_add(self.twin.controls)
    }

    /// Springs, triplets and rods that are simulated, at most.
    pub(super) fn elements(&self) -> u64 {
        self.twin.most_elements(self.request.fidelity())
    }

    /// Numbers of points that are recorded together: positions alone, or velocities with them.
    pub(super) fn kinds(&self) -> u64 {
        if self.returns.velocities { 2 } else { 1 }
    }

    /// The prices of all parts together.
    fn price(&self) -> Price {
        let mut rest = Message(REST);
        rest.add(mul(&[self.covered, self.members, DIVERGENCE]));
        let parts = [
            actions::price(self),
            costs::price(self),
            gradients::price(self),
            grasps::price(self),
            initial::price(self),
            partial::price(self),
            plausibility::price(self),
            returns::price(self),
            vary::price(self),
            world::price(self),
        ];
        let simulated = Price {
            reply: rest,
            prepared: INSTANCE,
            running: mul(&[NODE, self.endpoints()]),
            ..Price::default()
        };
        parts.into_iter().fold(simulated, Add::add)
    }

    /// Work of all instances, in element substeps.
    fn work(&self, price: &Price) -> u128 {
        let (request, batch, twin) = (self.request, self.batch, self.twin);
        let substeps = substeps(request, twin.substeps(request.fidelity()));
        let physics = twin.substep_work(request.fidelity(), batch.frames, price.work_of_node);
        let physics = physics.saturating_mul(substeps.total).div_ceil(substeps.sets.into());
        let each = physics.saturating_add(price.work);
        let of_members = each.saturating_mul(self.members.into());
        // Of a mean prediction costs are measured beside those of its members.
        let of_mean = if has_mean_prediction(request) { price.work } else { 0 };
        of_members.saturating_add(of_mean).saturating_mul(batch.instances.into())
    }

    /// Memory at a worker.
    fn memory(&self, price: &Price) -> Memory {
        let messages = returns::messages(self);
        Memory {
            request: request_bytes(self.request.encoded_len() as u64),
            fixed: sum(&[
                price.fixed,
                mul(&[messages, self.made_bytes(price)]),
                mul(&[price.waiting, price.prepared]),
            ]),
            prepared: sum(&[price.prepared, price.recorded]),
            running: price.running,
        }
    }

    /// A message of the reply, with the arrays of the members that only their spread or mean is returned
    /// of.
    fn made_bytes(&self, price: &Price) -> u64 {
        if !has_spread(self.request) && !has_mean_prediction(self.request) {
            return price.reply.0;
        }
        let mut all = self.request.clone();
        all.returns.iter_mut().for_each(|returns| returns.spread = false);
        all.ensemble.iter_mut().for_each(|ensemble| ensemble.set_statistic(Statistic::Mean));
        let all = Asked::new(&all, self.batch, self.twin, self.part_instances).price();
        price.reply.0.saturating_add(all.reply.0)
    }
}

/// Share of a part of a request in the price of the whole.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Price {
    /// Work of an instance beside its physics, in element substeps.
    pub(super) work: u128,
    /// Work of each node in a substep, in elements.
    pub(super) work_of_node: u64,
    /// Most bytes of one message of the reply.
    pub(super) reply: Message,
    /// Memory of all instances together [bytes].
    pub(super) fixed: u64,
    /// Memory of an instance that is prepared [bytes].
    pub(super) prepared: u64,
    /// Memory of a prepared instance for its recording, which is over with its run [bytes].
    pub(super) recorded: u64,
    /// Memory of an instance that runs, beyond that [bytes].
    pub(super) running: u64,
    /// Instances that stay prepared while others run.
    pub(super) waiting: u64,
}

impl Add for Price {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self {
            work: self.work.saturating_add(other.work),
            work_of_node: self.work_of_node.saturating_add(other.work_of_node),
            reply: Message(self.reply.0.saturating_add(other.reply.0)),
            fixed: self.fixed.saturating_add(other.fixed),
            prepared: self.prepared.saturating_add(other.prepared),
            recorded: self.recorded.saturating_add(other.recorded),
            running: self.running.saturating_add(other.running),
            waiting: self.waiting.saturating_add(other.waiting),
        }
    }
}

/// Work, bytes of one message of the reply, and memory of a request that has passed the other checks,
/// with `part_instances` instances to a message of its reply (0: all in one).
pub(super) fn price(
    request: &RollOutRequest,
    batch: &Batch,
    twin: &TwinShape,
    part_instances: u32,
) -> (u128, u64, Memory) {
    let asked = Asked::new(request, batch, twin, part_instances);
    let price = asked.price();
    (asked.work(&price), price.reply.0, asked.memory(&price))
}

/// Work of a checked request, in element substeps.
pub fn work(request: &RollOutRequest, batch: &Batch, twin: &TwinShape) -> u128 {
    let asked = Asked::new(request, batch, twin, 0);
    asked.work(&asked.price())
}

/// Most bytes that one message of the reply to a checked request takes when encoded, with
/// `part_instances` instances to a message (0: all in one). Tensors are exact; of each instance it
/// is assumed that it diverges and that no number of its diagnostics is zero.
pub fn reply_bytes(
    request: &RollOutRequest,
    batch: &Batch,
    twin: &TwinShape,
    part_instances: u32,
) -> u64 {
    Asked::new(request, batch, twin, part_instances).price().reply.0
}

/// Memory of a request that has passed the other checks, with `part_instances` instances to a
/// message of its reply (0: all in one).
pub fn memory(
    request: &RollOutRequest,
    batch: &Batch,
    twin: &TwinShape,
    part_instances: u32,
) -> Memory {
    let asked = Asked::new(request, batch, twin, part_instances);
    asked.memory(&asked.price())
}

/// Memory of the models of a request whose instances have `rests` rest shapes beside the twin's own
/// [bytes]: each is varied as the request says.
pub fn models_bytes(request: &RollOutRequest, rests: u64, twin: &TwinShape) -> u64 {
    let set = vary::set_bytes(twin.most_elements(request.fidelity()));
    mul(&[set, rests, members(request)])
}

/// What overflows stays at the largest number, which exceeds every limit.
pub(super) fn sum(terms: &[u64]) -> u64 {
    terms.iter().fold(0, |sum, term| sum.saturating_add(*term))
}

pub(super) fn mul(factors: &[u64]) -> u64 {
    factors.iter().fold(1, |product, factor| product.saturating_mul(*factor))
}
