//! Parameters by instance, and ensembles of them, with the models that they need.

use bendtwin_proto::v1::{
    Cost, Fidelity, RollOutRequest, Tensor, Vary, cost::Kind, ensemble::Statistic, tensor::Dtype,
};

use super::{
    Asked, Batch, Error, Limits, Message, Price,
    gradients::has_gradients,
    mul, sum,
    tensors::{floats, given, required},
    within,
};
use crate::rollout::price::{ELEMENT_GRADIENT, RECORDED_NODE};

/// Largest factor of a parameter.
const MOST: f32 = 100.0;
/// Smallest factor of what must not vanish.
const LEAST: f32 = 0.01;
/// Most substeps of a frame of what is varied.
pub const MOST_SUBSTEPS: u32 = 100_000;
/// Numbers of substeps between one and its double: few, as each needs a model on the device.
const RUNGS: f64 = 4.0;
/// A parameter of an element in the engine and in the model that keeps it [bytes].
const PARAMETER: u64 = 16;
/// A set of parameters beside its arrays [bytes].
pub(in crate::rollout) const SET: u64 = 4096;
/// Numbers of substeps that variants of a model have, at most.
const MOST_FINER: u64 = 64;
/// Costs of a member, kept until those of all are there [bytes].
const MEMBER: u64 = 64;
/// A node in a frame of a mean: its sums in double precision, the mean, and its measured copy, with
/// the gradient [bytes].
const MEAN_NODE: u64 = 128;
/// A node in a frame whose gradient is given to the engine: its target and number, twice [bytes].
const SEED: u64 = 32;

pub(in crate::rollout) fn check(
    request: &RollOutRequest,
    batch: &Batch,
    limits: &Limits,
) -> Result<(), Error> {
    let sets = match &request.ensemble {
        None => ("B", batch.instances),
        Some(_) => ("E", members(request)),
    };
    if let Some(ensemble) = &request.ensemble {
        if ensemble.members == 0 {
            let fault = "is 0: say how many sets of parameters `vary` has";
            return Err(Error::field("ensemble.members", fault));
        }
        let Ok(statistic) = Statistic::try_from(ensemble.statistic) else {
            let fault = format!(
                "has the unknown value {}: use MEAN, WORST, CVAR or MEAN_PREDICTION",
                ensemble.statistic
            );
            return Err(Error::field("ensemble.statistic", fault));
        };
        let share = ensemble.share;
        if statistic == Statistic::Cvar && !(share > 0.0 && share <= 1.0) {
            let fault = format!("is {share}: with CVAR it must lie above 0 and be at most 1");
            return Err(Error::field("ensemble.share", fault));
        }
        if statistic == Statistic::MeanPrediction {
            mean_prediction(request)?;
        }
        if ensemble.members > 1 && request.vary.as_ref().is_none_or(is_empty) {
            let fault = "is missing: without it all members of the ensemble are the same";
            return Err(Error::field("vary", fault));
        }
        within(
            "the number of instances (actions x members)",
            u128::from(batch.instances) * u128::from(ensemble.members),
            limits.instances,
            "split the batch, or use fewer members",
        )?;
    }
    let Some(vary) = &request.vary else { return Ok(()) };
    if vary.fits && request.ensemble.is_none() {
        let fault = "is without an `ensemble`, whose members are simulated on the fits";
        return Err(Error::field("vary.fits", fault));
    }
    if vary.fits && matches!(request.fidelity(), Fidelity::Fast | Fidelity::Planner) {
        let fault = "is for the exact twin, and the fast variant and the planner's twin have no other fits: ask for EXACT";
        return Err(Error::field("vary.fits", fault));
    }
    for (name, tensor, [least, most]) in given_by_set(vary) {
        if let Some(tensor) = given(tensor) {
            numbers(tensor, &format!("vary.{name}"), sets, least, most)?;
        }
    }
    Ok(())
}

