//! The models that one fit makes: with bending, and the axial-only one beside it, each as often as it starts.

use std::sync::Arc;

use bendtwin_core::{Environment, FitSettings, Params, Twin, twin::Provenance};
use bendtwin_engine::{Backend, optimizer::OptimizerInit};

use crate::{
    Error, FitJob, checkpoint::VariantState, cmaes::CmaEs, fabric::Fabric, refine::Walk,
    space::Space, task::Task,
};

/// Between the seeds of searches that start apart; the schedule's random numbers are apart from all of them.
const SEED_STEP: u64 = 0x9e37_79b9_7f4a_7c15;

/// What people call a model.
pub(crate) fn model_name(bending: bool) -> &'static str {
    if bending { "bending" } else { "axial" }
}

/// One model under way.
pub(crate) struct Variant {
    /// For people: `bending`, or `bending 2/3` where there are several starts.
    pub(crate) name: String,
    pub(crate) bending: bool,
    start: u32,
    pub(crate) space: Space,
    settings: FitSettings,
}

impl Variant {
    /// The twin's own model first, then the one to compare with; of both all starts.
    pub(crate) fn all(task: &Task<'_>) -> Vec<Self> {
        let starts = task.starts();
        let one = |bending: bool, start: u32| Self {
            name: match (model_name(bending), starts) {
                (model, 1) => model.to_owned(),
                (model, _) => format!("{model} {}/{starts}", start + 1),
            },
            bending,
            start,
            space: Space::new(task, bending),
            settings: FitSettings {
                bending,
                compare_axial: bending && task.settings.compare_axial,
                ..task.settings.clone()
            },
        };
        let mut models = vec![task.settings.bending];
        if task.settings.bending && task.settings.compare_axial {
            models.push(false);
        }
        let all = models.into_iter().flat_map(|bending| (0..starts).map(move |s| (bending, s)));
        all.map(|(bending, start)| one(bending, start)).collect()
    }

    /// A search that has not begun.
    pub(crate) fn begin(&self) -> VariantState {
        let search = &self.settings.search;
        let steps = u64::from(self.start) + 1;
        let seed = self.settings.seed.wrapping_add(SEED_STEP.wrapping_mul(steps));
        let start = self.space.start();
        VariantState::Search(CmaEs::new(start, search.sigma, search.population, seed))
    }

    /// Graph, parameters and surroundings at a point of the search space.
    pub(crate) fn realise(
        &self,
        task: &Task<'_>,
        point: &[f64],
    ) -> (Arc<Fabric>, Params, Environment) {
        let candidate = self.space.candidate(point);
        let fabric = Arc::new(Fabric::new(task, &candidate.connectivity));
        let params = candidate.params(&fabric);
        (fabric, params, candidate.environment(task.capture.environment))
    }

    /// The walk from where the search ended, or from where a checkpoint left it, and its start.
    pub(crate) fn walk<'a>(
        &self,
        task: &'a Task<'a>,
        state: &VariantState,
        backend: &dyn Backend,
    ) -> Result<(Vec<f64>, (Walk<'a>, OptimizerInit)), Error> {
        let dimension = self.space.start().len();
        let point = match state {
            VariantState::Search(search) => match search.best() {
                Some(best) => best.point.clone(),
                None if task.generations() == 0 => self.space.start(),
                None => {
                    let why = "all were too stiff or diverged".to_owned();
                    return Err(Error::NothingStable(why));
                }
            },
            VariantState::Refine { point, .. } => point.clone(),
        };
        if point.len() != dimension {
            return Err(Error::Checkpoint("it has another number of variables".into()));
        }
        let (fabric, params, environment) = self.realise(task, &point);
        let graph = fabric.graph.clone();
        let walk = match state {
            VariantState::Search(_) => Walk::start(task, graph, params, environment, backend)?,
            VariantState::Refine { walk, .. } => {
                Walk::resume(task, graph, params, environment, walk.clone(), backend)?
            }
        };
        Ok((point, walk))
    }

    /// The twin at a walk's best parameters; its quality is for evaluation to say.
    pub(crate) fn twin(&self, job: &FitJob<'_>, walk: &Walk<'_>) -> Result<Twin, Error> {
        if !walk.state.best.loss.is_finite() {
            let why = "the best one diverged on the whole training set".to_owned();
            return Err(Error::NothingStable(why));
        }
        let (params, timing) = walk.best();
        Ok(Twin {
            graph: walk.graph.as_ref().clone(),
            params,
            environment: walk.loaded.model().environment,
            timing,
            control_velocity: self.settings.control_velocity,
            provenance: Provenance {
                capture_digest: job.capture_digest.clone(),
                capture_name: job.capture.name.clone(),
                settings: Some(self.settings.clone()),
                build: bendtwin_core::BUILD.to_owned(),
                backend: job.backend.device().kind,
                source_to_world: job.capture.source_to_world,
            },
            quality: bendtwin_core::Quality::default(),
        })
    }
}
