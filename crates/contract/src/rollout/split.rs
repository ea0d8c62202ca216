//! Cuts of a request by instance, and the reply of the whole from those of the cuts: several workers
//! then share one batch. Tensors are cut without a copy.

use std::ops::Range;

use bendtwin_proto::v1::{
    Grasping, RollOutRequest, RollOutResponse, Tensor,
    cost::Kind,
    initial_state::State,
    returns::Encoding,
    roll_out_request::Actions,
    roll_out_response::{Forces, Timing},
};
use bytes::{Bytes, BytesMut};

use super::{Batch, TwinShape};

/// Replies that are not those of the parts of one request.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("replies to the parts of a rollout do not fit together: {0}")]
pub struct Mismatch(&'static str);

/// True if the instances of a request may be simulated apart. `best` ranks the whole batch, 16-bit
/// positions have one scale, members of an ensemble belong together, and a refusal names an
/// instance of the whole.
pub fn can_split(request: &RollOutRequest) -> bool {
    let whole_returns =
        request.returns.as_ref().is_some_and(|r| r.best > 0 || r.encoding() == Encoding::Int16);
    let refuses = request.plausibility.as_ref().is_some_and(|p| p.refuse);
    !whole_returns && !refuses && request.ensemble.is_none()
}

/// Most work of the instances that a GPU simulates together, in element substeps: a fraction of a
/// second on a large one.
pub const SLICE_WORK: f64 = 1e10;

/// Number of instances that a GPU with `lanes` lanes simulates together: whole rounds of them
/// within [`SLICE_WORK`], at least one. Parts of whole slices have the bits of the whole there.
pub fn slice_instances(
    request: &RollOutRequest,
    batch: &Batch,
    twin: &TwinShape,
    lanes: u64,
) -> u64 {
    let round = lanes.max(1);
    let instance = twin.slice_work(request.fidelity(), batch.frames);
    let rounds = (SLICE_WORK / (instance * round as f64).max(1.0)) as u64;
    rounds.max(1).saturating_mul(round)
}

/// At most `count` nonempty runs of nearly equal length that cover `0..instances`, cut at multiples
/// of `unit`.
pub fn runs(instances: u64, count: u64, unit: u64) -> impl Iterator<Item = Range<u64>> {
    let unit = unit.max(1);
    let units = instances.div_ceil(unit);
    let count = count.clamp(1, units.max(1));
    let edge = move |i: u64| {
        let edge = u128::from(units) * u128::from(i) / u128::from(count) * u128::from(unit);
        u64::try_from(edge).unwrap_or(instances).min(instances)
    };
    (0..count).map(move |i| edge(i)..edge(i + 1))
}

/// The request for a run of the instances of a checked one that [`can_split`].
pub fn part(request: &RollOutRequest, batch: &Batch, of: Range<u64>) -> RollOutRequest {
    let mut part = request.clone();
    let cut = |tensor: Option<&mut Tensor>, rank: usize| {
        // Of a lower rank are tensors for all instances.
        if let Some(tensor) = tensor.filter(|t| t.shape.len() == rank) {
            rows(tensor, batch.instances, &of);
        }
    };
    match &mut part.actions {
        Some(Actions::Trajectories(t)) => cut(t.positions.as_mut(), 4),
        Some(Actions::Poses(p)) => cut(p.poses.as_mut(), 4),
        None => {}
    }
    // Knots are those of the actions: a part has as many.
    by_instance(&mut part, cut);
    part
}

/// Shows the tensors beside the actions that may have a row for each instance, with the rank that
/// they have then.
pub(crate) fn by_instance(request: &mut RollOutRequest, see: impl Fn(Option<&mut Tensor>, usize)) {
    if let Some(State::Given(given)) = request.initial.as_mut().and_then(|i| i.state.as_mut()) {
        see(given.positions.as_mut(), 3);
        see(given.velocities.as_mut(), 3);
        see(given.twists.as_mut(), 2);
        see(given.controls.as_mut(), 3);
        see(given.commanded_controls.as_mut(), 3);
        if let Some(grasping) = &mut given.grasping {
            see(grasping.phases.as_mut(), 2);
            see(grasping.holders.as_mut(), 2);
            see(grasping.places.as_mut(), 3);
        }
    }
    for cost in &mut request.costs {
        match &mut cost.kind {
            Some(Kind::TargetCloud(cloud)) => see(cloud.points.as_mut(), 4),
            Some(Kind::Keypoints(keypoints)) => see(keypoints.targets.as_mut(), 4),
            _ => {}
        }
    }
    for grasp in &mut request.grasps {
        see(grasp.closed.as_mut(), 2);
    }
    if let Some(vary) = &mut request.vary {
        for values in [
            &mut vary.stiffness,
            &mut vary.damping,
            &mut vary.bending,
            &mut vary.friction,
            &mut vary.mass,
            &mut vary.ground_restitution,
            &mut vary.object_restitution,
        ] {
            see(values.as_mut(), 1);
        }
    }
}

/// Keeps some of the `count` rows of a tensor.
fn rows(tensor: &mut Tensor, count: u64, of: &Range<u64>) {
    let bytes = tensor.data.len() as u64;
    if tensor.shape.first() != Some(&count) || count == 0 || !bytes.is_multiple_of(count) {
        return;
    }
    let width = bytes / count;
    let at = |row: u64| usize::try_from(row * width).unwrap_or(usize::MAX).min(tensor.data.len());
    tensor.data = tensor.data.slice(at(of.start)..at(of.end));
    if let Some(rows) = tensor.shape.first_mut() {
        *rows = of.end - of.start;
    }
}

/// The reply to the whole, from the replies to its parts in order. Times are the longest of all;
/// what holds of the whole is that of the first.
///
/// # Errors
/// If the replies have not the same fields and shapes.
pub fn join(mut replies: Vec<RollOutResponse>) -> Result<RollOutResponse, Mismatch> {
    let mut first_instance: u32 = 0;
    for reply in &mut replies {
        let count = reply.costs.as_ref().and_then(|t| t.shape.first()).copied();
        let count = count.ok_or(Mismatch("one has no costs"))?;
        renumber(reply, first_instance)?;
        let count = u32::try_from(count).ok();
        let next = count.and_then(|count| first_instance.checked_add(count));
        first_instance = next.ok_or(Mismatch("too many instances"))?;
    }
    macro_rules! joined {
        ($($field:ident).+) => {
            concatenated(replies.iter().map(|r| joined!(@get r, $($field).+)))?
        };
        (@get $r:ident, $field:ident) => { $r.$field.as_ref() };
        (@get $r:ident, $outer:ident . $field:ident) => {
            $r.$outer.as_ref().and_then(|outer| outer.$field.as_ref())
        };
    }
    let forces = Forces {
        controls: joined!(forces.controls),
        grasps: joined!(forces.grasps),
        ground: joined!(forces.ground),
        colliders: joined!(forces.colliders),
    };
    let grasping = Grasping {
        phases: joined!(final_grasping.phases),
        holders: joined!(final_grasping.holders),
        places: joined!(final_grasping.places),
    };
    let timing = replies.iter().filter_map(|r| r.timing).reduce(|a, b| Timing {
        queue_s: a.queue_s.max(b.queue_s),
        compute_s: a.compute_s.max(b.compute_s),
    });
    let (has_forces, has_grasping) = match replies.first() {
        Some(first) => (first.forces.is_some(), first.final_grasping.is_some()),
        None => return Err(Mismatch("there are none")),
    };
    let whole = RollOutResponse {
        costs: joined!(costs),
        cost_terms: joined!(cost_terms),
        instances: joined!(instances),
        positions: joined!(positions),
        final_positions: joined!(final_positions),
        final_velocities: joined!(final_velocities),
        final_twists: joined!(final_twists),
        final_controls: joined!(final_controls),
        final_commanded_controls: joined!(final_commanded_controls),
        final_grasping: has_grasping.then_some(grasping),
        control_gradients: joined!(control_gradients),
        action_gradients: joined!(action_gradients),
        initial_position_gradients: joined!(initial_position_gradients),
        initial_velocity_gradients: joined!(initial_velocity_gradients),
        gradient_norms: joined!(gradient_norms),
        gradient_exploded: joined!(gradient_exploded),
        velocities: joined!(velocities),
        forces: has_forces.then_some(forces),
        frame_costs: joined!(frame_costs),
        controls: joined!(controls),
        member_costs: joined!(member_costs),
        successes: joined!(successes),
        unfinished: joined!(unfinished),
        diagnostics: replies.iter().flat_map(|r| r.diagnostics.iter().copied()).collect(),
        diverged: replies.iter().flat_map(|r| r.diverged.iter().copied()).collect(),
        implausible: replies.iter().flat_map(|r| r.implausible.iter().cloned()).collect(),
        timing,
        ..RollOutResponse::default()
    };
    let mut first = replies.swap_remove(0);
    Ok(RollOutResponse {
        frames: first.frames.take(),
        cost_names: std::mem::take(&mut first.cost_names),
        worker: std::mem::take(&mut first.worker),
        fidelity: first.fidelity,
        substeps: first.substeps,
        deviation: first.deviation,
        mass_kg: first.mass_kg,
        ..whole
    })
}

/// Makes the numbers of instances those of the whole.
fn renumber(reply: &mut RollOutResponse, first: u32) -> Result<(), Mismatch> {
    let shifted = |i: u32| i.checked_add(first).ok_or(Mismatch("too many instances"));
    reply.diverged.iter_mut().try_for_each(|d| shifted(d.instance).map(|i| d.instance = i))?;
    reply.implausible.iter_mut().try_for_each(|d| shifted(d.instance).map(|i| d.instance = i))?;
    for instances in [&mut reply.instances, &mut reply.unfinished].into_iter().flatten() {
        let (shape, values) = instances
            .unpack::<u32>("instances")
            .map_err(|_| Mismatch("one has instances without numbers"))?;
        let values: Vec<u32> = values.into_iter().map(shifted).collect::<Result<_, _>>()?;
        *instances = Tensor::pack(&shape, &values);
    }
    Ok(())
}

/// The rows of all tensors in one; `None` without tensors.
fn concatenated<'t>(
    tensors: impl Iterator<Item = Option<&'t Tensor>>,
) -> Result<Option<Tensor>, Mismatch> {
    let tensors: Vec<Option<&Tensor>> = tensors.collect();
    if tensors.iter().all(Option::is_none) {
        return Ok(None);
    }
    let tensors: Vec<&Tensor> =
        tensors.into_iter().collect::<Option<_>>().ok_or(Mismatch("a tensor is missing in one"))?;
    let Some((first, rest)) = tensors.split_first() else { return Ok(None) };
    let row = |t: &Tensor| t.shape.get(1..).map(<[u64]>::to_vec);
    let is_alike = |t: &&Tensor| {
        t.dtype == first.dtype
            && row(t) == row(first)
            && t.scale == first.scale
            && t.offset == first.offset
            && t.checked_shape("").is_ok()
    };
    if first.shape.is_empty() || !is_alike(first) || !rest.iter().all(is_alike) {
        return Err(Mismatch("a tensor has another shape in one"));
    }
    let count = tensors.iter().filter_map(|t| t.shape.first()).sum::<u64>();
    let mut data = BytesMut::with_capacity(tensors.iter().map(|t| t.data.len()).sum());
    tensors.iter().for_each(|t| data.extend_from_slice(&t.data));
    let shape = std::iter::once(count).chain(first.shape.iter().skip(1).copied()).collect();
    Ok(Some(Tensor { shape, data: Bytes::from(data), ..(*first).clone() }))
}

#[cfg(test)]
mod tests;
