//! Other starts of a fit that fit nearly as well as the chosen one: the twin's members.

use bendtwin_core::{Twin, quality::Choice, twin::Member};

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
        choice: &Choice,
        refinement: &Refinement<'_>,
    ) -> Result<(), Error> {
        let most = self.task.settings.search.members as usize;
        let start = choice.start as usize;
        let Some(own) = choice.losses.get(start).copied().flatten() else { return Ok(()) };
        let losses = (chosen - start..).zip(&choice.losses);
        let mut others: Vec<(usize, f64)> = losses
            .filter_map(|(model, loss)| Some((model, (*loss)?)))
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
        if let Some(run) = refinement.runs.iter().find(|r| r.model == model) {
            return self.twin_of(&self.models[model], self.task, run);
        }
        let task = self.validation.map_or(self.task, |v| &v.shorter);
        let (run, _) = self.models[model].begin_run(model, task, &*self.job.backend)?;
        self.twin_of(&self.models[model], task, &run)
    }
}
