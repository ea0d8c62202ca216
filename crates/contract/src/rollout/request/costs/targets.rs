//! Targets of costs: one list for all, or lists by frame and by instance.

use bendtwin_proto::v1::{
    Cost, Tensor,
    cost::{Kind, When},
    tensor::Dtype,
};

use crate::rollout::{
    Error,
    check::Batch,
    request::tensors::{finite, given, required},
};

/// Number of points of a list of targets, [M, 3], [F, M, 3], [B, 1, M, 3] or [B, F, M, 3].
pub(super) fn check(
    tensor: Option<&Tensor>,
    field: &str,
    when: When,
    batch: &Batch,
) -> Result<u64, Error> {
    let (tensor, shape) = required(tensor, field, Dtype::Float32)?;
    let refused = |fault: String| Err(Error::field(field, fault));
    let (instances, frames, count) = match shape[..] {
        [count, 3] => (None, None, count),
        [frames, count, 3] => (None, Some(frames), count),
        [instances, 1, count, 3] => (Some(instances), None, count),
        [instances, frames, count, 3] => (Some(instances), Some(frames), count),
        _ => {
            return refused(format!(
                "has shape {shape:?}, not [M, 3], [F, M, 3], [B, 1, M, 3] or [B, F, M, 3]"
            ));
        }
    };
    if count == 0 {
        return refused(format!("has shape {shape:?}: at least one point is needed"));
    }
    if instances.is_some_and(|n| n != batch.instances) {
        let fault = format!("has shape {shape:?} for {} instances", batch.instances);
        return refused(fault);
    }
    if frames.is_some_and(|n| n != batch.frames) {
        return refused(format!("has shape {shape:?} for {} frames", batch.frames));
    }
    if frames.is_some() && !matches!(when, When::EveryFrame | When::SoftMin) {
        let fault = "has targets by frame, of which only the last would count: set `when` to EVERY_FRAME or SOFT_MIN";
        return refused(fault.to_owned());
    }
    finite(tensor, field).map(|()| count)
}

/// Checks a list of targets that is the same for all instances and frames, [M, 3].
pub(super) fn check_fixed(tensor: Option<&Tensor>, field: &str) -> Result<(), Error> {
    let (tensor, shape) = required(tensor, field, Dtype::Float32)?;
    match shape[..] {
        [count, 3] if count > 0 => finite(tensor, field),
        _ => Err(Error::field(field, format!("has shape {shape:?}, not [M, 3] with M >= 1"))),
    }
}

/// The tensor of a cost's targets, if it has any.
fn of(cost: &Cost) -> Option<&Tensor> {
    match &cost.kind {
        Some(Kind::TargetCloud(cloud)) => cloud.points.as_ref(),
        Some(Kind::Keypoints(keypoints)) => keypoints.targets.as_ref(),
        Some(Kind::Coverage(coverage)) => coverage.points.as_ref(),
        Some(_) | None => None,
    }
}

/// Number of points, of targets or of those that are named, in one frame of one instance.
pub(super) fn points(cost: &Cost) -> u128 {
    let named = match &cost.kind {
        Some(Kind::Height(height)) => height.nodes.as_ref(),
        Some(Kind::Within(within)) => within.nodes.as_ref(),
        Some(Kind::Order(o)) => given(o.skin_points.as_ref()).or(o.nodes.as_ref()),
        Some(Kind::Winding(w)) => given(w.skin_points.as_ref()).or(w.nodes.as_ref()),
        Some(_) | None => None,
    };
    let count = match of(cost) {
        Some(targets) => targets.shape.iter().rev().nth(1),
        None => named.and_then(|t| t.shape.first()),
    };
    count.map_or(0, |n| u128::from(*n))
}

/// True if a cost has other targets for other instances.
pub(super) fn by_instance(cost: &Cost) -> bool {
    of(cost).is_some_and(|t| t.shape.len() == 4)
}
