//! The zeroth-order stage: CMA-ES over global variables. A generation of all variants is one batch,
//! every candidate with its own graph; the host's threads prepare its candidates side by side.

use std::sync::Arc;

use bendtwin_core::CancelToken;
use bendtwin_engine::{Backend, Loaded, backend};
use rayon::prelude::*;

use crate::{
    Error,
    cmaes::CmaEs,
    fabric::{Fabric, Fabrics, Refusal, load, model},
    space::{Candidate, Space},
    submit,
    task::{Task, Training},
};

/// Why candidates of a generation failed, for the progress note.
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

/// One variant's part of a generation.
pub(crate) struct Generation {
    pub(crate) losses: Vec<f64>,
    pub(crate) failures: Failures,
}

/// What the search of all variants needs.
pub(crate) struct Search<'a> {
    task: &'a Task<'a>,
    set: Vec<Training<'a>>,
    fabrics: Fabrics,
}

impl<'a> Search<'a> {
    pub(crate) fn new(task: &'a Task<'a>) -> Self {
        Self { task, set: task.search_set(), fabrics: Fabrics::default() }
    }

    /// Candidates of a generation, evaluated and told to their strategies.
    pub(crate) fn generation(
        &mut self,
        variants: &mut [(&Space, &mut CmaEs)],
        backend: &dyn Backend,
        cancel: &CancelToken,
    ) -> Result<Vec<Generation>, Error> {
        let asked: Vec<_> = variants.iter().map(|(_, strategy)| strategy.ask()).collect();
        let of = variants.iter().zip(&asked);
        let candidates: Vec<Candidate> = of
            .flat_map(|((space, _), samples)| samples.iter().map(|s| space.candidate(&s.point)))
            .collect();
        let mut batch = Vec::new();
        // Where each candidate's instances begin, unless it was refused.
        let mut first = Vec::with_capacity(candidates.len());
        for loaded in self.load(&candidates, backend, cancel)? {
            first.push(loaded.is_ok().then_some(batch.len()));
            if let Ok(loaded) = &loaded {
                batch.extend(self.set.iter().map(|t| t.instance(loaded)));
            }
        }
        let losses = submit::losses(backend, &batch, cancel)?;
        let mean =
            |at: usize| self.task.loss(losses[at..at + self.set.len()].iter().map(|l| l.total));
        let mut first = first.into_iter();
        let mut generations = Vec::with_capacity(asked.len());
        for (samples, (_, strategy)) in asked.iter().zip(variants) {
            let first: Vec<_> = first.by_ref().take(samples.len()).collect();
            let too_stiff = first.iter().filter(|at| at.is_none()).count() as u32;
            let losses: Vec<f64> =
                first.into_iter().map(|at| at.map_or(f64::INFINITY, mean)).collect();
            let failed = losses.iter().filter(|l| !l.is_finite()).count() as u32;
            strategy.tell(samples, &losses);
            let failures = Failures { too_stiff, diverged: failed - too_stiff };
            generations.push(Generation { losses, failures });
        }
        Ok(generations)
    }

    /// The candidates on the device, in their order.
    fn load(
        &mut self,
        candidates: &[Candidate],
        backend: &dyn Backend,
        cancel: &CancelToken,
    ) -> Result<Vec<Result<Loaded, Refusal>>, Error> {
        let wanted: Vec<_> = candidates.iter().map(|c| c.connectivity).collect();
        let fabrics = self.fabrics.all(self.task, &wanted, cancel)?;
        let one = |(candidate, fabric): (&Candidate, &Arc<Fabric>)| {
            if cancel.is_cancelled() {
                return Err(backend::Error::Cancelled);
            }
            let params = candidate.params(fabric);
            let environment = candidate.environment(self.task.capture.environment);
            match model(self.task, &fabric.graph, params, environment) {
                Ok(model) => load(backend, model),
                Err(refusal) => Ok(Err(refusal)),
            }
        };
        // All of them before the first error is looked for: which one that is depends on no thread.
        let loaded: Vec<_> = candidates.par_iter().zip(&fabrics).map(one).collect();
        Ok(loaded.into_iter().collect::<Result<_, _>>()?)
    }
}
