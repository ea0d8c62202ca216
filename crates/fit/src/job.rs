//! A fit from its capture to its twin.

mod identifiability;
mod look;
mod members;
mod planner;
mod unscored;

use std::{sync::Arc, time::Instant};

use bendtwin_core::{
    CancelToken, Capture, FitSettings, Observer, Progress, Quality, Stage, Twin,
    quality::{Assessment, Choice, Level, Predictor},
    settings::DeviceKind,
};
use bendtwin_engine::{Backend, backend};
use bendtwin_eval::{EvaluateOptions, Scale, assess, evaluate, fast_variant};
use bendtwin_graph::{Connectivity, connect_with_notes};

use crate::{
    Error,
    checkpoint::{Checkpoint, ChosenStart, Identity, ModelFitState},
    cmaes::default_population,
    look::Look,
    memory,
    model_fit::{ModelFit, model_name},
    progress::{APPEARANCE_SHARE, ModelProgress, ProgressEstimator},
    refine::Refinement,
    search::{Search, Searcher},
    task::Task,
    time_limit::TimeLimit,
    validation::Validation,
    warnings,
};

/// A fit: capture, settings and device.
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
    /// Views for the look of the twin; none if no camera saw the object.
    pub look: Option<Look<'a>>,
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
        let task = self.task(cancel)?;
        self.complete(&task, None, checkpoint, observer, cancel)
    }

    /// Refines a twin: the fit starts from its graph and its parameters, brought to the capture by
    /// registration where it is not the twin's own, and makes no search.
    ///
    /// # Errors
    /// Those of [`FitJob::run`], and if the twin cannot be brought to the capture.
    pub fn refine(
        &self,
        twin: &Twin,
        checkpoint: Option<&[u8]>,
        observer: &mut dyn Observer<Progress>,
        cancel: &CancelToken,
    ) -> Result<Outcome, Error> {
        let device = device_kind(&*self.backend);
        let task = Task::from_twin(self.capture, &self.settings, twin, device, cancel)?;
        let file = twin.encode().map_err(|e| Error::Twin(e.to_string()))?;
        let digest = blake3::hash(&file).to_hex().to_string();
        self.complete(&task, Some(&digest), checkpoint, observer, cancel)
    }

    /// The task of a fit that begins with a search.
    fn task(&self, cancel: &CancelToken) -> Result<Task<'_>, Error> {
        if let Some(twin) = &self.settings.start_from {
            let fault = format!("start_from is {twin}: give the twin itself to start from it");
            return Err(Error::Settings(vec![fault]));
        }
        let device = device_kind(&*self.backend);
        Task::new(self.capture, &self.settings, device, cancel)
    }

    fn complete(
        &self,
        task: &Task<'_>,
        refined_from: Option<&str>,
        checkpoint: Option<&[u8]>,
        observer: &mut dyn Observer<Progress>,
        cancel: &CancelToken,
    ) -> Result<Outcome, Error> {
        let validation = Validation::new(task);
        let mut run = Run::new(self, task, validation.as_ref(), observer, cancel);
        if let Some(digest) = refined_from {
            run.refined_from = Some(digest.to_owned());
            run.identity.capture_digest = format!("{} from {digest}", self.capture_digest);
        }
        if let Some(bytes) = checkpoint {
            run.restore(bytes)?;
        }
        run.search()?;
        let finished = run.refine()?;
        let mut outcome = run.evaluate(finished)?;
        run.dress(&mut outcome)?;
        run.distill(&mut outcome)?;
        Ok(outcome)
    }
}

/// A fit in progress.
struct Run<'a> {
    job: &'a FitJob<'a>,
    task: &'a Task<'a>,
    /// The frames that are held back, if there are several starts to choose from.
    validation: Option<&'a Validation<'a>>,
    models: Vec<ModelFit>,
    /// The starts that were chosen by frames held back, one for each kind of model; empty before.
    chosen: Vec<ChosenStart>,
    identity: Identity,
    /// Digest of the twin that is refined, if there is one.
    refined_from: Option<String>,
    /// Generations of the search.
    generations: u32,
    limit: Option<TimeLimit>,
    /// Checkpoints of the trainings of Gaussians, one for each twin whose training was begun.
    trainings: Vec<Vec<u8>>,
    estimator: ProgressEstimator,
    observer: &'a mut dyn Observer<Progress>,
    cancel: &'a CancelToken,
}

/// Pass whose duration determines how many fit into a time limit.
const MEASURED_PASS: u32 = 2;

/// The kind of a backend's device.
pub(crate) fn device_kind(backend: &dyn Backend) -> DeviceKind {
    if memory::lanes(backend).on_host { DeviceKind::Cpu } else { DeviceKind::Gpu }
}

