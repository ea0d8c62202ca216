//! The model of a twin that answers a request: the exact one, the fast one or the planner's twin, which
//! are made when they are first asked for.

use std::{
    collections::HashSet,
    sync::{Arc, PoisonError},
};

use bendtwin_contract::rollout;
use bendtwin_core::{FastVariant, Fidelity, Twin};
use bendtwin_engine::{Backend, Loaded, Model, fidelity::Reduction};

use super::{error::Error, planner::PlannersWarm, rest_shape::RestShape, warm::Warm};
use crate::device::{Device, Priority};

/// A twin and the model of it that answers.
#[derive(Clone)]
pub(super) struct Served {
    pub(super) warm: Arc<Warm>,
    pub(super) loaded: Loaded,
    /// The variant, if the fast one answers.
    pub(super) fast: Option<FastVariant>,
    /// The planner's twin, if it answers; `warm` is its own then.
    pub(super) planner: Option<Planner>,
    /// Rest shapes that are not the twin's: one for all instances, or one for each; empty: none.
    pub(super) rests: Vec<Option<Arc<RestShape>>>,
}

/// The planner's twin that answers, and the twin that requests are about.
#[derive(Clone)]
pub(super) struct Planner {
    pub(super) of: Arc<Warm>,
    pub(super) own: Arc<PlannersWarm>,
}

impl Served {
    /// The model that follows a twin as finely as asked for.
    pub(super) async fn choose(
        warm: Arc<Warm>,
        fidelity: Fidelity,
        device: &Device,
    ) -> Result<Self, Error> {
        match fidelity {
            Fidelity::Exact => Ok(Self::exact(warm)),
            Fidelity::Fast => Self::fast(warm, device).await,
            Fidelity::Planner => Self::planner(warm, device).await,
        }
    }

    /// The exact model.
    pub(super) fn exact(warm: Arc<Warm>) -> Self {
        let loaded = warm.loaded.clone();
        Self { warm, loaded, fast: None, planner: None, rests: Vec::new() }
    }

    /// The twin that requests are about.
    pub(super) fn twin(&self) -> &Twin {
        self.planner.as_ref().map_or(&self.warm.twin, |planner| &planner.of.twin)
    }

    /// The same in states with these rest shapes: one for all instances, or one for each.
    ///
    /// # Errors
    /// If the planner's twin answers and one is not the twin's: it would not fit into the small model.
    pub(super) fn with_rests(self, rests: Vec<Option<Arc<RestShape>>>) -> Result<Self, Error> {
        if self.planner.is_some() && rests.iter().any(Option::is_some) {
            let fault = "is PLANNER, which has the rest shape that was fitted, and a correction has changed that of the state: begin in another state, or ask for EXACT or FAST";
            return Err(Error::field("fidelity", fault));
        }
        Ok(Self { rests, ..self })
    }

    /// Number of rest shapes that are not the twin's.
    pub(super) fn distinct_rests(&self) -> usize {
        self.rests.iter().flatten().map(Arc::as_ptr).collect::<HashSet<_>>().len()
    }

    /// So many fits: the twin and its members, which are loaded when they are first asked for.
    pub(super) fn fits(&self, count: usize, backend: &dyn Backend) -> Result<Vec<Loaded>, Error> {
        if self.planner.is_some() {
            let fault = "is for the exact twin, and the planner's twin has no other fits: ask for EXACT, or leave it out";
            return Err(Error::field("vary.fits", fault));
        }
        let twin = &self.warm.twin;
        let there = 1 + twin.members.len();
        if count > there {
            let fault = match there {
                1 => "asks for other fits, and the twin has none: fit its capture with `search.starts` of 2 or more".to_owned(),
                _ => format!("asks for {count} fits, and the twin has {there}: use at most {there} members"),
            };
            return Err(Error::field("vary.fits", fault));
        }
        if self.fast.is_some() {
            let fault = "is for the exact twin, and this session follows the fast variant: open another one, or leave it out";
            return Err(Error::field("vary.fits", fault));
        }
        if self.rests.iter().any(Option::is_some) {
            let fault = "is for the twin as it was fitted, and a correction has changed its rest shape: begin in another state, or leave it out";
            return Err(Error::field("vary.fits", fault));
        }
        let mut members = self.warm.members.lock().unwrap_or_else(PoisonError::into_inner);
        for member in twin.members.iter().take(count.saturating_sub(1)).skip(members.len()) {
            members.push(backend.load(Arc::new(Model::from(&member.twin(twin))))?);
        }
        let others = members.iter().take(count.saturating_sub(1)).cloned();
        Ok(std::iter::once(self.loaded.clone()).chain(others).collect())
    }

    async fn fast(warm: Arc<Warm>, device: &Device) -> Result<Self, Error> {
        let missing = || rollout::Error::NoFastVariant { twin: warm.id.to_string() };
        let fast = warm.twin.quality.fast.ok_or_else(missing)?;
        let load = || async {
            let backend = device.backend(Priority::Interactive);
            let exact = Arc::clone(warm.loaded.model());
            let load = move || backend.load(Arc::new(Reduction::from(&fast).apply(&exact)));
            let loaded = tokio::task::spawn_blocking(load).await.map_err(|_| Error::Panicked)??;
            tracing::info!(twin = %warm.id, substeps = fast.substeps, "fast variant loaded");
            Ok::<_, Error>(loaded)
        };
        let loaded = warm.fast.get_or_try_init(load).await?.clone();
        Ok(Self { warm, loaded, fast: Some(fast), planner: None, rests: Vec::new() })
    }

    async fn planner(of: Arc<Warm>, device: &Device) -> Result<Self, Error> {
        let load = || async {
            let (backend, twin) = (device.backend(Priority::Interactive), Arc::clone(&of));
            let load = move || PlannersWarm::load(&twin, &backend);
            let own = tokio::task::spawn_blocking(load).await.map_err(|_| Error::Panicked)??;
            tracing::info!(twin = %of.id, "planner's twin loaded");
            Ok::<_, Error>(Arc::new(own))
        };
        let own = Arc::clone(of.planner.get_or_try_init(load).await?);
        let (warm, loaded) = (Arc::clone(&own.warm), own.warm.loaded.clone());
        Ok(Self { warm, loaded, fast: None, planner: Some(Planner { of, own }), rests: Vec::new() })
    }
}
