//! Other starts of a fit that fit nearly as well as the chosen one: the twin's members.

use bendtwin_core::{Twin, twin::Member};

use super::Run;
use crate::{Error, refine::Refinement};

/// Largest loss of a member, over that of the twin: what fits worse is no explanation of the capture.
const WORST: f64 = 3.0;

impl Run<'_> {
    /// Adds the members to a twin: the best of the other starts of its model, by the loss that the
    /// choice was made by, which is kept for all of them. Where frames were held back, the members
    /// were refined without these.
    pub(super) fn add_members(
        &mut self,
        twin: &mut Twin,
        chosen: usize,
        refinement: &Refinement<'_>,
    ) -> Result<(), Error> {
        let most = self.task.settings.search.members as usize;
        let losses = match self.choice(chosen, refinement) {
            Some(choice) if most > 0 => choice.losses,
            _ => return Ok(()),
        };
        let bending = self.models[chosen].bending;
        let of_kind: Vec<usize> =
            (0..self.models.len()).filter(|&m| self.models[m].bending == bending).collect();
        let own = of_kind.iter().zip(&losses).find(|(m, _)| **m == chosen).and_then(|(_, l)| *l);
        let Some(own) = own else { return Ok(()) };
        let mut others: Vec<(usize, f64)> = of_kind
            .into_iter()
            .zip(losses)
            .filter_map(|(model, loss)| Some((model, loss?)))
            .filter(|&(model, loss)| model != chosen && loss <= WORST * own)
            .collect();
        others.sort_by(|a, b| a.1.total_cmp(&b.1));
        others.truncate(most);
        let mut members = Vec::with_capacity(others.len());
        for (model, loss) in others {
            let mut fit = self.other_fit(model, refinement)?;
            fit.provenance.loss = Some(loss);
            members.extend(Member::of(&fit, twin));
        }
        if !members.is_empty() {
            twin.provenance.loss = Some(own);
            twin.members = members;
        }
        Ok(())
    }

    /// The twin of a start that is not kept.
    fn other_fit(&mut self, model: usize, refinement: &Refinement<'_>) -> Result<Twin, Error> {
        let (job, refined_from) = (self.job, self.refined_from.clone());
        let generations = self.generations;
        if let Some(run) = refinement.runs.iter().find(|r| r.model == model) {
            let fit = &self.models[model];
            return fit.twin(job, self.task, refined_from.as_deref(), generations, run);
        }
        let task = self.validation.map_or(self.task, |v| &v.shorter);
        let fit = &mut self.models[model];
        let (run, _) = fit.begin_run(model, task, &*job.backend)?;
        fit.twin(job, task, refined_from.as_deref(), generations, &run)
    }
}
