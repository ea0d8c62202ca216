//! Settings that all methods have in common.

use std::time::Duration;

use crate::{
    Knots,
    bounds::Bounds,
    curve::{Curve, even},
    error::Invalid,
    method::Method,
};

/// Settings of a planner.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// Number of knots K, 2 or more.
    pub knots: usize,
    /// Number of coordinates D of a knot.
    pub dims: usize,
    /// Horizon [frames].
    pub frames: usize,
    /// Seconds from frame to frame.
    pub frame_s: f64,
    /// Times of the knots [s], rising from 0; empty: spread evenly over the horizon.
    pub knot_times: Vec<f64>,
    /// Curve between knots.
    pub curve: Curve,
    /// Plans that are simulated in an iteration.
    pub samples: usize,
    /// Iterations of a plan.
    pub iterations: usize,
    /// Standard deviations of samples: one, by coordinate [D], or by knot and coordinate [K, D].
    pub sigma: Vec<f64>,
    /// Correlation of neighbouring knots of a sample, 0..1.
    pub correlation: f64,
    /// Samples have sigma times a factor, evenly spread in its logarithm from 1 to this, 0..1: large
    /// ones find ways, small ones the goal.
    pub finest: f64,
    /// Limits that every plan keeps.
    pub bounds: Bounds,
    /// Time for a plan; the first iteration is always finished.
    pub deadline: Option<Duration>,
    /// Same seed, same plans.
    pub seed: u64,
    /// Way to learn from costs.
    pub method: Method,
}

impl Settings {
    /// Settings with 64 samples of 20 mm, where coordinates are metres, and five knots. Samples
    /// become finer, to 0.6 mm, unless the method shrinks them itself.
    pub fn new(method: Method, dims: usize, frames: usize) -> Self {
        Self {
            knots: 5,
            dims,
            frames,
            frame_s: 1.0,
            knot_times: Vec::new(),
            curve: Curve::Linear,
            samples: 64,
            iterations: 1,
            sigma: vec![0.02],
            correlation: 0.0,
            finest: match method {
                Method::Mppi { .. } | Method::PredictiveSampling => 0.03,
                Method::Cem { .. } | Method::Gradient { .. } => 1.0,
            },
            bounds: Bounds::default(),
            deadline: None,
            seed: 0,
            method,
        }
    }

    /// Times of the knots [s], shape [K].
    pub(crate) fn times(&self) -> Vec<f64> {
        match self.knot_times.is_empty() {
            true => even(self.knots, self.frames as f64 * self.frame_s),
            false => self.knot_times.clone(),
        }
    }

    /// Knots, shape [K, `width`], of the same curve from some frames on; at its end it stands still.
    pub fn shifted(&self, knots: &[f64], width: usize, frames: f64) -> Knots {
        self.curve.shifted(knots, width, frames * self.frame_s, &self.times())
    }

    /// Moves a plan within the bounds.
    pub(crate) fn project(&self, plan: &mut Knots) {
        self.bounds.project(plan, self.dims, &self.times());
    }

    /// Standard deviations, shape [K, D], with zeros in row 0.
    pub(crate) fn deviations(&self) -> Knots {
        let (len, given) = (self.knots * self.dims, self.sigma.len().max(1));
        (0..len).map(|i| if i < self.dims { 0.0 } else { self.sigma[i % given] }).collect()
    }

    /// Factor of sigma of each of `count` samples: 1 for the first, `finest` for the last.
    pub(crate) fn scales(&self, count: usize) -> impl Iterator<Item = f64> + use<> {
        let (finest, last) = (self.finest, count.saturating_sub(1).max(1) as f64);
        (0..count).map(move |i| finest.powf(i as f64 / last))
    }

    /// Checks all of them.
    ///
    /// # Errors
    /// At the first that is out of its range.
    pub fn check(&self) -> Result<(), Invalid> {
        let at_least = |field, value: usize, least: usize| match value < least {
            true => Err(Invalid::new(field, format!("is {value}: give {least} or more"))),
            false => Ok(()),
        };
        at_least("knots", self.knots, 2)?;
        at_least("dims", self.dims, 1)?;
        at_least("frames", self.frames, 1)?;
        at_least("samples", self.samples, 1)?;
        at_least("iterations", self.iterations, 1)?;
        let shapes = [1, self.dims, self.knots * self.dims];
        if !shapes.contains(&self.sigma.len()) {
            let problem = format!("has {} values: give one of {shapes:?}", self.sigma.len());
            return Err(Invalid::new("sigma", problem));
        }
        if self.sigma.iter().any(|s| !(s.is_finite() && *s >= 0.0)) {
            return Err(Invalid::new("sigma", "must be finite and not negative"));
        }
        if !(0.0..1.0).contains(&self.correlation) {
            return Err(Invalid::new("correlation", "must be 0 or more, and less than 1"));
        }
        if !(self.finest > 0.0 && self.finest <= 1.0) {
            return Err(Invalid::new("finest", "must be above 0, and 1 or less"));
        }
        if !(self.frame_s.is_finite() && self.frame_s > 0.0) {
            return Err(Invalid::new("frame_s", "must be above 0"));
        }
        let times = &self.knot_times;
        let rises = times.first() == Some(&0.0) && times.windows(2).all(|t| t[0] < t[1]);
        let is_right = times.is_empty() || (rises && times.len() == self.knots);
        if !is_right {
            return Err(Invalid::new("knot_times", "give a time for each knot, rising from 0"));
        }
        self.bounds.check(self.dims)?;
        self.method.check(self.dims)
    }
}
