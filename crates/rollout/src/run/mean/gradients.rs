//! Gradients of costs of mean motions. By the chain rule they are the sum of what the members'
//! adjoints make of the cost's gradient by positions, each with its weight.

use bendtwin_engine::{
    backend::{Gradient, Instance, Outputs, Rollout},
    world::Pose,
};

use super::{Gauges, Members, seeds::seeded};
use crate::{cut, error::Error, reply::Gradients, request::ensemble, run::execute::Execution};

/// The adjoint runs of an action.
struct Runs {
    count: usize,
    /// Gradient by poses that colliders have in costs, which no member's motion is in.
    poses: Vec<Pose>,
}

impl Execution<'_> {
    /// Gradients of the costs of actions' mean motions, of which rollouts are needed where costs have
    /// soft minima; `indices` are their members.
    pub(crate) fn mean_gradients(
        &self,
        indices: &[usize],
        means: &[Rollout],
        weights: &[f64],
    ) -> Result<Gradients, Error> {
        let members = self.plan.ensemble.members;
        let mut gradients = Gradients::default();
        let mut gauges = Gauges::default();
        // All members of an action together.
        let at_once = (self.plan.prepared / members).max(1) * members;
        for run in cut::runs(0..indices.len(), at_once) {
            let means = means.get(run.start / members..).unwrap_or_default();
            let indices = &indices[run];
            let batch = self.batch(indices);
            let (runs, adjoints) = self.adjoints(indices, &batch, means, weights, &mut gauges)?;
            let results = match adjoints.is_empty() {
                true => Vec::new(),
                false => {
                    let request = self.gradient_request(&adjoints);
                    self.backend.gradients(&adjoints, &request, self.cancel)?
                }
            };
            let mut results = results.into_iter();
            for (action, of) in runs.into_iter().enumerate() {
                let own: Vec<Gradient> = results.by_ref().take(of.count).collect();
                let mut result = ensemble::sum(own, &vec![1.0; of.count]);
                add_poses(&mut result.poses, &of.poses);
                let first = action * members;
                self.plan.costs.add_gradient(&batch[first].controls, &mut result);
                self.push_gradient(indices[first], result, &mut gradients);
            }
        }
        Ok(gradients)
    }

    /// The runs backward of the members of a batch, from the gradients of the costs of their means.
    fn adjoints(
        &self,
        indices: &[usize],
        batch: &[Instance],
        means: &[Rollout],
        weights: &[f64],
        gauges: &mut Gauges,
    ) -> Result<(Vec<Runs>, Vec<Instance>), Error> {
        let (plan, members) = (self.plan, self.plan.ensemble.members);
        let nothing = || Runs { count: 0, poses: Vec::new() };
        if plan.costs.need_no_gradient() {
            return Ok(((0..batch.len() / members).map(|_| nothing()).collect(), Vec::new()));
        }
        let outputs = Outputs { every: 1, initial: true, ..Outputs::NONE };
        let rollouts = self.backend.roll_out(batch, &outputs, self.cancel)?;
        let (mut runs, mut adjoints) = (Vec::new(), Vec::new());
        let actions = batch.chunks_exact(members).zip(rollouts.chunks_exact(members)).enumerate();
        for (action, (batch, rollouts)) in actions {
            let mut all = Members::default();
            for ((instance, rollout), weight) in batch.iter().zip(rollouts).zip(weights) {
                all.add(instance, Some(rollout), *weight);
            }
            let whole = || rollouts.iter().zip(weights).filter(|(r, _)| r.diverged.is_none());
            let sum: f64 = whole().map(|(_, weight)| weight).sum();
            let Some(mean) = all.mean() else {
                // The engine finds again that the first diverges, whose gradient is no number.
                adjoints.push(batch[0].clone());
                runs.push(Runs { count: 1, ..nothing() });
                continue;
            };
            let objective = match means.get(action).filter(|_| plan.costs.have_soft_minima()) {
                Some(at) => plan.costs.tangent(plan.action(indices[action * members]), at),
                None => batch[0].objective.clone(),
            };
            let of = Instance { objective, ..batch[0].clone() };
            let gradient = gauges.of(&of).gradient(&of, &mean.positions);
            let nodes = plan.twin().graph.node_count();
            for ((instance, rollout), weight) in batch.iter().zip(rollouts).zip(weights) {
                if rollout.diverged.is_none() {
                    let (path, seeds) = (&rollout.positions, &gradient.positions);
                    let objective = seeded(path, seeds, nodes, weight / sum);
                    adjoints.push(Instance { objective, ..instance.clone() });
                }
            }
            runs.push(Runs { count: whole().count(), poses: gradient.poses });
        }
        Ok((runs, adjoints))
    }
}

/// Adds a gradient by poses to one that was asked for.
fn add_poses(sum: &mut [Pose], more: &[Pose]) {
    let numbers = sum.as_flattened_mut().as_flattened_mut().iter_mut();
    numbers.zip(more.as_flattened().as_flattened()).for_each(|(sum, x)| *sum += x);
}
