//! A fit from its capture to its twin.

use std::{sync::Arc, time::Instant};

use bendtwin_core::{
    CancelToken, Capture, FitSettings, Observer, Progress, Stage, Twin, quality::Predictor,
    settings::DeviceKind,
};
use bendtwin_engine::{Backend, backend};
use bendtwin_eval::{EvaluateOptions, evaluate, fast_variant};

use crate::{
    Error,
    checkpoint::{Checkpoint, Identity, ModelFitState},
    cmaes::default_population,
    memory,
    model_fit::{ModelFit, model_name},
    progress::{ModelProgress, ProgressEstimator},
    refine::Refinement,
    search::{Search, Searcher},
    task::Task,
    time_limit::TimeLimit,
    warnings,
};

/// One fit: capture, settings and device.
#[derive(Clone)]
pub struct FitJob<'a> {
    /// The capture to fit to.
    pub capture: &'a Capture,
    /// BLAKE3 digest of the capture's content, hex; kept in the twin's provenance.
    pub capture_digest: String,
    /// Settings of the fit.
    pub settings: FitSettings,
    /// Backend that simulates.
    pub backend: Arc<dyn Backend>,
}

/// The result of a fit.
#[derive(Clone, Debug, PartialEq)]
pub struct Outcome {
    /// The twin with its quality table. The same capture, settings, build and device give the same
    /// twin, however often the fit was interrupted.
    pub twin: Twin,
    /// The axial-only fit of the same nodes, if the settings ask for the comparison.
    pub axial: Option<Twin>,
}

impl FitJob<'_> {
    /// Fits, from the start or from a checkpoint of the same fit.
    ///
    /// # Errors
    /// If settings or capture are wrong, the checkpoint belongs elsewhere, the backend fails, the
    /// observer asks to stop, or `cancel` is set (within a second).
    pub fn run(
        &self,
        checkpoint: Option<&[u8]>,
        observer: &mut dyn Observer<Progress>,
        cancel: &CancelToken,
    ) -> Result<Outcome, Error> {
        let task = Task::new(self.capture, &self.settings, device_kind(&*self.backend))?;
        let mut run = Run::new(self, &task, observer, cancel);
        if let Some(bytes) = checkpoint {
            run.restore(bytes)?;
        }
        run.search()?;
        let finished = run.refine()?;
        run.evaluate(finished)
    }
}

/// A fit in progress.
struct Run<'a> {
    job: &'a FitJob<'a>,
    task: &'a Task<'a>,
    models: Vec<ModelFit>,
    identity: Identity,
    /// Generations of the search.
    generations: u32,
    limit: Option<TimeLimit>,
    estimator: ProgressEstimator,
    observer: &'a mut dyn Observer<Progress>,
    cancel: &'a CancelToken,
}

/// Pass whose time tells how many fit into a time limit.
const MEASURED_PASS: u32 = 2;

/// The kind of a backend's device.
pub(crate) fn device_kind(backend: &dyn Backend) -> DeviceKind {
    if memory::lanes(backend).on_host { DeviceKind::Cpu } else { DeviceKind::Gpu }
}

/// A model whose refinement is done.
struct Finished {
    twin: Twin,
    warnings: Vec<String>,
}

impl<'a> Run<'a> {
    fn new(
        job: &'a FitJob<'a>,
        task: &'a Task<'a>,
        observer: &'a mut dyn Observer<Progress>,
        cancel: &'a CancelToken,
    ) -> Self {
        let models = ModelFit::all(task);
        let identity = Identity {
            capture_digest: job.capture_digest.clone(),
            settings: task.settings.clone(),
            backend: job.backend.device().kind,
        };
        let search_frames = task.search_set().iter().map(|t| t.frames).sum();
        let population = match task.population() {
            0 => default_population(models[0].space.start().len()),
            n => n,
        };
        let estimator = ProgressEstimator::new(task, search_frames, population);
        let limit = task.settings.within_s.map(TimeLimit::new);
        let generations = task.generations();
        Self { job, task, models, identity, generations, limit, estimator, observer, cancel }
    }

    fn restore(&mut self, bytes: &[u8]) -> Result<(), Error> {
        let checkpoint = Checkpoint::from_bytes(bytes, &self.identity)?;
        if checkpoint.models.len() != self.models.len() {
            return Err(Error::Checkpoint("it has another number of models".into()));
        }
        for (model, state) in self.models.iter_mut().zip(checkpoint.models) {
            model.state = state;
        }
        self.generations = checkpoint.generations.unwrap_or(self.generations);
        if let Some(limit) = &mut self.limit {
            limit.resume(checkpoint.spent_s);
        }
        Ok(())
    }

    fn keep(&mut self) -> Result<(), Error> {
        let models = self.models.iter().map(|m| m.state.clone()).collect();
        let checkpoint = Checkpoint {
            models,
            generations: self.limit.as_ref().map(|_| self.generations),
            spent_s: self.limit.as_ref().map_or(0.0, TimeLimit::spent_s),
        };
        let checkpoint = checkpoint.to_bytes(&self.identity)?;
        self.observer.checkpoint(checkpoint).map_err(Error::Observer)
    }

    fn report(&mut self, progress: ModelProgress) {
        let progress = self.estimator.progress(progress);
        self.observer.progress(progress);
    }

    fn check_cancelled(&self) -> Result<(), Error> {
        if self.cancel.is_cancelled() { Err(backend::Error::Cancelled.into()) } else { Ok(()) }
    }

