//! The reply to a batch of plans as a planner reads it.

use bendtwin_contract::{plan::Template, rollout::ImplausibleReason};
use bendtwin_plan::{Evaluation, Knots, Space};
use bendtwin_proto::{
    tensor::TensorError,
    v1::{RollOutResponse, Tensor},
};

use crate::error::{Error, Result};

/// Costs of a batch with their terms, strains and forces.
pub(super) struct Costs {
    pub(super) evaluation: Evaluation,
    /// Extremes of each plan, shape [B].
    extremes: Vec<Extremes>,
    /// True if a plan has grasped something, or need not.
    pub(super) has_grasped: bool,
    pub(super) names: Vec<String>,
    /// Shape [B, terms], weighted.
    pub(super) terms: Vec<f64>,
}

/// Extremes of the motion of a plan, over the members of an ensemble.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Extremes {
    /// Largest strain of the material.
    pub(super) strain: f64,
    /// Largest mean force of a grasp over a frame [N]; 0 if it is not measured.
    pub(super) force_n: f64,
    /// True if a grasp that is to take something exerts a force.
    has_grasped: bool,
}

impl Extremes {
    /// The sum of the shares of their limits by which strain and force are beyond these; of a limit of 0
    /// what is beyond it counts itself.
    fn excess(&self, strain_limit: f64, force_limit_n: f64) -> f64 {
        let beyond = |found: f64, limit: f64| {
            let unit = if limit > 0.0 { limit } else { 1.0 };
            if found > limit { (found - limit) / unit } else { 0.0 }
        };
        beyond(self.strain, strain_limit) + beyond(self.force_n, force_limit_n)
    }
}

impl Costs {
    /// Evaluations from a reply to plans of a template, each beside its space, which names every strain and
    /// force. Plans that the template refuses, or that grasp nothing where they must, count as diverged.
    pub(super) fn read<'p>(
        reply: RollOutResponse,
        plans: impl Iterator<Item = (&'p Space, &'p Knots)>,
        gradients: bool,
        template: &Template,
    ) -> Result<Self> {
        let mut costs = values::<f64>(reply.costs.as_ref(), "costs")?;
        let mut extremes = vec![Extremes::default(); costs.len()];
        let (strain_limit, refuses) = (template.strain_limit(), template.refuses());
        let force_limit_n = template.force().map_or(f64::INFINITY, |force| force.limit_n);
        let takes = template.force().and_then(|force| force.takes.as_ref());
        let members = match &reply.member_costs {
            Some(tensor) => tensor.shape.get(1).copied().unwrap_or(1).max(1),
            None => 1,
        };
        for implausible in &reply.implausible {
            let plan = usize::try_from(u64::from(implausible.instance) / members).ok();
            let Some((plan, cost)) = plan.and_then(|p| Some((p, costs.get_mut(p)?))) else {
                continue;
            };
            let (own, found) = (&mut extremes[plan], implausible.found);
            let is = |reason: ImplausibleReason| implausible.reason == reason.as_str();
            let is_within = if is(ImplausibleReason::Strain) {
                own.strain = own.strain.max(found);
                found <= strain_limit
            } else if is(ImplausibleReason::GraspForce) {
                own.force_n = own.force_n.max(found);
                let grasp = implausible.grasp.map(|grasp| grasp as usize);
                own.has_grasped |= takes.zip(grasp).is_some_and(|(of, grasp)| of.contains(&grasp));
                found <= force_limit_n
            } else {
                false
            };
            if refuses && !is_within {
                *cost = f64::INFINITY;
            }
        }
        if takes.is_some() {
            for (cost, _) in costs.iter_mut().zip(&extremes).filter(|(_, own)| !own.has_grasped) {
                *cost = f64::INFINITY;
            }
        }
        let has_grasped = takes.is_none() || extremes.iter().any(|own| own.has_grasped);
        let excess = extremes.iter().map(|own| own.excess(strain_limit, force_limit_n)).collect();
        let gradients = match gradients {
            true => by_coordinates(reply.action_gradients.as_ref(), plans, costs.len())?,
            false => Vec::new(),
        };
        let terms = match &reply.cost_terms {
            Some(tensor) => values::<f64>(Some(tensor), "cost_terms")?,
            None => Vec::new(),
        };
        let evaluation = Evaluation { costs, gradients, excess };
        Ok(Self { evaluation, extremes, has_grasped, names: reply.cost_names, terms })
    }

    /// Extremes of a plan of the batch.
    pub(super) fn extremes_of(&self, plan: usize) -> Extremes {
        self.extremes.get(plan).copied().unwrap_or_default()
    }

    /// The terms of a plan of the batch.
    pub(super) fn of(&self, plan: usize) -> Vec<f64> {
        let terms = self.names.len();
        self.terms.get(plan * terms..(plan + 1) * terms).unwrap_or_default().to_vec()
    }
}

/// d cost / d coordinates of each of `count` plans, beside its space.
fn by_coordinates<'p>(
    gradients: Option<&Tensor>,
    plans: impl Iterator<Item = (&'p Space, &'p Knots)>,
    count: usize,
) -> Result<Vec<Knots>> {
    let all: Vec<f64> =
        values::<f32>(gradients, "action_gradients")?.into_iter().map(f64::from).collect();
    if count == 0 || !all.len().is_multiple_of(count) {
        return Err(Error::Internal("gradients of a worker have another shape".to_owned()));
    }
    let rows = all.chunks_exact((all.len() / count).max(1));
    Ok(plans.zip(rows).map(|((space, plan), row)| space.gradient(plan, row)).collect())
}

fn values<T: bendtwin_proto::tensor::Element>(
    tensor: Option<&Tensor>,
    name: &'static str,
) -> Result<Vec<T>> {
    let missing = || TensorError { name: name.to_owned(), fault: "is missing".to_owned() };
    let read = tensor.ok_or_else(missing).and_then(|tensor| tensor.unpack::<T>(name));
    read.map(|(_, values)| values).map_err(|e| Error::Internal(format!("a worker's reply: {e}")))
}