/// Refuses what positions do not tell, and what is there before it is known which members diverge.
fn mean_prediction(request: &RollOutRequest) -> Result<(), Error> {
    let is_force = |cost: &Cost| matches!(cost.kind, Some(Kind::Force(_)));
    let returns = request.returns.clone().unwrap_or_default();
    let (field, why) = if let Some(i) = request.costs.iter().position(is_force) {
        (format!("costs[{i}].force"), "a mean of positions has no forces")
    } else if returns.forces {
        ("returns.forces".to_owned(), "a mean of positions has no forces")
    } else if returns.part_frames > 0 {
        let why =
            "which members diverge, and so have no part in the mean, is known only at the end";
        ("returns.part_frames".to_owned(), why)
    } else {
        return Ok(());
    };
    let fault = format!(
        "does not go with the statistic MEAN_PREDICTION: {why}. Leave it out, or take the MEAN of the members' costs"
    );
    Err(Error::field(field, fault))
}

/// True if a reply has the mean motion of the members of an ensemble in the place of theirs.
pub fn has_mean_prediction(request: &RollOutRequest) -> bool {
    request.ensemble.is_some_and(|ensemble| ensemble.statistic() == Statistic::MeanPrediction)
}

/// Number of sets of parameters under which each action is simulated.
pub fn members(request: &RollOutRequest) -> u64 {
    request.ensemble.as_ref().map_or(1, |ensemble| u64::from(ensemble.members.max(1)))
}

/// Most sets of parameters that differ, beside the twin's own.
fn sets(request: &RollOutRequest, batch: &Batch) -> u64 {
    let varied = request.vary.as_ref().is_some_and(|vary| !is_empty(vary));
    match &request.ensemble {
        _ if !varied => 0,
        None => batch.instances,
        Some(_) => members(request),
    }
}

fn is_empty(vary: &Vary) -> bool {
    !vary.fits && given_by_set(vary).into_iter().all(|(_, tensor, _)| given(tensor).is_none())
}

/// Name and tensor of what differs between sets of parameters, with its least and greatest value.
fn given_by_set(vary: &Vary) -> [(&'static str, Option<&Tensor>, [f32; 2]); 7] {
    [
        ("stiffness", vary.stiffness.as_ref(), [LEAST, MOST]),
        ("damping", vary.damping.as_ref(), [0.0, MOST]),
        ("bending", vary.bending.as_ref(), [0.0, MOST]),
        ("friction", vary.friction.as_ref(), [0.0, MOST]),
        ("mass", vary.mass.as_ref(), [LEAST, MOST]),
        ("ground_restitution", vary.ground_restitution.as_ref(), [0.0, 1.0]),
        ("object_restitution", vary.object_restitution.as_ref(), [0.0, 1.0]),
    ]
}

fn numbers(
    tensor: &Tensor,
    field: &str,
    (name, count): (&str, u64),
    least: f32,
    most: f32,
) -> Result<(), Error> {
    let (tensor, shape) = required(Some(tensor), field, Dtype::Float32)?;
    if shape != [count] {
        let fault = format!("has shape {shape:?}, not [{count}] ({name})");
        return Err(Error::field(field, fault));
    }
    match floats(tensor).enumerate().find(|(_, x)| !(least..=most).contains(x)) {
        Some((i, x)) => {
            let what = if most == MOST { "is a factor, and must" } else { "must" };
            let fault = format!("is {x} for {i}: it {what} lie in {least}..={most}");
            Err(Error::field(field, fault))
        }
        None => Ok(()),
    }
}

/// Sets of parameters, and members of an ensemble.
pub(in crate::rollout) fn price(asked: &Asked<'_>) -> Price {
    let (request, members) = (asked.request, asked.members);
    let own_substeps = asked.twin.substeps(request.fidelity());
    let sets = sets(request, asked.batch);
    // Models with more substeps, from which others are made.
    let finer = if substeps(request, own_substeps).most > own_substeps {
        sets.min(mul(&[MOST_FINER, members]))
    } else {
        0
    };
    let models = mul(&[set_bytes(asked.elements()), sum(&[sets, finer])]);
    let mut reply = Message::default();
    if request.ensemble.is_some() {
        reply.tensor(2, 8, &[asked.covered, members]);
    }
    let costs = mul(&[asked.batch.instances, members, MEMBER]);
    let own = Price { reply, fixed: sum(&[models, costs]), ..Price::default() };
    if has_mean_prediction(request) { own + mean(asked) } else { own }
}

/// The mean motion of the members of an action.
fn mean(asked: &Asked<'_>) -> Price {
    let Asked { returns, twin, boundaries, .. } = asked;
    let has_gradients = has_gradients(returns);
    let mut price = Price {
        // The sums, and the measured copy; and the model that strains need.
        fixed: sum(&[
            mul(&[MEAN_NODE, asked.kinds(), twin.nodes, *boundaries]),
            mul(&[ELEMENT_GRADIENT, asked.elements()]),
        ]),
        // With gradients all members of an action are there, however few are prepared otherwise.
        waiting: if has_gradients { asked.members } else { 0 },
        ..Price::default()
    };
    if !asked.request.costs.is_empty() || returns.every_frames > 0 {
        // Members with all their nodes in all frames, and with gradients targets that stand for those.
        let seed = if has_gradients { SEED } else { 0 };
        let node = sum(&[mul(&[RECORDED_NODE, asked.kinds()]), seed]);
        price.prepared = mul(&[node, twin.nodes, *boundaries]);
    }
    price
}

/// Memory of a set of parameters of `elements` elements [bytes].
pub(in crate::rollout) fn set_bytes(elements: u64) -> u64 {
    sum(&[mul(&[elements, 3 * PARAMETER]), SET])
}

/// Substeps of the sets of parameters of a request, at most: a worker finds out what each needs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::rollout) struct Substeps {
    /// Total of all sets.
    pub(in crate::rollout) total: u128,
    /// Number of sets.
    pub(in crate::rollout) sets: u64,
    /// Largest of any set.
    pub(in crate::rollout) most: u32,
}