/// A model whose refinement is done.
struct RefinedModel {
    twin: Twin,
    warnings: Vec<String>,
    choice: Option<Choice>,
    /// True if the time limit left too few passes.
    is_cut: bool,
}

impl<'a> Run<'a> {
    fn new(
        job: &'a FitJob<'a>,
        task: &'a Task<'a>,
        validation: Option<&'a Validation<'a>>,
        observer: &'a mut dyn Observer<Progress>,
        cancel: &'a CancelToken,
    ) -> Self {
        let models = ModelFit::all(task);
        let identity = Identity {
            capture_digest: job.capture_digest.clone(),
            settings: task.settings.clone(),
            backend: job.backend.device().kind,
        };
        let searched = validation.map_or(task, |v| &v.shorter);
        let search_frames = searched.search_set().iter().map(|t| t.frames).sum();
        let population = match task.population() {
            0 => default_population(models[0].space.start().len()),
            n => n,
        };
        let mut estimator = ProgressEstimator::new(task, search_frames, population);
        estimator.set_passes(validation.map_or(0, |v| v.shorter.passes()) + task.passes());
        let appearance = &task.settings.appearance;
        let trains = job.look.is_some() && appearance.gaussians.unwrap_or_default() > 0;
        if trains {
            let twins = if task.settings.bending && task.settings.compare_axial { 2 } else { 1 };
            estimator.set_steps(appearance.steps.saturating_mul(twins));
        }
        let for_twin = if trains { 1.0 - APPEARANCE_SHARE } else { 1.0 };
        let limit = task.settings.within_s.map(|limit_s| TimeLimit::new(for_twin * limit_s));
        let generations = task.generations();
        let chosen = Vec::new();
        Self {
            job,
            task,
            validation,
            models,
            chosen,
            identity,
            refined_from: None,
            generations,
            limit,
            trainings: Vec::new(),
            estimator,
            observer,
            cancel,
        }
    }

    /// The task of the stage: without the frames held back, until a start is chosen.
    fn current_task(&self) -> &'a Task<'a> {
        match self.validation {
            Some(validation) if self.chosen.is_empty() => &validation.shorter,
            _ => self.task,
        }
    }

