//! The models of one fit: the bending model, and the axial-only one that it is compared with, each
//! with as many starts as the settings ask for.

use std::sync::Arc;

use bendtwin_core::{Environment, FitSettings, Params, Twin, twin::Provenance};
use bendtwin_engine::{Backend, Model, optimizer::OptimizerInit};

use super::checkpoint::ModelFitState;
use crate::{
    Error, FitJob,
    built_graph::{BuiltGraph, build_model},
    refine::{OptimizerRun, RunState},
    search::{cmaes::CmaEs, space::Space},
    task::{Task, of_start, others},
};

/// Difference between the seeds of several starts. The schedule of mini-batches has a stream of its
/// own.
const SEED_STEP: u64 = 0x9e37_79b9_7f4a_7c15;

/// Name of a model for people.
pub(crate) fn model_name(bending: bool) -> &'static str {
    if bending { "bending" } else { "axial" }
}

/// A start of a model.
pub(crate) struct ModelFit {
    /// Name for people: `bending`, or `bending 2/3` where there are several starts.
    pub(crate) name: String,
    pub(crate) bending: bool,
    pub(crate) space: Space,
    pub(crate) state: ModelFitState,
    settings: FitSettings,
}

impl ModelFit {
    /// All starts of the twin's own model, then all starts of the one to compare with; each before
    /// its search.
    pub(crate) fn all(task: &Task<'_>) -> Vec<Self> {
        let starts = task.settings.search.start_count();
        let mut models = vec![task.settings.bending];
        if task.settings.bending && task.settings.compare_axial {
            models.push(false);
        }
        let all = models.into_iter().flat_map(|bending| (0..starts).map(move |s| (bending, s)));
        all.map(|(bending, start)| Self::new(task, bending, start, starts)).collect()
    }

    fn new(task: &Task<'_>, bending: bool, start: u32, starts: u32) -> Self {
        let settings = FitSettings {
            bending,
            compare_axial: bending && task.settings.compare_axial,
            ..task.settings.clone()
        };
        let space = Space::new(task, &settings.of_start(start));
        let search = &settings.search;
        let steps = u64::from(start) + 1;
        let seed = settings.seed.wrapping_add(SEED_STEP.wrapping_mul(steps));
        let strategy = CmaEs::new(space.start(), search.sigma, task.population(), seed);
        let name = match (model_name(bending), starts) {
            (model, 1) => model.to_owned(),
            (model, _) => format!("{model} {}/{starts}", start + 1),
        };
        Self { name, bending, space, state: ModelFitState::Search(strategy), settings }
    }

    /// Graph, parameters and environment at a point of the search space, or of the twin that is
    /// refined.
    fn build(&self, task: &Task<'_>, point: &[f64]) -> (Arc<BuiltGraph>, Params, Environment) {
        if let Some(twin) = &task.start {
            let (built, params, environment) = of_start(task, twin);
            return (Arc::new(built), params, environment);
        }
        let candidate = self.space.candidate(point);
        let built = Arc::new(BuiltGraph::new(task, &candidate.connectivity));
        let params = candidate.params(&built);
        (built, params, candidate.environment(task.capture.environment))
    }

    /// The point that the refinement starts from and its graph; `None` before the refinement.
    pub(crate) fn refined(&self, task: &Task<'_>) -> Option<(&[f64], Arc<BuiltGraph>)> {
        match &self.state {
            ModelFitState::Search(_) | ModelFitState::Chosen { .. } => None,
            ModelFitState::Refine { point, .. } => Some((point, self.build(task, point).0)),
        }
    }