/// Substeps of the sets of a checked request to a twin that has `own` a frame.
///
/// A substep dt is stable as long as `dt² k + 2 dt c <= 4` for all modes. Factors multiply k by at most
/// that of stiffness or bending, and c by that of damping, both divided by that of the mass; so a
/// substep that is shorter by `max(sqrt(k'/k), c'/c)` is stable again.
pub(in crate::rollout) fn substeps(request: &RollOutRequest, own: u32) -> Substeps {
    let nothing = Vary::default();
    let vary = request.vary.as_ref().unwrap_or(&nothing);
    let of = |tensor: &Option<Tensor>| -> Vec<f32> {
        given(tensor.as_ref()).map(|tensor| floats(tensor).collect()).unwrap_or_default()
    };
    let [stiffness, bending, damping, mass] =
        [&vary.stiffness, &vary.bending, &vary.damping, &vary.mass].map(of);
    let count = [&stiffness, &bending, &damping, &mass].map(Vec::len).into_iter().max();
    let count = count.unwrap_or(0).max(1);
    let at = |values: &[f32], set: usize| f64::from(values.get(set).copied().unwrap_or(1.0));
    let each = |set: usize| {
        let stiffer = at(&stiffness, set).max(at(&bending, set)) / at(&mass, set);
        let ratio = stiffer.sqrt().max(at(&damping, set) / at(&mass, set));
        if ratio <= 1.0 { own } else { finer_substeps(own, f64::from(own) * ratio) }
    };
    let all = (0..count).map(each);
    Substeps {
        total: all.clone().map(u128::from).sum(),
        sets: count as u64,
        most: all.max().unwrap_or(own),
    }
}

/// Substeps of a variant that needs at least `needed`, of a twin that has `own`: the next of four
/// numbers between each and its double, at most [`MOST_SUBSTEPS`], or what the twin has, if that is
/// more.
pub fn finer_substeps(own: u32, needed: f64) -> u32 {
    let rung = RUNGS * (needed / f64::from(own.max(1))).log2();
    // A rung that is met exactly is not passed by rounding.
    let rung = (rung - 1e-9).ceil().max(0.0);
    let substeps = (f64::from(own) * (rung / RUNGS).exp2()).max(needed).ceil();
    // A saturating cast.
    (substeps as u32).min(MOST_SUBSTEPS).max(own)
}
