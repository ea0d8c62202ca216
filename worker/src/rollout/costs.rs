//! Costs of a request as terms of an engine objective, one group per cost.

use std::sync::Arc;

use bendtwin_engine::{Objective, PointLoss, Term, objective::WeightedTerm};
use bendtwin_proto::v1::{
    Cost, Tensor,
    cost::{Keypoints, Kind, TargetCloud, When},
};

use super::error::Error;

/// Reads the costs of a checked request for rollouts of `frames` frames. A cost of weight 0 has a
/// group, in which nothing is added up.
pub(super) fn read(costs: Vec<Cost>, frames: usize) -> Result<Objective, Error> {
    let mut groups = Vec::with_capacity(costs.len());
    let mut terms = Vec::new();
    for (group, cost) in costs.into_iter().enumerate() {
        let first = match cost.when() {
            When::Unspecified | When::LastFrame => frames,
            When::EveryFrame | When::SoftMin => 1,
        };
        let weight = cost.weight.unwrap_or(1.0) as f32;
        groups.push(if cost.name.is_empty() { format!("cost{group}") } else { cost.name });
        if weight == 0.0 {
            continue;
        }
        let term = term(cost.kind, group)?;
        let at = |frame| WeightedTerm { frame, weight, group, term: term.clone() };
        terms.extend((first..=frames).map(at));
    }
    // Stable: within a frame the request's order stays, so sums are reproducible.
    terms.sort_by_key(|t| t.frame);
    Ok(Objective { groups, terms: Arc::new(terms) })
}

fn term(kind: Option<Kind>, group: usize) -> Result<Term, Error> {
    let field = |part: &str| format!("costs[{group}].{part}");
    match kind {
        None => Err(Error::field(field("kind"), "is missing")),
        Some(Kind::TargetCloud(TargetCloud { points })) => {
            let (_, targets) =
                points.unwrap_or_default().unpack_points(&field("target_cloud.points"))?;
            Ok(Term::Chamfer { targets })
        }
        Some(Kind::Keypoints(Keypoints { nodes, targets, squared })) => {
            let nodes = unpack(nodes, &field("keypoints.nodes"))?;
            let (_, targets) =
                targets.unwrap_or_default().unpack_points(&field("keypoints.targets"))?;
            let loss = if squared { PointLoss::SquaredDistance } else { PointLoss::Distance };
            Ok(Term::Track { nodes, targets, loss })
        }
        Some(Kind::Smoothness(_)) => Ok(Term::Acceleration),
        Some(_) => Err(Error::field(field("kind"), "is not served yet")),
    }
}

fn unpack(indices: Option<Tensor>, field: &str) -> Result<Vec<u32>, Error> {
    Ok(indices.unwrap_or_default().unpack(field)?.1)
}
