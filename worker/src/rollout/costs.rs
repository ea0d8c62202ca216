//! Costs of a request as terms of an engine objective, one group per cost.

use std::{collections::HashSet, sync::Arc};

use bendtwin_core::Graph;
use bendtwin_engine::{Objective, PointLoss, Term, objective::WeightedTerm};
use bendtwin_proto::v1::{
    Cost,
    cost::{Keypoints, Kind, TargetCloud, When},
};

use super::{
    actions::{finite, given},
    error::Error,
};

/// Most costs of a request.
const MAX_COSTS: usize = 256;
/// Most target points over all terms and frames: they are held in memory.
const MAX_TARGETS: u128 = 8_000_000;
/// What a term counts for beside its target points: it takes memory of its own in every frame.
const TERM_OVERHEAD: u128 = 16;

/// Reads the costs of a request for rollouts of `frames` frames.
pub(super) fn read(costs: Vec<Cost>, graph: &Graph, frames: usize) -> Result<Objective, Error> {
    if costs.len() > MAX_COSTS {
        let fault = format!("has {} entries: at most {MAX_COSTS} are taken", costs.len());
        return Err(Error::field("costs", fault));
    }
    let mut groups = Vec::with_capacity(costs.len());
    let mut terms = Vec::new();
    let mut names = HashSet::new();
    let mut targets = 0u128;
    for (group, cost) in costs.into_iter().enumerate() {
        let field = |part: &str| format!("costs[{group}].{part}");
        let name = if cost.name.is_empty() { format!("cost{group}") } else { cost.name };
        if name.chars().count() > 128 {
            return Err(Error::field(field("name"), "is longer than 128 characters"));
        }
        if !names.insert(name.clone()) {
            let fault = format!("`{name}` is given twice: names must differ");
            return Err(Error::field(field("name"), fault));
        }
        let weight = cost.weight as f32;
        if !weight.is_finite() || weight == 0.0 {
            let fault = format!("is {}: it must be finite and not zero, 1 say", cost.weight);
            return Err(Error::field(field("weight"), fault));
        }
        let first = match When::try_from(cost.when) {
            Ok(When::Unspecified | When::LastFrame) => frames,
            Ok(When::EveryFrame) => 1,
            Err(_) => {
                let fault = format!("has the unknown value {}", cost.when);
                return Err(Error::field(field("when"), fault));
            }
        };
        let Some(kind) = cost.kind else {
            let fault = "is missing: give target_cloud, keypoints or smoothness";
            return Err(Error::field(field("kind"), fault));
        };
        let (term, points) = term(kind, graph)?;
        targets += (points as u128 + TERM_OVERHEAD) * (frames - first + 1) as u128;
        if targets > MAX_TARGETS {
            return Err(Error::TooLarge {
                what: "the number of target points over all frames of all costs",
                asked: targets,
                limit: MAX_TARGETS,
                advice: "thin the target out, or count it in the last frame only",
            });
        }
        let at = |frame| WeightedTerm { frame, weight, group, term: term.clone() };
        terms.extend((first..=frames).map(at));
        groups.push(name);
    }
    // Stable: within a frame the request's order stays, so sums are reproducible.
    terms.sort_by_key(|t| t.frame);
    Ok(Objective { groups, terms: Arc::new(terms) })
}

/// The term, and how many target points it has.
fn term(kind: Kind, graph: &Graph) -> Result<(Term, usize), Error> {
    match kind {
        Kind::TargetCloud(TargetCloud { points }) => {
            const FIELD: &str = "target_cloud.points";
            let targets = points_2d(given(points, FIELD)?, FIELD)?;
            let count = targets.len();
            Ok((Term::Chamfer { targets }, count))
        }
        Kind::Keypoints(Keypoints { nodes, targets, squared }) => {
            const NODES: &str = "keypoints.nodes";
            const TARGETS: &str = "keypoints.targets";
            let nodes = self::nodes(given(nodes, NODES)?, NODES, graph.node_count())?;
            let targets = points_2d(given(targets, TARGETS)?, TARGETS)?;
            if nodes.len() != targets.len() {
                let fault = format!("has {} points for {} nodes", targets.len(), nodes.len());
                return Err(Error::field(TARGETS, fault));
            }
            let loss = if squared { PointLoss::SquaredDistance } else { PointLoss::Distance };
            let count = targets.len();
            Ok((Term::Track { nodes, targets, loss }, count))
        }
        Kind::Smoothness(_) => Ok((Term::Acceleration, 0)),
    }
}

/// A non-empty list of points.
fn points_2d(
    tensor: bendtwin_proto::v1::Tensor,
    field: &'static str,
) -> Result<Vec<bendtwin_core::Point>, Error> {
    let (dims, points) = tensor.unpack_points(field)?;
    if dims.len() != 1 || points.is_empty() {
        let fault = format!("has shape {:?}, not [M, 3] with M >= 1", tensor.shape);
        return Err(Error::field(field, fault));
    }
    finite(field, points.as_flattened())?;
    Ok(points)
}

/// A non-empty list of node indices.
pub(super) fn nodes(
    tensor: bendtwin_proto::v1::Tensor,
    field: &'static str,
    node_count: usize,
) -> Result<Vec<u32>, Error> {
    let (dims, nodes) = tensor.unpack::<u32>(field)?;
    if dims.len() != 1 || nodes.is_empty() {
        return Err(Error::field(field, format!("has shape {dims:?}, not [M] with M >= 1")));
    }
    match nodes.iter().find(|n| **n as usize >= node_count) {
        Some(n) => {
            let fault = format!("names node {n}, the twin has {node_count} (counted from 0)");
            Err(Error::field(field, fault))
        }
        None => Ok(nodes),
    }
}
