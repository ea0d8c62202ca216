//! Times of rollouts and gradients of one scene.
//!
//! Rollouts are timed through [`Backend::losses`] with an empty objective, the call that returns
//! least: one number an instance. Gradients are those of windows of one frame with a Chamfer and a
//! track term, as in a step a frame. All instances of a batch share one loaded model; each has
//! different controls.

use std::{sync::Arc, time::Duration};

use bendtwin_core::{CancelToken, Point};
use bendtwin_engine::{
    Backend, Loaded, Objective, PointLoss, PointSet, Term,
    backend::{self, Divergence, GradientRequest, Instance},
    model::State,
    objective::WeightedTerm,
};

use crate::{
    Error,
    clock::{once, repeat},
    report::{Measured, Run},
    scene::Scene,
};

/// Distance of a target from its node at rest [m].
const TARGET_OFFSET_M: Point = [1e-3, 0.0, 1e-3];

/// Time limits of measurements.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Budget {
    /// Repeats of one measurement end after this.
    pub(crate) measurement: Duration,
    /// A measurement whose single call is expected to take longer than this is left out.
    pub(crate) patience: Duration,
    /// Frames of a rollout, at most.
    pub(crate) horizon: usize,
}

/// A scene on a device.
pub(crate) struct Bench<'a> {
    pub(crate) backend: &'a dyn Backend,
    pub(crate) scene: &'a Scene,
    pub(crate) loaded: Loaded,
    pub(crate) budget: Budget,
    pub(crate) cancel: &'a CancelToken,
}

impl Bench<'_> {
    /// Rollouts of each size of batch. `bound_s` is the least time of a substep of one instance.
    pub(crate) fn forward(
        &self,
        batches: &[usize],
        bound_s: Option<f64>,
    ) -> Result<Vec<Measured>, Error> {
        let work = |batch: &[Instance]| {
            let losses = self.backend.losses(batch, self.cancel)?;
            self.check(losses.into_iter().map(|l| l.diverged))
        };
        self.each(batches, self.budget.horizon, Objective::default(), bound_s, work)
    }

    /// Gradients of `windows` windows of one frame each.
    pub(crate) fn gradient(
        &self,
        batches: &[usize],
        bound_s: Option<f64>,
    ) -> Result<Vec<Measured>, Error> {
        let request = GradientRequest { final_state: true, ..GradientRequest::default() };
        let work = |batch: &[Instance]| {
            let gradients = self.backend.gradients(batch, &request, self.cancel)?;
            self.check(gradients.into_iter().map(|g| g.loss.diverged))
        };
        self.each(batches, 1, self.objective(), bound_s, work)
    }

    fn each(
        &self,
        batches: &[usize],
        horizon: usize,
        objective: Objective,
        bound_s: Option<f64>,
        work: impl Fn(&[Instance]) -> Result<(), Error>,
    ) -> Result<Vec<Measured>, Error> {
        // Seconds that an instance's frame took in the last batch that was measured.
        let mut pace_s: Option<f64> = None;
        let mut found = Vec::with_capacity(batches.len());
        for &size in batches {
            // A batch is at worst as slow as its instances one by one.
            let expected_s = pace_s.map_or(0.0, |s| s * size as f64);
            let measured = if expected_s > self.budget.patience.as_secs_f64() {
                Measured::left_out(size, format!("would take {expected_s:.0} s"))
            } else {
                match self.one(size, horizon, &objective, bound_s, &work) {
                    Ok(run) => {
                        pace_s = Some(1e-3 * run.frame_ms / size as f64);
                        Measured { batch: size, run: Some(run), left_out: None }
                    }
                    Err(Error::Backend(full @ backend::Error::OutOfMemory { .. })) => {
                        Measured::left_out(size, full.to_string())
                    }
                    Err(e) => return Err(e),
                }
            };
            found.push(measured);
        }
        Ok(found)
    }

    fn one(
        &self,
        size: usize,
        horizon: usize,
        objective: &Objective,
        bound_s: Option<f64>,
        work: impl Fn(&[Instance]) -> Result<(), Error>,
    ) -> Result<Run, Error> {
        let short = self.batch(size, 1, objective);
        let first_s = once(|| work(&short))?;
        // A few repeats should fit into the budget. The first call also pays for what happens once,
        // kernels that are compiled say, which may be far more than a call.
        let frame_s = if first_s < 0.25 * self.budget.patience.as_secs_f64() {
            once(|| work(&short))?
        } else {
            first_s
        };
        let affordable = self.budget.measurement.as_secs_f64() / (4.0 * frame_s.max(1e-9));
        let frames = (affordable as usize).clamp(1, horizon);
        let batch = if frames == 1 { short } else { self.batch(size, frames, objective) };
        let timing = repeat(self.budget.measurement, || work(&batch))?;
        let frame_s = timing.median_s / frames as f64;
        let substep_s = frame_s / f64::from(self.scene.model.timing.substeps);
        let bound_s = bound_s.map(|s| s * size as f64);
        Ok(Run {
            shape: self.backend.plan(&self.loaded, size),
            frames,
            repeats: timing.repeats,
            median_s: timing.median_s,
            best_s: timing.best_s,
            frames_per_s: size as f64 / frame_s,
            frame_ms: 1e3 * frame_s,
            us_per_substep: 1e6 * substep_s,
            bound_us_per_substep: bound_s.map(|s| 1e6 * s),
            of_bound: bound_s.map(|s| s / substep_s),
        })
    }

    fn batch(&self, size: usize, frames: usize, objective: &Objective) -> Vec<Instance> {
        let initial = Arc::new(State::rest(&self.scene.model.graph));
        let instance = |i: usize| Instance {
            model: self.loaded.clone(),
            initial: initial.clone(),
            controls: Arc::new(self.scene.motion.path(i, frames)),
            frames,
            objective: objective.clone(),
            world: Arc::default(),
            motion: Arc::default(),
        };
        (0..size).map(instance).collect()
    }

    /// Chamfer and track terms at the end of the first frame, every surface node with a target
    /// nearby.
    fn objective(&self) -> Objective {
        let graph = &self.scene.model.graph;
        let surface = graph.rest_positions.iter().take(graph.surface_count());
        let targets: Vec<Point> =
            surface.map(|p| std::array::from_fn(|c| p[c] + TARGET_OFFSET_M[c])).collect();
        let nodes = (0..targets.len() as u32).collect();
        let loss = PointLoss::SmoothL1 { beta_m: 1.0 };
        let terms = [
            Term::Chamfer { of: PointSet::Nodes, targets: targets.clone() },
            Term::Track { of: PointSet::Nodes, points: nodes, targets, loss },
        ];
        let weighted = |(group, term)| WeightedTerm { frame: 1, weight: 1.0, group, term };
        Objective {
            groups: vec!["chamfer".into(), "track".into()],
            terms: Arc::new(terms.into_iter().enumerate().map(weighted).collect()),
        }
    }

    fn check(&self, diverged: impl Iterator<Item = Option<Divergence>>) -> Result<(), Error> {
        match diverged.flatten().next() {
            Some(Divergence { frame, node }) => {
                Err(Error::Diverged { scene: self.scene.name.as_str(), frame, node })
            }
            None => Ok(()),
        }
    }
}