    /// Begins the optimizer run at the result of the search, or continues it from a checkpoint.
    /// `index` is the model's in the fit.
    pub(crate) fn begin_run<'a>(
        &mut self,
        index: usize,
        task: &'a Task<'a>,
        backend: &dyn Backend,
    ) -> Result<(OptimizerRun<'a>, OptimizerInit), Error> {
        let dimension = self.space.start().len();
        let point = match &self.state {
            ModelFitState::Search(search) => match search.best() {
                Some(best) => best.point.clone(),
                None if task.generations() == 0 => self.space.start(),
                None => {
                    let why = "all were too stiff or diverged".to_owned();
                    return Err(Error::NothingStable(why));
                }
            },
            ModelFitState::Chosen { point } | ModelFitState::Refine { point, .. } => point.clone(),
        };
        if point.len() != dimension {
            return Err(Error::Checkpoint("it has another number of variables".into()));
        }
        let (built, params, environment) = self.build(task, &point);
        let graph = built.graph.clone();
        let (run, init) = match &self.state {
            ModelFitState::Search(_) | ModelFitState::Chosen { .. } => {
                OptimizerRun::new(index, task, graph, params, environment, backend)?
            }
            ModelFitState::Refine { run, .. } => {
                let state = run.clone();
                OptimizerRun::restore(index, task, graph, params, environment, state, backend)?
            }
        };
        self.state = ModelFitState::Refine { point, run: run.state.clone() };
        Ok((run, init))
    }

    /// Goes back to what the search found, to be refined on all training frames.
    pub(crate) fn choose(&mut self) {
        if let ModelFitState::Refine { point, .. } = &self.state {
            self.state = ModelFitState::Chosen { point: point.clone() };
        }
    }

    /// Takes over the state of the optimizer run.
    pub(crate) fn record_run(&mut self, state: &RunState) {
        if let ModelFitState::Refine { run, .. } = &mut self.state {
            run.clone_from(state);
        }
    }

    /// The twin at a run's best parameters, without its quality. Its settings have the generations
    /// and passes that were made.
    pub(crate) fn twin(
        &self,
        job: &FitJob<'_>,
        task: &Task<'_>,
        refined_from: Option<&str>,
        generations: u32,
        run: &OptimizerRun<'_>,
    ) -> Result<Twin, Error> {
        if !run.state.best.loss.is_finite() {
            let why = "the best one diverged on the whole training set".to_owned();
            return Err(Error::NothingStable(why));
        }
        let (params, timing) = run.best();
        let mut settings = self.settings.clone();
        settings.search.generations = Some(generations);
        settings.refine.passes = Some(run.state.pass);
        let model = Model { params, timing, ..Model::clone(run.loaded.model()) };
        Ok(self.twin_of(job, task, refined_from, settings, model))
    }

    /// The search of the model; `None` once it is over.
    pub(crate) fn search(&self) -> Option<&CmaEs> {
        match &self.state {
            ModelFitState::Search(search) => Some(search),
            ModelFitState::Chosen { .. } | ModelFitState::Refine { .. } => None,
        }
    }

    /// The twin at the best point of the search; `None` before there is one.
    pub(crate) fn searched(&self, job: &FitJob<'_>, task: &Task<'_>) -> Option<Twin> {
        let (built, params, environment) = self.build(task, &self.search()?.best()?.point);
        let model = build_model(task, &built.graph, params, environment).ok()?;
        Some(self.twin_of(job, task, None, self.settings.clone(), model))
    }

    /// A model as a twin in the reference, without its quality.
    fn twin_of(
        &self,
        job: &FitJob<'_>,
        task: &Task<'_>,
        refined_from: Option<&str>,
        settings: FitSettings,
        model: Model,
    ) -> Twin {
        let (environment, timing) = (model.environment, model.timing);
        let (graph, params, skin) =
            others::of_reference(task, &model.graph, model.params, &model.skin);
        Twin {
            graph,
            skin,
            params,
            environment,
            timing,
            control_velocity: self.settings.control_velocity,
            provenance: Provenance {
                capture_digest: job.capture_digest.clone(),
                capture_name: job.capture.name.clone(),
                settings: Some(settings),
                build: bendtwin_core::BUILD.to_owned(),
                backend: job.backend.device().kind,
                source_to_world: job.capture.source_to_world,
                refined_from: refined_from.map(str::to_owned),
                loss: None,
            },
            quality: bendtwin_core::Quality::default(),
            mass_kg: job.capture.object.mass_kg,
            control_hands: job.capture.object.control_hands.clone(),
            members: Vec::new(),
            appearance: None,
            surface: None,
            planner: None,
        }
    }
}
