//! Actions under several sets of parameters, and the statistic of their costs.

use bendtwin_core::Point;
use bendtwin_engine::backend::Gradient;
use bendtwin_proto::v1::{Ensemble as Wire, RollOutResponse, Tensor, ensemble as wire};

/// The members under which each action is simulated.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Ensemble {
    /// Number of members E.
    pub(crate) members: usize,
    /// Number of the worst members whose mean counts.
    worst: usize,
    /// True if costs by member are returned.
    is_asked_for: bool,
    /// Weights of the members in their mean motion, shape [E], if costs and arrays are of that.
    pub(crate) weights: Option<Vec<f64>>,
}

impl Ensemble {
    /// The ensemble of a checked request: one member by default. In their mean motion members on
    /// the fits of a twin have the weights of `fits`, any others equal ones.
    pub(crate) fn read(wire: Option<Wire>, fits: Option<Vec<f64>>) -> Self {
        let Some(wire) = wire else {
            return Self { members: 1, worst: 1, is_asked_for: false, weights: None };
        };
        let members = (wire.members as usize).max(1);
        let is_mean = wire.statistic() == wire::Statistic::MeanPrediction;
        let weights = is_mean.then(|| fits.unwrap_or_else(|| vec![1.0; members]));
        let worst = match wire.statistic() {
            wire::Statistic::Unspecified
            | wire::Statistic::Mean
            | wire::Statistic::MeanPrediction => members,
            wire::Statistic::Worst => 1,
            // A share of a third of three members is one of them, despite rounding.
            wire::Statistic::Cvar => (wire.share * members as f64 - 1e-9).ceil() as usize,
        };
        Self { members, worst: worst.clamp(1, members), is_asked_for: true, weights }
    }

    /// Shares of the members' costs in the statistic, which add up to 1. Of equal members the first
    /// count as worse.
    fn shares(&self, costs: &[f64]) -> Vec<f64> {
        let mut order: Vec<usize> = (0..costs.len()).collect();
        order.sort_by(|a, b| costs[*b].total_cmp(&costs[*a]));
        let mut shares = vec![0.0; costs.len()];
        let counted = self.worst.min(costs.len());
        order.iter().take(counted).for_each(|i| shares[*i] = 1.0 / counted as f64);
        shares
    }

    /// Turns costs and successes by member into those by action, in a part of a reply; those of the mean
    /// motion are to take their place.
    pub(crate) fn fold(&self, part: &mut RollOutResponse) {
        if !self.is_asked_for {
            return;
        }
        part.first_instance /= self.members as u32;
        let members = f64s(part.costs.as_ref());
        let terms = f64s(part.cost_terms.as_ref());
        let (width, actions) = (part.cost_names.len(), members.len() / self.members);
        let mut costs = Vec::with_capacity(actions);
        let mut folded = Vec::with_capacity(actions * width);
        for (action, own) in members.chunks_exact(self.members).enumerate() {
            let shares = self.shares(own);
            costs.push(weighted(&shares, |m| own[m]));
            let row = |m: usize| (action * self.members + m) * width;
            folded.extend((0..width).map(|t| weighted(&shares, |m| terms[row(m) + t])));
        }
        part.costs = Some(Tensor::pack(&[actions], &costs));
        part.cost_terms = Some(Tensor::pack(&[actions, width], &folded));
        part.member_costs = Some(Tensor::pack(&[actions, self.members], &members));
        part.successes = part.successes.take().and_then(|of| self.shares_of_success(&of));
    }

    /// Share of the members of each action that succeed.
    fn shares_of_success(&self, members: &Tensor) -> Option<Tensor> {
        let (_, members) = members.unpack::<f32>("successes").ok()?;
        let share = |own: &[f32]| own.iter().sum::<f32>() / own.len() as f32;
        let shares: Vec<f32> = members.chunks_exact(self.members).map(share).collect();
        Some(Tensor::pack(&[shares.len()], &shares))
    }

    /// The gradient of the statistic from those of the members of an action, as a gradient whose
    /// other fields are those of the worst.
    pub(crate) fn gradient(&self, mut members: Vec<Gradient>) -> Gradient {
        if self.members == 1 {
            return members.pop().unwrap_or_default();
        }
        let costs: Vec<f64> = members.iter().map(|g| g.loss.total).collect();
        sum(members, &self.shares(&costs))
    }
}

/// The sum of shares of gradients, those above 0, as a gradient whose other fields are those of the
/// first of them.
pub(crate) fn sum(gradients: Vec<Gradient>, shares: &[f64]) -> Gradient {
    let mut sum: Option<Gradient> = None;
    for (gradient, share) in gradients.into_iter().zip(shares).filter(|(_, share)| **share > 0.0) {
        match &mut sum {
            None => {
                let mut first = gradient;
                each(&mut first, |x| *x = (f64::from(*x) * share) as f32);
                first.norms.iter_mut().for_each(|norm| *norm *= share);
                sum = Some(first);
            }
            Some(sum) => add(sum, &gradient, *share),
        }
    }
    sum.unwrap_or_default()
}

/// Sum of the values with a share; others may be infinite.
fn weighted(shares: &[f64], value: impl Fn(usize) -> f64) -> f64 {
    let counted = shares.iter().enumerate().filter(|(_, share)| **share > 0.0);
    counted.map(|(i, share)| share * value(i)).sum::<f64>() + 0.0
}

fn f64s(tensor: Option<&Tensor>) -> Vec<f64> {
    tensor.and_then(|t| t.unpack("costs").ok()).map(|(_, values)| values).unwrap_or_default()
}

/// Numbers of a gradient by what a request gives, in one order.
fn each(gradient: &mut Gradient, mut f: impl FnMut(&mut f32)) {
    let points = |points: &mut Vec<Point>, f: &mut dyn FnMut(&mut f32)| {
        points.iter_mut().flatten().for_each(f);
    };
    points(&mut gradient.controls, &mut f);
    gradient.poses.iter_mut().flatten().flatten().for_each(&mut f);
    gradient.rolls.iter_mut().for_each(&mut f);
    if let Some(initial) = &mut gradient.initial {
        points(&mut initial.positions, &mut f);
        points(&mut initial.velocities, &mut f);
        initial.twists.iter_mut().for_each(&mut f);
    }
}

/// Adds a share of another gradient, number by number.
fn add(sum: &mut Gradient, other: &Gradient, share: f64) {
    let mut values = Vec::new();
    each(&mut other.clone(), |x| values.push(*x));
    let mut values = values.into_iter();
    each(sum, |x| {
        if let Some(value) = values.next() {
            *x += (f64::from(value) * share) as f32;
        }
    });
    for (sum, norm) in sum.norms.iter_mut().zip(&other.norms) {
        *sum += norm * share;
    }
}

#[cfg(test)]
mod tests;