    /// Runs generations until all searches are done. Models that are past the search stay as they
    /// are.
    fn search(&mut self) -> Result<(), Error> {
        let mut search = Search::new(self.task);
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
                });
            }
        }
    }

    /// Makes the search as long as the time limit allows, from the time of a generation.
    fn limit_generations(&mut self, took_s: f64) {
        let Some(limit) = &self.limit else { return };
        let done = self.models.iter().filter_map(|m| match &m.state {
            ModelFitState::Search(strategy) => Some(strategy.generation() as u32),
            ModelFitState::Refine { .. } => None,
        });
        let done = done.max().unwrap_or(0);
        self.generations = limit.generations(self.task.generations(), done, took_s);
        self.estimator.set_generations(self.generations);
    }

    /// Makes the refinement as long as the time limit allows, from the time of a pass.
    fn limit_passes(&mut self, refinement: &mut Refinement<'_>, took_s: f64) {
        let Some(limit) = &self.limit else { return };
        let Some(done) = refinement.runs.first().map(|r| r.state.pass) else { return };
        // The rate falls over all passes, so their number stays once it is known; the first pass
        // may be slow for reasons of its own.
        let passes = match done {
            MEASURED_PASS => limit.passes(self.task.passes(), done, took_s),
            _ if limit.is_over(took_s) => done,
            _ => return,
        };
        refinement.runs.iter_mut().for_each(|r| r.state.passes = r.state.passes.min(passes));
        self.estimator.set_passes(passes);
    }

    /// Runs passes until all models are refined; returns the best start of each kind of model.
    fn refine(&mut self) -> Result<Vec<Finished>, Error> {
        let mut refinement = self.begin_refinement()?;
        while refinement.runs.iter().any(|r| r.state.pass < r.state.passes) {
            self.check_cancelled()?;
            let began = Instant::now();
            refinement.pass()?;
            self.limit_passes(&mut refinement, began.elapsed().as_secs_f64());
            for run in &refinement.runs {
                self.models[run.model].record_run(&run.state);
            }
            self.keep()?;
            for run in &mut refinement.runs {
                self.report(ModelProgress {
                    model: self.models[run.model].name.clone(),
                    stage: Stage::Refine,
                    iteration: run.state.pass,
                    loss: Some(run.state.loss),
                    best_loss: Some(run.state.best.loss),
                    note: run.note.take(),
                });
            }
        }
        let mut finished = Vec::new();
        for starts in self.models.chunk_by(|a, b| a.bending == b.bending) {
            let bending = starts[0].bending;
            let own = refinement.runs.iter().filter(|r| self.models[r.model].bending == bending);
            let best = own.min_by(|a, b| a.state.best.loss.total_cmp(&b.state.best.loss));
            let Some(best) = best else { continue };
            let model = &self.models[best.model];
            let twin = model.twin(self.job, self.generations, best)?;
            finished.push(Finished { twin, warnings: warnings::of_fit(self.task, model) });
        }
        Ok(finished)
    }

    /// The refinement of all models whose search found something to refine. Of several starts some
    /// may have found nothing, but not all of the same kind of model.
    fn begin_refinement(&mut self) -> Result<Refinement<'a>, Error> {
        let (task, backend) = (self.task, &*self.job.backend);
        let (mut runs, mut from_search, mut nothing) = (Vec::new(), false, None);
        for (index, model) in self.models.iter_mut().enumerate() {
            let is_searched = matches!(model.state, ModelFitState::Search(_));
            match model.begin_run(index, task, backend) {
                Ok(run) => {
                    from_search |= is_searched;
                    runs.push(run);
                }
                Err(Error::NothingStable(why)) => nothing = Some(Error::NothingStable(why)),
                Err(e) => return Err(e),
            }
        }
        let has_run =
            |m: &ModelFit| runs.iter().any(|(r, _)| self.models[r.model].bending == m.bending);
        if let (Some(nothing), false) = (nothing, self.models.iter().all(has_run)) {
            return Err(nothing);
        }
        let mut refinement = Refinement::new(task, runs, backend, self.cancel)?;
        if from_search {
            refinement.begin()?;
        }
        Ok(refinement)
    }

    /// Evaluates the twin and adds its fast variant.
    fn evaluate(&mut self, finished: Vec<Finished>) -> Result<Outcome, Error> {
        self.check_cancelled()?;
        let model = model_name(self.models[0].bending);
        let progress = |iteration: u32| ModelProgress {
            model: model.to_owned(),
            stage: Stage::Evaluate,
            iteration,
            loss: None,
            best_loss: None,
            note: None,
        };
        self.report(progress(0));
        let mut finished = finished.into_iter();
        let Some(Finished { mut twin, warnings }) = finished.next() else {
            return Err(Error::NothingStable("there is no model".into()));
        };
        let mut axial = finished.next().map(|f| f.twin);
        let options = EvaluateOptions { axial: axial.as_ref(), per_frame: false };
        let mut quality =
            evaluate(&*self.job.backend, &twin, self.job.capture, &options, self.cancel)?;
        quality.warnings.splice(0..0, warnings);
        if let Some(axial) = &mut axial {
            let row = quality.score(Predictor::Axial).cloned();
            axial.quality.scores = row.into_iter().collect();
        }
        quality.fast = fast_variant(&*self.job.backend, &twin, self.job.capture, self.cancel)?;
        twin.quality = quality;
        self.report(progress(1));
        Ok(Outcome { twin, axial })
    }
}

#[cfg(test)]
mod tests;
