//! The zeroth-order stage: CMA-ES over global variables. A generation of all variants is one batch,
//! every candidate with its own graph.

use bendtwin_engine::{Backend, Loaded, backend::CancelToken};

use crate::{
    Error,
    cmaes::{CmaEs, Sample},
    fabric::{Fabrics, Refusal, load, model},
    space::Space,
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
        let mut batch = Vec::new();
        let mut asked: Vec<(Vec<Sample>, Vec<Option<usize>>, Failures)> = Vec::new();
        for (space, strategy) in variants.iter() {
            let samples = strategy.ask();
            let mut first = Vec::with_capacity(samples.len());
            let mut failures = Failures::default();
            for sample in &samples {
                if cancel.is_cancelled() {
                    return Err(bendtwin_engine::Error::Cancelled.into());
                }
                match self.load(space, &sample.point, backend)? {
                    Ok(loaded) => {
                        first.push(Some(batch.len()));
                        batch.extend(self.set.iter().map(|t| t.instance(&loaded)));
                    }
                    Err(Refusal::TooStiff(_)) => {
                        failures.too_stiff += 1;
                        first.push(None);
                    }
                }
            }
            asked.push((samples, first, failures));
        }
        let losses = submit::losses(backend, &batch, cancel)?;
        let mut generations = Vec::with_capacity(asked.len());
        for ((samples, first, mut failures), (_, strategy)) in asked.into_iter().zip(variants) {
            let mean = |at: usize| {
                let all = &losses[at..at + self.set.len()];
                all.iter().map(|l| l.total).sum::<f64>() / all.len() as f64
            };
            let losses: Vec<f64> =
                first.into_iter().map(|at| at.map_or(f64::INFINITY, mean)).collect();
            let failed = losses.iter().filter(|l| !l.is_finite()).count() as u32;
            failures.diverged = failed - failures.too_stiff;
            strategy.tell(&samples, &losses);
            generations.push(Generation { losses, failures });
        }
        Ok(generations)
    }

    fn load(
        &mut self,
        space: &Space,
        point: &[f64],
        backend: &dyn Backend,
    ) -> Result<Result<Loaded, Refusal>, Error> {
        let candidate = space.candidate(point);
        let fabric = self.fabrics.get(self.task, &candidate.connectivity);
        let params = candidate.params(&fabric.rest_lengths_m, &fabric.rest_angles_rad);
        Ok(match model(self.task, &fabric.graph, params) {
            Ok(model) => load(backend, model)?,
            Err(refusal) => Err(refusal),
        })
    }
}
