//! Costs: names, weights, times and targets.

use std::collections::HashSet;

use super::{
    Batch, Error, Limits, TwinShape,
    tensors::{finite, known_nodes, node_list, required},
    within,
};
use crate::v1::{
    Cost, Tensor,
    cost::{Kind, When},
    tensor::Dtype,
};

/// Target points that a cost counts for in each of its frames, beside its own.
const OVERHEAD: u128 = 16;
/// Work of looking one target point up, in element substeps.
const TARGET_WORK: u128 = 20;

pub(super) fn check(costs: &[Cost], batch: &Batch, limits: &Limits) -> Result<(), Error> {
    within("the number of costs", costs.len() as u128, limits.costs, "merge target clouds")?;
    let mut names = HashSet::new();
    for (i, cost) in costs.iter().enumerate() {
        let field = |part: &str| format!("costs[{i}].{part}");
        let name = if cost.name.is_empty() { format!("cost{i}") } else { cost.name.clone() };
        if name.len() as u64 > limits.name_bytes || name.chars().any(char::is_control) {
            let fault = format!("is longer than {} bytes or not printable", limits.name_bytes);
            return Err(Error::field(field("name"), fault));
        }
        if let Some(name) = names.replace(name) {
            let fault = format!("is `{name}`, which an earlier cost has: names must differ");
            return Err(Error::field(field("name"), fault));
        }
        if let Some(weight) = cost.weight
            && !(weight as f32).is_finite()
        {
            let fault = format!("is {weight}: it must be finite in single precision, 1 say");
            return Err(Error::field(field("weight"), fault));
        }
        if When::try_from(cost.when).is_err() {
            let fault =
                format!("has the unknown value {}: use LAST_FRAME or EVERY_FRAME", cost.when);
            return Err(Error::field(field("when"), fault));
        }
        kind(cost.kind.as_ref(), field)?;
    }
    within(
        "the number of target points over all frames of all costs",
        targets(costs, batch),
        limits.targets,
        "thin the targets out, or count them in the last frame only",
    )
}

/// Target points over all frames of all costs, with the overhead of each.
pub(in crate::rollout) fn targets(costs: &[Cost], batch: &Batch) -> u128 {
    costs.iter().map(|cost| (points(cost) + OVERHEAD) * frames(cost, batch)).sum()
}

pub(super) fn check_for(costs: &[Cost], twin: &TwinShape) -> Result<(), Error> {
    for (i, cost) in costs.iter().enumerate() {
        if let Some(Kind::Keypoints(k)) = &cost.kind
            && let Some(nodes) = &k.nodes
        {
            known_nodes(nodes, &format!("costs[{i}].keypoints.nodes"), twin.nodes)?;
        }
    }
    Ok(())
}

/// Work of the costs of one instance, in element substeps.
pub(super) fn work(costs: &[Cost], batch: &Batch) -> u128 {
    costs.iter().map(|cost| points(cost).max(1) * frames(cost, batch) * TARGET_WORK).sum()
}

fn kind(kind: Option<&Kind>, field: impl Fn(&str) -> String) -> Result<(), Error> {
    match kind {
        None => {
            let fault = "is missing: give target_cloud, keypoints or smoothness";
            Err(Error::field(field("kind"), fault))
        }
        Some(Kind::TargetCloud(cloud)) => {
            point_list(cloud.points.as_ref(), &field("target_cloud.points")).map(drop)
        }
        Some(Kind::Keypoints(keypoints)) => {
            let nodes = node_list(keypoints.nodes.as_ref(), &field("keypoints.nodes"))?;
            let targets = field("keypoints.targets");
            let count = point_list(keypoints.targets.as_ref(), &targets)?;
            if nodes.shape != [count] {
                let fault = format!("has {count} points for {} nodes", nodes.shape[0]);
                return Err(Error::field(targets, fault));
            }
            Ok(())
        }
        Some(Kind::Smoothness(_)) => Ok(()),
        Some(_) => Err(Error::field(field("kind"), "is not served yet")),
    }
}

/// Number of points of a list that is not empty.
fn point_list(tensor: Option<&Tensor>, field: &str) -> Result<u64, Error> {
    let (tensor, shape) = required(tensor, field, Dtype::Float32)?;
    match shape[..] {
        [count, 3] if count > 0 => finite(tensor, field).map(|()| count),
        _ => Err(Error::field(field, format!("has shape {shape:?}, not [M, 3] with M >= 1"))),
    }
}

/// Number of target points.
fn points(cost: &Cost) -> u128 {
    let tensor = match &cost.kind {
        Some(Kind::TargetCloud(cloud)) => cloud.points.as_ref(),
        Some(Kind::Keypoints(keypoints)) => keypoints.targets.as_ref(),
        Some(_) | None => None,
    };
    tensor.and_then(|t| t.shape.first()).map_or(0, |n| u128::from(*n))
}

/// Number of frames in which a cost counts.
fn frames(cost: &Cost, batch: &Batch) -> u128 {
    if cost.when() == When::EveryFrame { u128::from(batch.frames) } else { 1 }
}
