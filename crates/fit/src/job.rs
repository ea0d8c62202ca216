//! A fit from its capture to its twin.

use std::sync::Arc;

use bendtwin_core::{
    CancelToken, Capture, FitSettings, Observer, Progress, Stage, Twin, quality::Predictor,
};
use bendtwin_engine::{Backend, backend};
use bendtwin_eval::{EvaluateOptions, evaluate, fast_variant};

use crate::{
    Error,
    checkpoint::{Checkpoint, Identity, VariantState},
    cmaes::default_population,
    meter::{Meter, Report},
    refine::Refinement,
    search::Search,
    task::Task,
    variant::{Variant, model_name},
    warnings,
};

/// One fit: what to fit, how, and on which device.
#[derive(Clone)]
pub struct FitJob<'a> {
    /// What was recorded.
    pub capture: &'a Capture,
    /// BLAKE3 digest of the capture's content, hex; kept in the twin's provenance.
    pub capture_digest: String,
    /// How to fit.
    pub settings: FitSettings,
    /// What simulates.
    pub backend: Arc<dyn Backend>,
}

/// What a fit makes.
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
        let task = Task::new(self.capture, &self.settings)?;
        let mut run = Run::new(self, &task, observer, cancel);
        let states = match checkpoint {
            Some(bytes) => run.restore(bytes)?,
            None => run.variants.iter().map(Variant::begin).collect(),
        };
        let states = run.search(states)?;
        let finished = run.refine(states)?;
        run.evaluate(finished)
    }
}

/// A fit under way.
struct Run<'a> {
    job: &'a FitJob<'a>,
    task: &'a Task<'a>,
    variants: Vec<Variant>,
    identity: Identity,
    meter: Meter,
    observer: &'a mut dyn Observer<Progress>,
    cancel: &'a CancelToken,
}

/// A model whose refinement is done.
struct Finished {
    twin: Twin,
    warnings: Vec<String>,
}

impl<'a> Run<'a> {
    fn new(
        job: &'a FitJob<'a>,
        task: &'a Task<'a>,
        observer: &'a mut dyn Observer<Progress>,
        cancel: &'a CancelToken,
    ) -> Self {
        let variants = Variant::all(task);
        let identity = Identity {
            capture_digest: job.capture_digest.clone(),
            settings: job.settings.clone(),
            backend: job.backend.device().kind,
        };
        let search_frames = task.search_set().iter().map(|t| t.frames).sum();
        let population = match job.settings.search.population {
            0 => default_population(variants[0].space.start().len()),
            n => n,
        };
        let meter = Meter::new(task, search_frames, population);
        Self { job, task, variants, identity, meter, observer, cancel }
    }

    fn restore(&self, bytes: &[u8]) -> Result<Vec<VariantState>, Error> {
        let checkpoint = Checkpoint::from_bytes(bytes, &self.identity)?;
        if checkpoint.variants.len() == self.variants.len() {
            Ok(checkpoint.variants)
        } else {
            Err(Error::Checkpoint("it has another number of variants".into()))
        }
    }

    fn keep(&mut self, variants: Vec<VariantState>) -> Result<(), Error> {
        let checkpoint = Checkpoint { variants }.to_bytes(&self.identity)?;
        self.observer.checkpoint(checkpoint).map_err(Error::Observer)
    }

    fn report(&mut self, report: Report<'_>) {
        let progress = self.meter.progress(report);
        self.observer.progress(progress);
    }

    fn check_cancelled(&self) -> Result<(), Error> {
        if self.cancel.is_cancelled() { Err(backend::Error::Cancelled.into()) } else { Ok(()) }
    }

    /// Generations until all are done; states that are past the search come back as they are.
    fn search(&mut self, mut states: Vec<VariantState>) -> Result<Vec<VariantState>, Error> {
        let generations = u64::from(self.task.generations());
        let mut search = Search::new(self.task);
        loop {
            self.check_cancelled()?;
            let mut open: Vec<_> = self
                .variants
                .iter()
                .zip(&mut states)
                .filter_map(|(variant, state)| match state {
                    VariantState::Search(cma) => Some((&variant.space, cma)),
                    VariantState::Refine { .. } => None,
                })
                .filter(|(_, cma)| cma.generation() < generations)
                .collect();
            if open.is_empty() {
                return Ok(states);
            }
            let results = search.generation(&mut open, &*self.job.backend, self.cancel)?;
            self.keep(states.clone())?;
            for (index, result) in results.into_iter().enumerate() {
                let VariantState::Search(cma) = &states[index] else { continue };
                let losses = result.losses.iter().copied();
                let (best, done) = (cma.best().map(|b| b.loss), cma.generation() as u32);
                let variant = &self.variants[index].name.clone();
                self.report(Report {
                    variant,
                    stage: Stage::Search,
                    iteration: done,
                    loss: losses.clone().reduce(f64::min),
                    best_loss: best,
                    note: result.failures.note(losses.len()),
                });
            }
        }
    }

