//! The zeroth-order stage: CMA-ES over global variables. A generation of all models is one batch,
//! every candidate with its own graph; the host's threads prepare the candidates in parallel, as
//! many at a time as a bound on their memory allows.

pub(crate) mod cmaes;
pub(crate) mod space;

use std::sync::Arc;

use bendtwin_core::{
    CancelToken,
    settings::memory::{GENERATION_BYTES, GraphSize},
};
use bendtwin_engine::{Backend, Loaded, backend};
use rayon::prelude::*;

use self::{
    cmaes::{CmaEs, Sample},
    space::{Candidate, Space},
};
use crate::{
    Error,
    built_graph::{BuiltGraph, GraphCache, LoadError, build_model, load},
    memory, submit,
    task::{Task, Training},
};

/// Counts of the candidates of a generation that failed, by reason.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Failures {
    pub(crate) too_stiff: u32,
    pub(crate) diverged: u32,
}

impl Failures {
    pub(crate) fn note(self, candidates: usize) -> Option<String> {
        let mut parts = Vec::new();
        if self.too_stiff > 0 {
            parts.push(format!("{} need more substeps than allowed", self.too_stiff));
        }
        if self.diverged > 0 {
            parts.push(format!("{} diverged", self.diverged));
        }
        (!parts.is_empty()).then(|| format!("of {candidates} candidates, {}", parts.join(", ")))
    }
}

/// A model's search strategy, and the space that it searches.
pub(crate) struct Searcher<'m> {
    /// Index of the model in the fit.
    pub(crate) model: usize,
    pub(crate) space: &'m Space,
    pub(crate) strategy: &'m mut CmaEs,
}

/// A model's part of a generation.
pub(crate) struct Generation {
    /// Index of the model in the fit.
    pub(crate) model: usize,
    /// Losses of the candidates, each with the [`Space::penalty`] of its distance from the start.
    pub(crate) losses: Vec<f64>,
    pub(crate) failures: Failures,
}

/// The search of all models.
pub(crate) struct Search<'a> {
    task: &'a Task<'a>,
    set: Vec<Training<'a>>,
    graphs: GraphCache,
    /// Candidates that are loaded at a time, unless a slice needs more.
    most_loaded: usize,
}

impl<'a> Search<'a> {
    pub(crate) fn new(task: &'a Task<'a>) -> Self {
        let size = GraphSize::largest(&task.settings, &memory::size_of(task.capture, None));
        let most = GENERATION_BYTES / size.candidate_bytes().max(1);
        let most_loaded = usize::try_from(most).unwrap_or(usize::MAX).max(1);
        Self { task, set: task.search_set(), graphs: GraphCache::default(), most_loaded }
    }

    /// Limits the candidates loaded at a time to `most_loaded`, unless a slice needs more.
    #[cfg(test)]
    pub(crate) fn with_most_loaded(self, most_loaded: usize) -> Self {
        Self { most_loaded, ..self }
    }

    /// Evaluates one generation of candidates and passes the losses to their strategies.
    pub(crate) fn generation(
        &mut self,
        searchers: &mut [Searcher<'_>],
        backend: &dyn Backend,
        cancel: &CancelToken,
    ) -> Result<Vec<Generation>, Error> {
        let asked: Vec<_> = searchers.iter().map(|s| s.strategy.ask()).collect();
        let of = searchers.iter().zip(&asked);
        let candidates: Vec<Candidate> = of
            .flat_map(|(of, samples)| samples.iter().map(|s| of.space.candidate(&s.point)))
            .collect();
        // Index of each candidate's first instance; none if it was refused.
        let mut first = Vec::with_capacity(candidates.len());
        let (mut batch, mut count, mut losses) = (Vec::new(), 0, Vec::new());
        let slice = submit::slice_len(backend);
        let a_slice = slice.div_ceil(self.set.len().max(1));
        for part in candidates.chunks(self.most_loaded.max(a_slice)) {
            for loaded in self.load(part, backend, cancel)? {
                first.push(loaded.is_some().then_some(count));
                if let Some(loaded) = &loaded {
                    batch.extend(self.set.iter().map(|t| t.instance(loaded)));
                    count += self.set.len();
                }
            }
            // Whole slices, so that instances are simulated together with the same others for any
            // number of candidates loaded at a time. Finished ones are dropped.
            let whole = batch.len() - batch.len() % slice.max(1);
            losses.extend(submit::losses(backend, &batch[..whole], cancel)?);
            batch.drain(..whole);
        }
        losses.extend(submit::losses(backend, &batch, cancel)?);
        let mean =
            |at: usize| self.task.loss(losses[at..at + self.set.len()].iter().map(|l| l.total));
        let mut first = first.into_iter();
        let mut generations = Vec::with_capacity(asked.len());
        for (samples, searcher) in asked.iter().zip(searchers) {
            let first: Vec<_> = first.by_ref().take(samples.len()).collect();
            let too_stiff = first.iter().filter(|at| at.is_none()).count() as u32;
            let losses: Vec<f64> =
                first.into_iter().map(|at| at.map_or(f64::INFINITY, mean)).collect();
            let failed = losses.iter().filter(|l| !l.is_finite()).count() as u32;
            let prior = self.task.search_prior();
            let penalty = |s: &Sample| searcher.space.penalty(&s.point, prior);
            let losses: Vec<f64> =
                losses.iter().zip(samples).map(|(loss, s)| loss * penalty(s)).collect();
            searcher.strategy.tell(samples, &losses);
            let failures = Failures { too_stiff, diverged: failed - too_stiff };
            generations.push(Generation { model: searcher.model, losses, failures });
        }
        Ok(generations)
    }

    /// The candidates on the device, in their order; `None` for those that are too stiff.
    fn load(
        &mut self,
        candidates: &[Candidate],
        backend: &dyn Backend,
        cancel: &CancelToken,
    ) -> Result<Vec<Option<Loaded>>, Error> {
        let wanted: Vec<_> = candidates.iter().map(|c| c.connectivity).collect();
        let graphs = self.graphs.all(self.task, &wanted, cancel)?;
        let one = |(candidate, built): (&Candidate, &Arc<BuiltGraph>)| {
            if cancel.is_cancelled() {
                return Err(backend::Error::Cancelled);
            }
            let params = candidate.params(built);
            let environment = candidate.environment(self.task.capture.environment);
            let model = build_model(self.task, &built.graph, params, environment);
            match model.and_then(|model| load(backend, model)) {
                Ok(loaded) => Ok(Some(loaded)),
                Err(LoadError::TooStiff(_)) => Ok(None),
                Err(LoadError::Backend(error)) => Err(error),
            }
        };
        // All are loaded before the first error is returned, so that it depends on no thread.
        let loaded: Vec<_> = candidates.par_iter().zip(&graphs).map(one).collect();
        Ok(loaded.into_iter().collect::<Result<_, _>>()?)
    }
}

#[cfg(test)]
mod tests;
