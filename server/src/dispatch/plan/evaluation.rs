//! The reply to a batch of plans as a planner reads it.

use bendtwin_contract::{plan::Template, rollout::ImplausibleReason};
use bendtwin_plan::{Evaluation, Knots, Space};
use bendtwin_proto::{
    tensor::TensorError,
    v1::{RollOutResponse, Tensor},
};

use crate::error::{Error, Result};

/// Costs of a batch with their terms and strains.
pub(super) struct Costs {
    pub(super) evaluation: Evaluation,
    /// Largest strain of the material in each plan, shape [B].
    strains: Vec<f64>,
    pub(super) names: Vec<String>,
    /// Shape [B, terms], weighted.
    pub(super) terms: Vec<f64>,
}

impl Costs {
    /// Evaluations from a reply to plans of a template in a space, which names every strain. Plans
    /// that the template refuses count as diverged.
    pub(super) fn read(
        reply: RollOutResponse,
        plans: &[Knots],
        space: &Space,
        gradients: bool,
        template: &Template,
    ) -> Result<Self> {
        let mut costs = values::<f64>(reply.costs.as_ref(), "costs")?;
        let mut strains = vec![0.0_f64; costs.len()];
        let (limit, refuses) = (template.strain_limit(), template.refuses());
        let members = match &reply.member_costs {
            Some(tensor) => tensor.shape.get(1).copied().unwrap_or(1).max(1),
            None => 1,
        };
        for implausible in &reply.implausible {
            let plan = usize::try_from(u64::from(implausible.instance) / members).ok();
            let Some((plan, cost)) = plan.and_then(|p| Some((p, costs.get_mut(p)?))) else {
                continue;
            };
            let is_strain = implausible.reason == ImplausibleReason::Strain.as_str();
            if is_strain {
                strains[plan] = strains[plan].max(implausible.found);
            }
            if refuses && !(is_strain && implausible.found <= limit) {
                *cost = f64::INFINITY;
            }
        }
        let excess = strains.iter().map(|strain| (strain - limit).max(0.0)).collect();
        let gradients = match gradients {
            true => by_coordinates(reply.action_gradients.as_ref(), plans, space)?,
            false => Vec::new(),
        };
        let terms = match &reply.cost_terms {
            Some(tensor) => values::<f64>(Some(tensor), "cost_terms")?,
            None => Vec::new(),
        };
        let evaluation = Evaluation { costs, gradients, excess };
        Ok(Self { evaluation, strains, names: reply.cost_names, terms })
    }

    /// Largest strain of the material in a plan of the batch.
    pub(super) fn strain_of(&self, plan: usize) -> f64 {
        self.strains.get(plan).copied().unwrap_or(0.0)
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
