//! The reply to a batch of plans as a planner reads it.

use bendtwin_plan::{Evaluation, Knots, Space};
use bendtwin_proto::{
    tensor::TensorError,
    v1::{RollOutResponse, Tensor},
};

use crate::failure::{Error, Result};

/// Costs of a batch with their terms.
pub(super) struct Costs {
    pub(super) evaluation: Evaluation,
    pub(super) names: Vec<String>,
    /// Shape [B, terms], weighted.
    pub(super) terms: Vec<f64>,
}

impl Costs {
    /// Those of a reply to plans of a space. With `refuses` what is not plausible counts as
    /// diverged.
    pub(super) fn read(
        reply: RollOutResponse,
        plans: &[Knots],
        space: &Space,
        gradients: bool,
        refuses: bool,
    ) -> Result<Self> {
        let mut costs = values::<f64>(reply.costs.as_ref(), "costs")?;
        if refuses {
            let members = match &reply.member_costs {
                Some(tensor) => tensor.shape.get(1).copied().unwrap_or(1).max(1),
                None => 1,
            };
            for implausible in &reply.implausible {
                let plan = usize::try_from(u64::from(implausible.instance) / members);
                if let Some(cost) = plan.ok().and_then(|plan| costs.get_mut(plan)) {
                    *cost = f64::INFINITY;
                }
            }
        }
        let gradients = match gradients {
            true => by_coordinates(reply.action_gradients.as_ref(), plans, space)?,
            false => Vec::new(),
        };
        let terms = match &reply.cost_terms {
            Some(tensor) => values::<f64>(Some(tensor), "cost_terms")?,
            None => Vec::new(),
        };
        Ok(Self { evaluation: Evaluation { costs, gradients }, names: reply.cost_names, terms })
    }

    /// The terms of a plan of the batch.
    pub(super) fn of(&self, plan: usize) -> Vec<f64> {
        let terms = self.names.len();
        self.terms.get(plan * terms..(plan + 1) * terms).unwrap_or_default().to_vec()
    }
}

/// d cost / d coordinates of each plan.
fn by_coordinates(
    gradients: Option<&Tensor>,
    plans: &[Knots],
    space: &Space,
) -> Result<Vec<Knots>> {
    let all: Vec<f64> =
        values::<f32>(gradients, "action_gradients")?.into_iter().map(f64::from).collect();
    if plans.is_empty() || !all.len().is_multiple_of(plans.len()) {
        return Err(Error::Internal("gradients of a worker have another shape".to_owned()));
    }
    let rows = all.chunks_exact((all.len() / plans.len()).max(1));
    Ok(plans.iter().zip(rows).map(|(plan, row)| space.gradient(plan, row)).collect())
}

fn values<T: bendtwin_proto::tensor::Element>(
    tensor: Option<&Tensor>,
    name: &'static str,
) -> Result<Vec<T>> {
    let missing = || TensorError { name: name.to_owned(), fault: "is missing".to_owned() };
    let read = tensor.ok_or_else(missing).and_then(|tensor| tensor.unpack::<T>(name));
    read.map(|(_, values)| values).map_err(|e| Error::Internal(format!("a worker's reply: {e}")))
}
