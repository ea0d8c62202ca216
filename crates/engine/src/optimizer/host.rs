//! An optimizer over any backend's `gradients` and `with_params`: chain rule and Adam in f64 on
//! the host.

use std::sync::Arc;

use bendtwin_core::{CancelToken, Timing};

use super::{
    Bounds, Decay, GradientNorm, GradientSample, Optimizer, OptimizerInit, Parameterization,
    Position,
};
use crate::{
    Model,
    backend::{Backend, Error, GradientRequest, Instance, Loaded},
};

/// The CPU backend's optimizer, and the reference that others are compared with.
pub struct HostOptimizer {
    backend: Arc<dyn Backend>,
    decay: Decay,
    runs: Vec<Run>,
}

struct Run {
    loaded: Loaded,
    parameterization: Parameterization,
    rates: Vec<f64>,
    position: Position,
    /// d loss / d theta, shape [pending, theta].
    pending: Vec<Vec<f64>>,
}

impl HostOptimizer {
    /// Optimizer runs from these initial states; `backend` must be the one that loaded them.
    ///
    /// # Errors
    /// If a start contradicts itself, or as [`Backend::with_params`].
    pub fn new(
        backend: Arc<dyn Backend>,
        inits: Vec<OptimizerInit>,
        decay: Decay,
    ) -> Result<Self, Error> {
        let begin = |start: OptimizerInit| {
            start.check()?;
            let OptimizerInit { loaded, parameterization, position } = start;
            let loaded = backend.with_params(&loaded, parameterization.params(&position.theta))?;
            let rates = parameterization.rates().collect();
            Ok(Run { loaded, parameterization, rates, position, pending: Vec::new() })
        };
        let runs = inits.into_iter().map(begin).collect::<Result<_, Error>>()?;
        Ok(Self { backend, decay, runs })
    }

    fn run(&mut self, run: usize) -> Result<&mut Run, Error> {
        let count = self.runs.len();
        self.runs.get_mut(run).ok_or_else(|| unknown(run, count))
    }
}

fn unknown(run: usize, count: usize) -> Error {
    Error::InvalidInput(format!("run {run} does not exist: there are {count}"))
}

impl Optimizer for HostOptimizer {
    fn loaded(&mut self, run: usize) -> Result<Loaded, Error> {
        Ok(self.run(run)?.loaded.clone())
    }

    fn measure(
        &mut self,
        batch: &[GradientSample],
        request: &GradientRequest,
        cancel: &CancelToken,
    ) -> Result<Vec<GradientNorm>, Error> {
        let here = |sample: &GradientSample| {
            let model = self.run(sample.run)?.loaded.clone();
            Ok(Instance { model, ..sample.instance.clone() })
        };
        let instances = batch.iter().map(here).collect::<Result<Vec<_>, Error>>()?;
        let request = GradientRequest { controls: false, initial: false, ..*request };
        let gradients = self.backend.gradients(&instances, &request, cancel)?;
        if gradients.len() != batch.len() {
            let fault = format!("{} gradients for {} instances", gradients.len(), batch.len());
            return Err(Error::Device(fault));
        }
        let mut norms = Vec::with_capacity(batch.len());
        for (sample, gradient) in batch.iter().zip(gradients) {
            let run = self.run(sample.run)?;
            let own = run.parameterization.gradient(&run.loaded.model().params, &gradient.params);
            let norm = if gradient.overflowed {
                f64::INFINITY
            } else {
                own.iter().map(|x| x * x).sum::<f64>().sqrt()
            };
            run.pending.push(own);
            let (loss, final_state) = (gradient.loss, gradient.final_state);
            norms.push(GradientNorm { loss, norm, final_state });
        }
        Ok(norms)
    }

    fn step(&mut self, run: usize, weights: &[f64], rate: f64) -> Result<(), Error> {
        let (backend, decay) = (self.backend.clone(), self.decay);
        let run = self.run(run)?;
        if weights.len() != run.pending.len() {
            let (n, pending) = (weights.len(), run.pending.len());
            return Err(Error::InvalidInput(format!("{n} weights for {pending} gradients")));
        }
        let mut sum = vec![0.0; run.parameterization.len()];
        for (gradient, weight) in run.pending.iter().zip(weights) {
            sum.iter_mut().zip(gradient).for_each(|(s, g)| *s += weight * g);
        }
        if !rate.is_finite() || sum.iter().any(|g| !g.is_finite()) {
            return Err(Error::InvalidInput("rate and weighted gradient must be finite".into()));
        }
        let start = run.parameterization.start();
        let bounds = Bounds {
            kinds: &run.parameterization.kinds(),
            rates: &run.rates,
            bounds: run.parameterization.bounds(),
            start: &start,
        };
        let mut next = run.position.clone();
        next.adam.step(&mut next.theta, &sum, rate, bounds, decay);
        run.loaded = backend.with_params(&run.loaded, run.parameterization.params(&next.theta))?;
        run.position = next;
        run.pending.clear();
        Ok(())
    }

    fn discard(&mut self, run: usize) -> Result<(), Error> {
        self.run(run)?.pending.clear();
        Ok(())
    }

    fn position(&self, run: usize) -> Result<Position, Error> {
        let found = self.runs.get(run).map(|w| w.position.clone());
        found.ok_or_else(|| unknown(run, self.runs.len()))
    }

    fn move_to(&mut self, run: usize, position: &Position, timing: Timing) -> Result<(), Error> {
        let backend = self.backend.clone();
        let run = self.run(run)?;
        run.parameterization.check_position(position)?;
        let params = run.parameterization.params(&position.theta);
        let model = Model { params, timing, ..Model::clone(run.loaded.model()) };
        run.loaded = backend.load(Arc::new(model))?;
        run.position = position.clone();
        run.pending.clear();
        Ok(())
    }
}