    fn restore(&mut self, bytes: &[u8]) -> Result<(), Error> {
        let checkpoint = Checkpoint::from_bytes(bytes, &self.identity)?;
        if checkpoint.models.len() != self.models.len() {
            return Err(Error::Checkpoint("it has another number of models".into()));
        }
        for (model, state) in self.models.iter_mut().zip(checkpoint.models) {
            model.state = state;
        }
        self.chosen = checkpoint.chosen;
        self.trainings = checkpoint.trainings;
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
            chosen: self.chosen.clone(),
            generations: self.limit.as_ref().map(|_| self.generations),
            spent_s: self.limit.as_ref().map_or(0.0, TimeLimit::spent_s),
            trainings: self.trainings.clone(),
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
        self.report(ModelProgress {
            model: model.name.clone(),
            stage: Stage::Search,
            iteration: 0,
            loss: None,
            best_loss: None,
            note: Some(note),
        });
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

    /// Runs passes until all models are refined; returns the start of each kind of model that is
    /// kept. Where frames are held back, all starts are refined without them first.
    fn refine(&mut self) -> Result<Vec<RefinedModel>, Error> {
        let mut refinement = self.begin_refinement()?;
        self.pass(&mut refinement)?;
        if let Some(validation) = self.validation.filter(|_| self.chosen.is_empty()) {
            self.choose(validation, &refinement)?;
            self.keep()?;
            refinement = self.begin_refinement()?;
            self.pass(&mut refinement)?;
        }
        let mut finished = Vec::new();
        let refined_from = self.refined_from.clone();
        let refined_from = refined_from.as_deref();
        for bending in self.kinds() {
            let own = refinement.runs.iter().filter(|r| self.models[r.model].bending == bending);
            let best = own.min_by(|a, b| a.state.best.loss.total_cmp(&b.state.best.loss));
            let Some(best) = best else { continue };
            let model = &self.models[best.model];
            let choice = self.choice(best.model, &refinement);
            let mut twin = model.twin(self.job, self.task, refined_from, self.generations, best)?;
            let is_cut = !best.state.has_ended && best.state.passes < self.task.passes();
            let warnings = warnings::of_fit(self.task, model);
            self.add_members(&mut twin, best.model, &refinement)?;
            finished.push(RefinedModel { twin, warnings, choice, is_cut });
        }
        Ok(finished)
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
            for run in &mut refinement.runs {
                self.report(ModelProgress {
                    model: self.models[run.model].name.clone(),
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

    /// Passes that were planned before those of the current stage.
    fn passes_before(&self) -> u32 {
        self.validation.filter(|_| self.is_last_stage()).map_or(0, |v| v.shorter.passes())
    }

    /// True if the models in refinement are those that are kept: no choice among starts is left.
    fn is_last_stage(&self) -> bool {
        self.validation.is_none() || !self.chosen.is_empty()
    }

    /// The kinds of models, with bending or without, in their order.
    fn kinds(&self) -> Vec<bool> {
        let mut kinds: Vec<bool> = self.models.iter().map(|m| m.bending).collect();
        kinds.dedup();
        kinds
    }

    /// Chooses the start of each kind of model that predicts the frames held back best, and sends it
    /// back to what its search found.
    fn choose(
        &mut self,
        validation: &Validation<'_>,
        refinement: &Refinement<'_>,
    ) -> Result<(), Error> {
        let losses = validation.losses(&refinement.runs, &*self.job.backend, self.cancel)?;
        for bending in self.kinds() {
            let runs = || refinement.runs.iter().zip(&losses);
            let own = || runs().filter(|(r, _)| self.models[r.model].bending == bending);
            let Some((best, _)) = own().min_by(|a, b| a.1.total_cmp(b.1)) else { continue };
            let of_model =
                |m: usize| own().find(|(r, _)| r.model == m).map_or(f64::INFINITY, |(_, l)| *l);
            let of_kind = (0..self.models.len()).filter(|&m| self.models[m].bending == bending);
            let losses = of_kind.map(of_model).collect();
            self.chosen.push(ChosenStart { model: best.model, losses });
        }
        self.chosen.iter().for_each(|c| self.models[c.model].choose());
        Ok(())
    }

    /// The choice of a model among the starts of its kind; `None` where there was no choice.
    fn choice(&self, model: usize, refinement: &Refinement<'_>) -> Option<Choice> {
        let bending = self.models[model].bending;
        let of_kind: Vec<usize> =
            (0..self.models.len()).filter(|&m| self.models[m].bending == bending).collect();
        if of_kind.len() < 2 {
            return None;
        }
        let finite = |loss: f64| loss.is_finite().then_some(loss);
        let held_back = self.chosen.iter().find(|c| c.model == model).zip(self.validation);
        let losses = match held_back {
            Some((chosen, _)) => chosen.losses.iter().map(|&l| finite(l)).collect(),
            None => {
                let run = |m: usize| refinement.runs.iter().find(|r| r.model == m);
                of_kind.iter().map(|&m| run(m).and_then(|r| finite(r.state.best.loss))).collect()
            }
        };
        Some(Choice {
            start: of_kind.iter().position(|&m| m == model)? as u32,
            held_back_frames: held_back.map_or(0, |(_, validation)| validation.frames),
            losses,
        })
    }

    /// The refinement of all models whose search found something to refine, of the chosen ones once
    /// there are any. Of several starts some
    /// may have found nothing, but not all of the same kind of model.
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

    /// The table in words. Where the time limit cut the fit short, that comes before other advice.
    fn assessment(&self, twin: &Twin, quality: &Quality, is_cut: bool) -> Assessment {
        let mut assessment =
            assess(quality, Scale::of_nodes(&twin.graph.rest_positions, &twin.graph.rods));
        let made = twin.provenance.settings.as_ref().and_then(|s| s.refine.passes);
        if let (Some(made), Some(limit_s)) = (made, self.task.settings.within_s)
            && is_cut
            && assessment.level != Level::Good
        {
            assessment.next = format!(
                "The time limit of {limit_s} s left {made} of {} passes: fit again with more time.",
                self.task.passes()
            );
        }
        assessment
    }

    /// Evaluates the twin and adds its fast variant.
    fn evaluate(&mut self, finished: Vec<RefinedModel>) -> Result<Outcome, Error> {
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
        let Some(RefinedModel { mut twin, warnings, choice, is_cut }) = finished.next() else {
            return Err(Error::NothingStable("there is no model".into()));
        };
        let mut axial = finished.next().map(|f| f.twin);
        let options = EvaluateOptions { axial: axial.as_ref(), per_frame: false };
        let mut quality =
            evaluate(&*self.job.backend, &twin, self.job.capture, &options, self.cancel)?;
        quality.warnings.splice(0..0, warnings);
        quality.choice = choice;
        if let Some(axial) = &mut axial {
            let row = quality.score(Predictor::Axial).cloned();
            axial.quality.scores = row.into_iter().collect();
        }
        quality.fast = fast_variant(&*self.job.backend, &twin, self.job.capture, self.cancel)?;
        quality.assessment = Some(self.assessment(&twin, &quality, is_cut));
        twin.quality = quality;
        self.identify(&mut twin)?;
        self.report(progress(1));
        Ok(Outcome { twin, axial })
    }
}

#[cfg(test)]
mod tests;
