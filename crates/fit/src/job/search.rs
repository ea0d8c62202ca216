//! The search as a stage of a fit: generations until all models have had theirs.

use std::time::Instant;

use bendtwin_core::Stage;
use bendtwin_graph::{Connectivity, connect_with_notes};

use super::{Run, checkpoint::ModelFitState};
use crate::{
    Error,
    progress::ModelProgress,
    search::{Search, Searcher},
};

impl Run<'_> {
    /// Runs generations until all searches are done. Models that are past the search stay as they
    /// are.
    pub(super) fn search(&mut self) -> Result<(), Error> {
        self.report_pieces();
        let mut search = Search::new(self.current_task());
        loop {
            self.check_cancelled()?;
            let (began, generations) = (Instant::now(), u64::from(self.generations));
            let mut open: Vec<_> = self
                .models
                .iter_mut()
                .enumerate()
                .filter_map(|(model, fit)| match &mut fit.state {
                    ModelFitState::Search(strategy) if strategy.generation() < generations => {
                        Some(Searcher { model, space: &fit.space, strategy })
                    }
                    _ => None,
                })
                .collect();
            if open.is_empty() {
                return Ok(());
            }
            let results = search.generation(&mut open, &*self.job.backend, self.cancel)?;
            self.limit_generations(began.elapsed().as_secs_f64());
            self.keep()?;
            let mut preview = self.preview_search();
            for result in results {
                let model = &self.models[result.model];
                let ModelFitState::Search(strategy) = &model.state else { continue };
                let losses = result.losses.iter().copied();
                self.report(ModelProgress {
                    model: model.name.clone(),
                    stage: Stage::Search,
                    iteration: strategy.generation() as u32,
                    loss: losses.clone().reduce(f64::min),
                    best_loss: strategy.best().map(|b| b.loss),
                    note: result.failures.note(losses.len()),
                    preview: preview.take_if(|p| p.variant == model.name),
                });
            }
        }
    }

    /// Reports before a search begins that the graph is in pieces, so that no time is wasted on the
    /// fit of an object held together by joints.
    fn report_pieces(&mut self) {
        let Some(model) = self.models.first() else { return };
        if !matches!(&model.state, ModelFitState::Search(strategy) if strategy.generation() == 0) {
            return;
        }
        let connectivity = Connectivity::from_settings(&self.task.settings.graph, false);
        let pieces = connect_with_notes(&self.task.sample, &connectivity).1.pieces_joined;
        if pieces == 0 {
            return;
        }
        let note = format!(
            "with a spring radius of {:.4} m the object falls into {} pieces, which are joined where they are nearest: \
             raise graph.radius_m, or leave it out and it follows the spacing of the points",
            connectivity.radius_m,
            pieces + 1
        );
        let start = ModelProgress::new(&model.name, Stage::Search, 0);
        self.report(ModelProgress { note: Some(note), ..start });
    }

    /// Makes the search as long as the time limit allows, from the time of a generation.
    fn limit_generations(&mut self, took_s: f64) {
        let Some(limit) = &self.limit else { return };
        let done = self.models.iter().filter_map(|m| match &m.state {
            ModelFitState::Search(strategy) => Some(strategy.generation() as u32),
            ModelFitState::Chosen { .. } | ModelFitState::Refine { .. } => None,
        });
        let done = done.max().unwrap_or(0);
        self.generations = limit.generations(self.task.generations(), done, took_s);
        self.estimator.set_generations(self.generations);
    }
}
