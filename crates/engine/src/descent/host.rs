//! A descent over any backend's `gradients` and `with_params`: chain rule and Adam in f64 on the host.

use std::sync::Arc;

use bendtwin_core::{CancelToken, Timing};

use super::{Chart, Decay, Descent, Ground, Position, Probe, Slope, Start};
use crate::{
    Model,
    backend::{Backend, Error, GradientRequest, Instance, Loaded},
};

/// What the CPU walks with, and the definition of correct for others.
pub struct HostDescent {
    backend: Arc<dyn Backend>,
    decay: Decay,
    walks: Vec<Walk>,
}

struct Walk {
    loaded: Loaded,
    chart: Chart,
    rates: Vec<f64>,
    position: Position,
    /// d loss / d theta, shape [waiting, theta].
    waiting: Vec<Vec<f64>>,
}

impl HostDescent {
    /// Walks that begin at these starts; `backend` must be the one that loaded them.
    ///
    /// # Errors
    /// If a start contradicts itself, or as [`Backend::with_params`].
    pub fn new(backend: Arc<dyn Backend>, starts: Vec<Start>, decay: Decay) -> Result<Self, Error> {
        let begin = |start: Start| {
            start.check()?;
            let Start { loaded, chart, position } = start;
            let loaded = backend.with_params(&loaded, chart.params(&position.theta))?;
            let rates = chart.rates().collect();
            Ok(Walk { loaded, chart, rates, position, waiting: Vec::new() })
        };
        let walks = starts.into_iter().map(begin).collect::<Result<_, Error>>()?;
        Ok(Self { backend, decay, walks })
    }

    fn walk(&mut self, walk: usize) -> Result<&mut Walk, Error> {
        let count = self.walks.len();
        self.walks.get_mut(walk).ok_or_else(|| unknown(walk, count))
    }
}

fn unknown(walk: usize, count: usize) -> Error {
    Error::InvalidInput(format!("walk {walk} does not exist: there are {count}"))
}

impl Descent for HostDescent {
    fn loaded(&mut self, walk: usize) -> Result<Loaded, Error> {
        Ok(self.walk(walk)?.loaded.clone())
    }

    fn measure(
        &mut self,
        batch: &[Probe],
        request: &GradientRequest,
        cancel: &CancelToken,
    ) -> Result<Vec<Slope>, Error> {
        let here = |probe: &Probe| {
            let model = self.walk(probe.walk)?.loaded.clone();
            Ok(Instance { model, ..probe.instance.clone() })
        };
        let instances = batch.iter().map(here).collect::<Result<Vec<_>, Error>>()?;
        let request = GradientRequest { controls: false, initial: false, ..*request };
        let gradients = self.backend.gradients(&instances, &request, cancel)?;
        if gradients.len() != batch.len() {
            let fault = format!("{} gradients for {} instances", gradients.len(), batch.len());
            return Err(Error::Device(fault));
        }
        let mut slopes = Vec::with_capacity(batch.len());
        for (probe, gradient) in batch.iter().zip(gradients) {
            let walk = self.walk(probe.walk)?;
            let own = walk.chart.gradient(&walk.loaded.model().params, &gradient.params);
            let length = match gradient.overflowed {
                true => f64::INFINITY,
                false => own.iter().map(|x| x * x).sum::<f64>().sqrt(),
            };
            walk.waiting.push(own);
            let (loss, final_state) = (gradient.loss, gradient.final_state);
            slopes.push(Slope { loss, length, final_state });
        }
        Ok(slopes)
    }

    fn step(&mut self, walk: usize, weights: &[f64], rate: f64) -> Result<(), Error> {
        let (backend, decay) = (self.backend.clone(), self.decay);
        let walk = self.walk(walk)?;
        if weights.len() != walk.waiting.len() {
            let (n, waiting) = (weights.len(), walk.waiting.len());
            return Err(Error::InvalidInput(format!("{n} weights for {waiting} gradients")));
        }
        let mut sum = vec![0.0; walk.chart.len()];
        for (gradient, weight) in walk.waiting.iter().zip(weights) {
            sum.iter_mut().zip(gradient).for_each(|(s, g)| *s += weight * g);
        }
        if !rate.is_finite() || sum.iter().any(|g| !g.is_finite()) {
            return Err(Error::InvalidInput("rate and weighted gradient must be finite".into()));
        }
        let start = walk.chart.start();
        let ground = Ground { rates: &walk.rates, bounds: walk.chart.bounds(), start: &start };
        let mut next = walk.position.clone();
        next.adam.step(&mut next.theta, &sum, rate, ground, decay);
        walk.loaded = backend.with_params(&walk.loaded, walk.chart.params(&next.theta))?;
        walk.position = next;
        walk.waiting.clear();
        Ok(())
    }

    fn discard(&mut self, walk: usize) -> Result<(), Error> {
        self.walk(walk)?.waiting.clear();
        Ok(())
    }

    fn position(&self, walk: usize) -> Result<Position, Error> {
        let found = self.walks.get(walk).map(|w| w.position.clone());
        found.ok_or_else(|| unknown(walk, self.walks.len()))
    }

    fn move_to(&mut self, walk: usize, position: &Position, timing: Timing) -> Result<(), Error> {
        let backend = self.backend.clone();
        let walk = self.walk(walk)?;
        walk.chart.check_position(position)?;
        let params = walk.chart.params(&position.theta);
        let model = Model { params, timing, ..Model::clone(walk.loaded.model()) };
        walk.loaded = backend.load(Arc::new(model))?;
        walk.position = position.clone();
        walk.waiting.clear();
        Ok(())
    }
}
