//! A fit from its capture to its twin, in stages: a checked [`Task`], the search ([`search`]), the
//! refinement and the choice among starts ([`refine`], [`choice`]), the evaluation ([`evaluate`]), and
//! what is made of the twin after it ([`look`], [`planner`]).

pub(crate) mod checkpoint;
mod choice;
mod evaluate;
mod identifiability;
mod look;
mod members;
pub(crate) mod model_fit;
mod planner;
mod preview;
mod refine;
mod search;
mod surface;
mod time_limit;
mod unscored;
mod validation;
mod warnings;

use std::sync::Arc;

use bendtwin_core::{
    CancelToken, Capture, FitSettings, Observer, Progress, Twin, settings::DeviceKind,
};
use bendtwin_engine::{Backend, backend};

use self::{
    checkpoint::{Checkpoint, ChosenStart, Identity},
    model_fit::ModelFit,
    preview::Previews,
    time_limit::TimeLimit,
    validation::Validation,
};
use crate::{
    Error,
    look::Look,
    memory,
    progress::{APPEARANCE_SHARE, ModelProgress, ProgressEstimator},
    search::cmaes::default_population,
    task::Task,
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
            run.refined_from = Some(digest);
            run.identity.capture_digest = format!("{} from {digest}", self.capture_digest);
        }
        if let Some(bytes) = checkpoint {
            run.restore(bytes)?;
        }
        run.search()?;
        let finished = run.refine()?;
        let mut outcome = run.evaluate(finished)?;
        run.dress(&mut outcome)?;
        run.wrap(&mut outcome);
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
    refined_from: Option<&'a str>,
    /// Generations of the search.
    generations: u32,
    limit: Option<TimeLimit>,
    /// Checkpoints of the trainings of Gaussians, one for each twin whose training was begun.
    trainings: Vec<Vec<u8>>,
    previews: Previews,
    estimator: ProgressEstimator,
    observer: &'a mut dyn Observer<Progress>,
    cancel: &'a CancelToken,
}

/// The kind of a backend's device.
pub(crate) fn device_kind(backend: &dyn Backend) -> DeviceKind {
    if memory::lanes(backend).on_host { DeviceKind::Cpu } else { DeviceKind::Gpu }
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
        Self {
            job,
            task,
            validation,
            models,
            chosen: Vec::new(),
            identity,
            refined_from: None,
            generations: task.generations(),
            limit,
            trainings: Vec::new(),
            previews: Previews::new(observer.wants_previews()),
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
}

#[cfg(test)]
mod tests;
