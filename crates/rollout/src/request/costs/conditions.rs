//! Conditions of success: costs whose values after the last frame are compared with thresholds. They are
//! terms of the engine in separate groups, behind the groups of the costs, so that neither costs nor
//! gradients depend on them.

use std::sync::Arc;

use bendtwin_engine::{Objective, backend::Rollout, objective::WeightedTerm};

use super::{Costs, measure::Measure};
use crate::reply::Span;

/// A condition of the state after the last frame.
#[derive(Debug)]
pub(super) struct Condition {
    /// Group of its cost.
    pub(super) group: usize,
    /// Largest value, without weight, that meets it.
    pub(super) at_most: f64,
    pub(super) measure: Arc<Measure>,
}

impl Costs {
    /// Number of groups of objectives that measure conditions.
    pub(crate) fn groups(&self) -> usize {
        self.names.len() + self.conditions.len()
    }

    /// An objective of costs over a span with conditions, which count in the last frame of all.
    pub(super) fn with_conditions(&self, action: usize, span: Span, of: Objective) -> Objective {
        let Objective { mut groups, terms } = of;
        groups.extend(self.conditions.iter().map(|condition| self.names[condition.group].clone()));
        if span.to < self.frames || self.conditions.is_empty() {
            return Objective { groups, terms };
        }
        let mut terms = Arc::unwrap_or_clone(terms);
        for (condition, group) in self.conditions.iter().zip(self.names.len()..) {
            let frame = span.frames();
            if let Some(term) = condition.measure.term(action, self.frames) {
                terms.push(WeightedTerm { frame, weight: 1.0, group, term });
            }
        }
        Objective { groups, terms: Arc::new(terms) }
    }

    /// For each rollout 1 if it meets all conditions, otherwise 0; none without conditions.
    pub(crate) fn successes(&self, rollouts: &[Rollout]) -> Option<Vec<f32>> {
        let meets = |rollout: &Rollout| {
            let mut values = rollout.group_costs.iter().skip(self.names.len());
            let met = |c: &Condition| values.next().is_some_and(|value| *value <= c.at_most);
            rollout.diverged.is_none() && self.conditions.iter().all(met)
        };
        let values = rollouts.iter().map(|rollout| f32::from(u8::from(meets(rollout))));
        (!self.conditions.is_empty()).then(|| values.collect())
    }

    /// Costs of groups, rows of all groups, without those of conditions.
    pub(crate) fn without_conditions<'a>(
        &self,
        values: &'a [f64],
    ) -> impl Iterator<Item = &'a f64> + use<'a> {
        let names = self.names.len();
        values.chunks_exact(self.groups().max(1)).flat_map(move |row| &row[..names])
    }
}
