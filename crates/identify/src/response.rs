//! Responses of points of a twin to steps along directions, by central differences of rollouts.

use std::sync::Arc;

use bendtwin_core::{CancelToken, Params, Point, Skin};
use bendtwin_engine::{
    Backend, Loaded, Model, Motion, Objective, World,
    backend::{Error, Instance, Outputs, Rollout},
    fidelity::Reduction,
    model::State,
};
use bendtwin_eval::slice_len;

use crate::directions::{Direction, prior_sd};

/// Length of a step along a direction, in its standard deviations before a recording: long enough that
/// contact that comes a frame earlier or later is averaged over, short enough to stay stable (the
/// substeps of a fit have a margin of 1.3² in stiffness).
const STEP: f64 = 0.25;

/// Standard deviation of a constant offset of a hand [m]: what lifting a hand to control points leaves.
pub(crate) const HAND_OFFSET_M: f64 = 0.005;

/// A motion of a twin that is simulated once for each variation.
#[derive(Clone)]
pub(crate) struct Scene {
    pub(crate) model: Model,
    /// The fast variant that computes it; none for the model itself.
    pub(crate) reduction: Option<Reduction>,
    /// Hand of each control point.
    pub(crate) hands: Vec<u32>,
    pub(crate) initial: Arc<State>,
    /// Control points at frame boundaries [m], shape [frames + 1, C, 3].
    pub(crate) controls: Arc<Vec<Point>>,
    pub(crate) frames: usize,
    pub(crate) world: Arc<World>,
    pub(crate) motion: Arc<Motion>,
}

/// A difference between two simulations of a scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Variation {
    /// Other parameters.
    Along(Direction),
    /// A hand elsewhere by a constant along an axis of the world.
    HandOffset { hand: u32, axis: usize },
}

/// Points of a skin at the end of a frame.
#[derive(Clone)]
pub(crate) struct Sample {
    /// Frame, a multiple of the frames between two records.
    pub(crate) frame: usize,
    pub(crate) skin: Arc<Skin>,
}

/// Coordinates of samples and their derivatives.
pub(crate) struct Response {
    /// Change of each coordinate by a standard deviation of each variation [m], shape [variations,
    /// points of all samples, 3]; zero where no step could be simulated.
    pub(crate) columns: Vec<Vec<f32>>,
}

impl Variation {
    /// Standard deviation of the prior.
    fn prior_sd(&self) -> f64 {
        match self {
            Self::Along(direction) => prior_sd(direction.quantity),
            Self::HandOffset { .. } => HAND_OFFSET_M,
        }
    }
}

impl Scene {
    /// The model that is simulated.
    fn simulated(&self) -> Model {
        match self.reduction {
            Some(reduction) => reduction.apply(&self.model),
            None => self.model.clone(),
        }
    }

    fn instance(&self, model: Loaded, controls: Arc<Vec<Point>>) -> Instance {
        Instance {
            model,
            initial: self.initial.clone(),
            controls,
            frames: self.frames,
            objective: Objective::default(),
            world: self.world.clone(),
            motion: self.motion.clone(),
        }
    }

    /// A rollout without a variation, recorded in every frame; none if it diverges.
    pub(crate) fn base(
        &self,
        backend: &dyn Backend,
        cancel: &CancelToken,
    ) -> Result<Option<Rollout>, Error> {
        let loaded = backend.load(Arc::new(self.simulated()))?;
        let outputs = Outputs { every: 1, ..Outputs::NONE };
        let batch = [self.instance(loaded, self.controls.clone())];
        let rollout = backend.roll_out(&batch, &outputs, cancel)?.into_iter().next();
        Ok(rollout.filter(|r| r.diverged.is_none()))
    }

    /// Parameters of the simulated model a step along a direction, and the step that was made.
    fn params(&self, direction: &Direction, of_nodes: &[u8], step: f64) -> (Params, f64) {
        let (graph, params) = (&self.model.graph, &self.model.params);
        let (params, made) = direction.apply(graph, params, of_nodes, &self.hands, step);
        match self.reduction {
            Some(reduction) => {
                (reduction.apply(&Model { params, ..self.model.clone() }).params, made)
            }
            None => (params, made),
        }
    }

