//! The refinement as a stage of a fit: passes until all models are refined, first without the frames
//! that are held back, where several starts are to choose from.

use std::{ops::Range, time::Instant};

use bendtwin_core::{Stage, Twin, quality::Choice};

use super::{Run, checkpoint::ModelFitState, model_fit::ModelFit, warnings};
use crate::{
    Error,
    progress::ModelProgress,
    refine::{OptimizerRun, Refinement},
    task::Task,
};

/// Pass whose duration determines how many fit into a time limit.
const MEASURED_PASS: u32 = 2;

/// A model whose refinement is done.
pub(super) struct RefinedModel {
    pub(super) twin: Twin,
    pub(super) warnings: Vec<String>,
    pub(super) choice: Option<Choice>,
    /// True if the time limit left too few passes.
    pub(super) is_cut: bool,
}

impl<'a> Run<'a> {
    /// Runs passes until all models are refined; returns the start of each kind of model that is
    /// kept. Where frames are held back, all starts are refined without them first.
    pub(super) fn refine(&mut self) -> Result<Vec<RefinedModel>, Error> {
        let mut refinement = self.begin_refinement()?;
        self.pass(&mut refinement)?;
        if let Some(validation) = self.validation.filter(|_| self.chosen.is_empty()) {
            self.choose(validation, &refinement)?;
            self.keep()?;
            refinement = self.begin_refinement()?;
            self.pass(&mut refinement)?;
        }
        let mut finished = Vec::new();
        for kind in self.kinds() {
            let own = refinement.runs.iter().filter(|r| kind.contains(&r.model));
            let best = own.min_by(|a, b| a.state.best.loss.total_cmp(&b.state.best.loss));
            let Some(best) = best else { continue };
            let model = &self.models[best.model];
            let choice = self.choice(best.model, &refinement);
            let mut twin = self.twin_of(model, self.task, best)?;
            let is_cut = !best.state.has_ended && best.state.passes < self.task.passes();
            let warnings = warnings::of_fit(self.task, model);
            if let Some(choice) = &choice {
                self.add_members(&mut twin, best.model, choice, &refinement)?;
            }
            finished.push(RefinedModel { twin, warnings, choice, is_cut });
        }
        Ok(finished)
    }

    /// The twin of a model at its run's best parameters, without its quality.
    pub(super) fn twin_of(
        &self,
        model: &ModelFit,
        task: &Task<'_>,
        run: &OptimizerRun<'_>,
    ) -> Result<Twin, Error> {
        model.twin(self.job, task, self.refined_from, self.generations, run)
    }

    /// Runs passes until these runs are done.
    fn pass(&mut self, refinement: &mut Refinement<'_>) -> Result<(), Error> {
        let before = self.passes_before();
        while !refinement.runs.iter().all(|r| r.state.is_done()) {
            self.check_cancelled()?;
            let began = Instant::now();
            refinement.pass()?;
            self.limit_passes(refinement, began.elapsed().as_secs_f64());
            for run in &refinement.runs {
                self.models[run.model].record_run(&run.state);
            }
            self.keep()?;
            let passes = refinement.runs.iter().map(|r| r.state.pass).max().unwrap_or(0);
            let mut preview = self.preview_refinement(refinement, before + passes);
            for run in &mut refinement.runs {
                let model = self.models[run.model].name.clone();
                self.report(ModelProgress {
                    preview: preview.take_if(|p| p.variant == model),
                    model,
                    stage: Stage::Refine,
                    iteration: before + passes,
                    loss: Some(run.state.loss),
                    best_loss: Some(run.state.best.loss),
                    note: run.note.take(),
                });
            }
        }
        Ok(())
    }

    /// Makes the refinement as long as the time limit allows, from the time of a pass.
    fn limit_passes(&mut self, refinement: &mut Refinement<'_>, took_s: f64) {
        let Some(limit) = &self.limit else { return };
        let Some((done, _)) = refinement.next_pass() else { return };
        // The rate may fall over all passes, so their number is fixed once it is known; the first
        // pass may be slow for other reasons.
        let (before, planned) = (self.passes_before(), self.current_task().passes());
        // Those of the stage after this one take their part of the time.
        let is_last = self.is_last_stage();
        let later = if is_last { 0 } else { self.task.passes() };
        let passes = match done {
            MEASURED_PASS => {
                let fitting = limit.passes(planned + later, done, took_s);
                (u64::from(fitting) * u64::from(planned) / u64::from((planned + later).max(1)))
                    as u32
            }
            _ if limit.is_over(took_s) => done,
            _ => return,
        };
        let passes = passes.max(done);
        refinement.runs.iter_mut().for_each(|r| r.state.passes = r.state.passes.min(passes));
        if is_last {
            self.estimator.set_passes(before + passes);
        }
    }

    /// Passes that were planned before those of the current stage.
    fn passes_before(&self) -> u32 {
        self.validation.filter(|_| self.is_last_stage()).map_or(0, |v| v.shorter.passes())
    }

    /// True if the models in refinement are those that are kept: no choice among starts is left.
    fn is_last_stage(&self) -> bool {
        self.validation.is_none() || !self.chosen.is_empty()
    }

    /// The refinement of all models whose search found something to refine, of the chosen ones once
    /// there are any. Of several starts some may have found nothing, but not all of the same kind of
    /// model.
    fn begin_refinement(&mut self) -> Result<Refinement<'a>, Error> {
        let (task, backend) = (self.current_task(), &*self.job.backend);
        let (mut runs, mut from_search, mut nothing) = (Vec::new(), false, None);
        let takes_part =
            |model: usize| self.chosen.is_empty() || self.chosen.iter().any(|c| c.model == model);
        for (index, model) in self.models.iter_mut().enumerate().filter(|(m, _)| takes_part(*m)) {
            let is_searched = !matches!(model.state, ModelFitState::Refine { .. });
            match model.begin_run(index, task, backend) {
                Ok(run) => {
                    from_search |= is_searched;
                    runs.push(run);
                }
                Err(Error::NothingStable(why)) => nothing = Some(Error::NothingStable(why)),
                Err(e) => return Err(e),
            }
        }
        let has_run = |kind: &Range<usize>| runs.iter().any(|(r, _)| kind.contains(&r.model));
        if let (Some(nothing), false) = (nothing, self.kinds().iter().all(has_run)) {
            return Err(nothing);
        }
        let mut refinement = Refinement::new(task, runs, backend, self.cancel)?;
        if from_search {
            refinement.begin()?;
        }
        Ok(refinement)
    }
}
