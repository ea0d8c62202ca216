//! The models that one fit makes: with bending, and the axial-only one beside it.

use std::sync::Arc;

use bendtwin_core::{Environment, FitSettings, Params, Twin, twin::Provenance};
use bendtwin_engine::{Backend, descent::Start};

use crate::{
    Error, FitJob, checkpoint::VariantState, cmaes::CmaEs, fabric::Fabric, refine::Walk,
    space::Space, task::Task,
};

/// Apart from the search's and the schedule's random numbers, each variant has its own.
const SEED_STEP: u64 = 0x9e37_79b9_7f4a_7c15;

/// One model under way.
pub(crate) struct Variant {
    pub(crate) name: &'static str,
    pub(crate) space: Space,
    settings: FitSettings,
}

impl Variant {
    /// The twin's own variant first, then the one to compare with.
    pub(crate) fn all(task: &Task<'_>) -> Vec<Self> {
        let one = |bending: bool| Self {
            name: if bending { "bending" } else { "axial" },
            space: Space::new(task, bending),
            settings: FitSettings {
                bending,
                compare_axial: bending && task.settings.compare_axial,
                ..task.settings.clone()
            },
        };
        let mut variants = vec![one(task.settings.bending)];
        if task.settings.bending && task.settings.compare_axial {
            variants.push(one(false));
        }
        variants
    }

    /// A search that has not begun.
    pub(crate) fn begin(&self) -> VariantState {
        let search = &self.settings.search;
        let seed = self.settings.seed.wrapping_add(SEED_STEP);
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
    ) -> Result<(Vec<f64>, (Walk<'a>, Start)), Error> {
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
                build: crate::BUILD.to_owned(),
                backend: job.backend.device().kind,
                source_to_world: job.capture.source_to_world,
            },
            quality: bendtwin_core::Quality::default(),
        })
    }
}