    /// A simulation a step along a variation, and the step that was made.
    fn varied(
        &self,
        backend: &dyn Backend,
        base: &Loaded,
        of_nodes: &[u8],
        variation: &Variation,
        step: f64,
    ) -> Result<(Instance, f64), Error> {
        match variation {
            Variation::Along(direction) => {
                let (params, made) = self.params(direction, of_nodes, step);
                let model = backend.with_params(base, params)?;
                Ok((self.instance(model, self.controls.clone()), made))
            }
            Variation::HandOffset { hand, axis } => {
                let mut controls = self.controls.as_ref().clone();
                for row in controls.chunks_mut(self.hands.len().max(1)) {
                    let own = row.iter_mut().zip(&self.hands).filter(|(_, h)| **h == *hand);
                    own.for_each(|(point, _)| point[*axis] += step as f32);
                }
                Ok((self.instance(base.clone(), Arc::new(controls)), step))
            }
        }
    }

    /// Responses of samples to variations; none if the scene itself diverges. `every` are the frames
    /// between two records, of which all frames of the samples are multiples.
    pub(crate) fn respond(
        &self,
        backend: &dyn Backend,
        of_nodes: &[u8],
        variations: &[Variation],
        samples: &[Sample],
        every: usize,
        cancel: &CancelToken,
    ) -> Result<Option<Response>, Error> {
        let base = backend.load(Arc::new(self.simulated()))?;
        let outputs = Outputs { every, ..Outputs::NONE };
        let coordinates = |rollout: &Rollout| -> Option<Vec<f32>> {
            if rollout.diverged.is_some() {
                return None;
            }
            let nodes = self.model.graph.node_count();
            let mut all = Vec::new();
            for sample in samples {
                let row = (sample.frame / every).checked_sub(1)?;
                let at = rollout.positions.get(row * nodes..(row + 1) * nodes)?;
                all.extend(sample.skin.positions(at).into_iter().flatten());
            }
            Some(all)
        };
        let still = self.instance(base.clone(), self.controls.clone());
        let first = backend.roll_out(&[still], &outputs, cancel)?;
        let Some(middle) = first.first().and_then(&coordinates) else { return Ok(None) };
        let ends = variations.iter().flat_map(|v| [(v, 1.0), (v, -1.0)]);
        let ends: Vec<(&Variation, f64)> = ends.collect();
        let mut results: Vec<(Option<Vec<f32>>, f64)> = Vec::with_capacity(ends.len());
        for slice in ends.chunks(slice_len(backend).max(1)) {
            if cancel.is_cancelled() {
                return Err(Error::Cancelled);
            }
            let (mut batch, mut steps) = (Vec::new(), Vec::new());
            for (variation, sign) in slice {
                let step = sign * STEP * variation.prior_sd();
                let (instance, made) = self.varied(backend, &base, of_nodes, variation, step)?;
                batch.push(instance);
                steps.push(made);
            }
            let rollouts = backend.roll_out(&batch, &outputs, cancel)?;
            results.extend(rollouts.iter().map(&coordinates).zip(steps));
        }
        let pairs = variations.iter().zip(results.chunks_exact(2));
        let columns = pairs.map(|(variation, ends)| difference(variation, &middle, ends));
        Ok(Some(Response { columns: columns.collect() }))
    }
}

/// Change of each coordinate by a standard deviation of a variation. An end that diverged is replaced by
/// the middle.
fn difference(variation: &Variation, middle: &[f32], ends: &[(Option<Vec<f32>>, f64)]) -> Vec<f32> {
    let end = |i: usize| match ends.get(i) {
        Some((Some(at), step)) => (at.as_slice(), *step),
        _ => (middle, 0.0),
    };
    let ((high, up), (low, down)) = (end(0), end(1));
    let length = up - down;
    if length <= 0.0 {
        return vec![0.0; middle.len()];
    }
    let per_sd = variation.prior_sd() / length;
    high.iter().zip(low).map(|(h, l)| (f64::from(h - l) * per_sd) as f32).collect()
}

#[cfg(test)]
mod tests;
