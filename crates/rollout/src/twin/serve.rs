//! The model of a twin that answers a request: the exact one, the fast one or the planner's twin, which
//! are made when they are first asked for.

use std::{
    collections::HashSet,
    sync::{Arc, Mutex, PoisonError},
};

use bendtwin_contract::rollout;
use bendtwin_core::{FastVariant, Fidelity, Twin};
use bendtwin_engine::{Backend, Loaded, Model, fidelity::Reduction};

use crate::{
    error::Error,
    twin::{planner::PlannersWarm, rest_shape::RestShape, warm::Warm},
};

/// A twin and the model of it that answers.
#[derive(Clone)]
pub struct Served {
    pub(crate) warm: Arc<Warm>,
    pub(crate) loaded: Loaded,
    /// The variant, if the fast one answers.
    pub(crate) fast: Option<FastVariant>,
    /// The planner's twin, if it answers; `warm` is its own then.
    pub(crate) planner: Option<Planner>,
    /// Rest shapes that are not the twin's: one for all instances, or one for each; empty: none.
    pub(crate) rests: Vec<Option<Arc<RestShape>>>,
}

/// The planner's twin that answers, and the twin that requests are about.
#[derive(Clone)]
pub(crate) struct Planner {
    pub(crate) of: Arc<Warm>,
    pub(crate) own: Arc<PlannersWarm>,
}

impl Served {
    /// The model that follows a twin as finely as asked for, loaded if it is the first time.
    ///
    /// # Errors
    /// If the twin has no such variant, or the backend fails.
    pub fn choose(
        warm: Arc<Warm>,
        fidelity: Fidelity,
        backend: &dyn Backend,
    ) -> Result<Self, Error> {
        match fidelity {
            Fidelity::Exact => Ok(Self::exact(warm)),
            Fidelity::Fast => Self::fast(warm, backend),
            Fidelity::Planner => Self::planner(warm, backend),
        }
    }

    /// The exact model.
    pub fn exact(warm: Arc<Warm>) -> Self {
        let loaded = warm.loaded.clone();
        Self { warm, loaded, fast: None, planner: None, rests: Vec::new() }
    }

    /// The twin that requests are about.
    pub(crate) fn twin(&self) -> &Twin {
        self.planner.as_ref().map_or(&self.warm.twin, |planner| &planner.of.twin)
    }

    /// The twin in states with these rest shapes: one for all instances, or one for each.
    ///
    /// # Errors
    /// If the planner's twin answers and one is not the twin's: it would not fit into the small model.
    pub fn with_rests(self, rests: Vec<Option<Arc<RestShape>>>) -> Result<Self, Error> {
        if self.planner.is_some() && rests.iter().any(Option::is_some) {
            let fault = "is PLANNER, which has the rest shape that was fitted, and a correction has changed that of the state: begin in another state, or ask for EXACT or FAST";
            return Err(Error::field("fidelity", fault));
        }
        Ok(Self { rests, ..self })
    }

    /// Number of rest shapes that are not the twin's.
    pub(crate) fn distinct_rests(&self) -> usize {
        self.rests.iter().flatten().map(Arc::as_ptr).collect::<HashSet<_>>().len()
    }

    /// The first `count` fits: the twin and its members, which are loaded on first use.
    pub(crate) fn fits(&self, count: usize, backend: &dyn Backend) -> Result<Vec<Loaded>, Error> {
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

    fn fast(warm: Arc<Warm>, backend: &dyn Backend) -> Result<Self, Error> {
        let missing = || rollout::Error::NoFastVariant { twin: warm.id.to_string() };
        let fast = warm.twin.quality.fast.ok_or_else(missing)?;
        let loaded = once(&warm.fast, || {
            let reduced = Reduction::from(&fast).apply(warm.loaded.model());
            let loaded = backend.load(Arc::new(reduced))?;
            tracing::info!(twin = %warm.id, substeps = fast.substeps, "fast variant loaded");
            Ok(loaded)
        })?;
        Ok(Self { warm, loaded, fast: Some(fast), planner: None, rests: Vec::new() })
    }

    fn planner(of: Arc<Warm>, backend: &dyn Backend) -> Result<Self, Error> {
        let own = once(&of.planner, || {
            let own = PlannersWarm::load(&of, backend)?;
            tracing::info!(twin = %of.id, "planner's twin loaded");
            Ok(Arc::new(own))
        })?;
        let (warm, loaded) = (Arc::clone(&own.warm), own.warm.loaded.clone());
        Ok(Self { warm, loaded, fast: None, planner: Some(Planner { of, own }), rests: Vec::new() })
    }
}

/// A value that the first caller makes; others wait for it meanwhile.
fn once<T: Clone>(
    there: &Mutex<Option<T>>,
    make: impl FnOnce() -> Result<T, Error>,
) -> Result<T, Error> {
    let mut there = there.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(made) = &*there {
        return Ok(made.clone());
    }
    let made = make()?;
    *there = Some(made.clone());
    Ok(made)
}