    /// Passes until all are done; the best start of each model comes back.
    fn refine(&mut self, mut states: Vec<VariantState>) -> Result<Vec<Finished>, Error> {
        let backend = &*self.job.backend;
        // Variants whose search found something to refine: of several starts not all have to.
        let (mut found, mut points, mut walks) = (Vec::new(), Vec::new(), Vec::new());
        let mut nothing = None;
        for (index, (variant, state)) in self.variants.iter().zip(&states).enumerate() {
            match variant.walk(self.task, state, backend) {
                Ok((point, walk)) => {
                    found.push(index);
                    points.push(point);
                    walks.push(walk);
                }
                Err(Error::NothingStable(why)) => nothing = Some(Error::NothingStable(why)),
                Err(e) => return Err(e),
            }
        }
        let has_found =
            |v: &Variant| found.iter().any(|&at| self.variants[at].bending == v.bending);
        if let (Some(nothing), false) = (nothing, self.variants.iter().all(has_found)) {
            return Err(nothing);
        }
        let mut refinement = Refinement::new(self.task, walks, backend, self.cancel)?;
        if found.iter().any(|&index| matches!(states[index], VariantState::Search(_))) {
            refinement.begin()?;
        }
        let passes = self.job.settings.refine.passes;
        while refinement.walks.iter().any(|w| w.state.pass < passes) {
            self.check_cancelled()?;
            refinement.pass()?;
            for ((&index, point), walk) in found.iter().zip(&points).zip(&refinement.walks) {
                let (point, walk) = (point.clone(), walk.state.clone());
                states[index] = VariantState::Refine { point, walk };
            }
            self.keep(states.clone())?;
            for (&index, walk) in found.iter().zip(&mut refinement.walks) {
                let variant = &self.variants[index].name.clone();
                self.report(Report {
                    variant,
                    stage: Stage::Refine,
                    iteration: walk.state.pass,
                    loss: Some(walk.state.loss),
                    best_loss: Some(walk.state.best.loss),
                    note: walk.note.take(),
                });
            }
        }
        let mut finished = Vec::new();
        for starts in self.variants.chunk_by(|a, b| a.bending == b.bending) {
            let bending = starts[0].bending;
            let starts = (0..found.len()).filter(|&at| self.variants[found[at]].bending == bending);
            let loss = |at: &usize| refinement.walks[*at].state.best.loss;
            let Some(best) = starts.min_by(|a, b| loss(a).total_cmp(&loss(b))) else { continue };
            let variant = &self.variants[found[best]];
            let twin = variant.twin(self.job, &refinement.walks[best])?;
            let (fabric, ..) = variant.realise(self.task, &points[best]);
            let warnings = warnings::of_fit(self.task, variant, &points[best], &fabric);
            finished.push(Finished { twin, warnings });
        }
        Ok(finished)
    }

    /// The quality table, the fast variant, and the end.
    fn evaluate(&mut self, finished: Vec<Finished>) -> Result<Outcome, Error> {
        self.check_cancelled()?;
        let variant = model_name(self.variants[0].bending);
        let report = |iteration: u32| Report {
            variant,
            stage: Stage::Evaluate,
            iteration,
            loss: None,
            best_loss: None,
            note: None,
        };
        self.report(report(0));
        let mut finished = finished.into_iter();
        let Some(Finished { mut twin, warnings }) = finished.next() else {
            return Err(Error::NothingStable("there is no variant".into()));
        };
        let mut axial = finished.next().map(|f| f.twin);
        let options = EvaluateOptions { axial: axial.as_ref(), per_frame: false };
        let mut quality =
            evaluate(&*self.job.backend, &twin, self.job.capture, &options, self.cancel)?;
        quality.warnings.splice(0..0, warnings);
        if let Some(axial) = &mut axial {
            let row = quality.score(Predictor::Axial).cloned();
            axial.quality.scores = row.into_iter().collect();
        }
        quality.fast = fast_variant(&*self.job.backend, &twin, self.job.capture, self.cancel)?;
        twin.quality = quality;
        self.report(report(1));
        Ok(Outcome { twin, axial })
    }
}

#[cfg(test)]
mod tests;
