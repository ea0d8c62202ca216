//! Finds a twin's fast variant: the fewest substeps that hardly change its motion.
//!
//! The twin follows the controls of its capture, exactly and by each variant under comparison,
//! over at most [`FRAMES`] frames of at most [`SEQUENCES`] recordings from their start; nodes are
//! compared one by one. A variant will do if its mean deviation is within [`TOLERANCE_M`] and
//! within [`TOLERANCE_OF_TRAVEL`] of how far nodes move on average (a capture in which little moves
//! allows little), and if no node is ever off by more than [`WORST`] times that. The substeps
//! are found by bisection, so the cost is that of a few short rollouts, and the same twin, capture,
//! build and device give the same variant.

use std::sync::Arc;

use bendtwin_core::{CancelToken, Capture, FastVariant, Point, Sequence, Twin};
use bendtwin_engine::{
    Backend, Model, Objective,
    backend::{self, Instance, Outputs},
    fidelity::Reduction,
    stable_substeps,
};

use crate::{
    Error, instance, slice_len,
    trajectory::{check, difference},
};

/// Frames compared.
const FRAMES: usize = 30;
/// Recordings compared, spread evenly over all of them.
const SEQUENCES: usize = 8;
/// Mean deviation that a fast variant may have [m].
const TOLERANCE_M: f64 = 1e-3;
/// Tolerance as a share of the mean travel.
const TOLERANCE_OF_TRAVEL: f64 = 0.02;
/// Largest deviation of any node in any frame, as a multiple of the tolerance of the mean.
const WORST: f64 = 10.0;
/// Ratio of numbers of substeps below which they are not distinguished.
const PRECISION: f64 = 1.1;

/// The fast variant of a twin, measured on a capture; none if the twin diverges there, or there is
/// nothing to follow. If no faster variant is good enough, it has the twin's own substeps and does
/// not deviate.
///
/// # Errors
/// If the twin does not fit the capture, on cancellation, or if the backend fails.
pub fn fast_variant(
    backend: &dyn Backend,
    twin: &Twin,
    capture: &Capture,
    cancel: &CancelToken,
) -> Result<Option<FastVariant>, Error> {
    check(twin, capture)?;
    let model = Model::from(twin);
    let comparison = Comparison { backend, capture, sequences: spread(&capture.sequences), cancel };
    let exact = comparison.follow(&model)?.filter(|m| m.positions.iter().any(|p| !p.is_empty()));
    let Some(exact) = exact else { return Ok(None) };
    let mean_travel_m = exact.mean_travel_m();
    let tolerance_m = TOLERANCE_M.min(TOLERANCE_OF_TRAVEL * mean_travel_m);
    let variant = |reduction: Reduction, (mean_deviation_m, max_deviation_m)| FastVariant {
        substeps: reduction.substeps,
        rate_limit: reduction.rate_limit,
        mean_deviation_m,
        max_deviation_m,
        mean_travel_m,
        frames: FRAMES as u32,
    };
    let measure = |substeps: u32| -> Result<Option<FastVariant>, Error> {
        let Some(reduction) = Reduction::to(&model, substeps) else { return Ok(None) };
        let Some(motion) = comparison.follow(&reduction.apply(&model))? else { return Ok(None) };
        let (mean_m, max_m) = exact.deviation_m(&motion);
        let will_do = mean_m <= tolerance_m && max_m <= WORST * tolerance_m;
        Ok(will_do.then(|| variant(reduction, (mean_m, max_m))))
    };
    // The twin's own substeps will do; zero will not. The first guess asks for as few as are stable
    // without softening.
    let own = Reduction { substeps: model.timing.substeps, rate_limit: None };
    let (mut best, mut too_few) = (variant(own, (0.0, 0.0)), 0);
    let mut guess = stable_substeps(&model).needed.min(best.substeps.saturating_sub(1));
    while guess > too_few && guess < best.substeps {
        match measure(guess)? {
            Some(variant) => best = variant,
            None => too_few = guess,
        }
        if f64::from(best.substeps) <= f64::from(too_few) * PRECISION {
            break;
        }
        guess = (f64::from(too_few.max(1)) * f64::from(best.substeps)).sqrt() as u32;
    }
    Ok(Some(best))
}

/// The sequences that variants are compared on.
struct Comparison<'a> {
    backend: &'a dyn Backend,
    capture: &'a Capture,
    sequences: Vec<&'a Sequence>,
    cancel: &'a CancelToken,
}

impl Comparison<'_> {
    /// Motion of a model under the capture's controls; none if it diverges or the backend finds it
    /// unstable.
    fn follow(&self, model: &Model) -> Result<Option<Motion>, Error> {
        let loaded = match self.backend.load(Arc::new(model.clone())) {
            Ok(loaded) => loaded,
            Err(backend::Error::Unstable { .. }) => return Ok(None),
            Err(e) => return Err(e.into()),
        };
        let batch: Vec<Instance> = self
            .sequences
            .iter()
            .map(|s| {
                let mut whole = instance(&loaded, self.capture.fps, s, Objective::default());
                whole.frames = whole.frames.min(FRAMES);
                let controls = (whole.frames + 1) * model.graph.control_count();
                whole.controls = Arc::new(whole.controls.iter().take(controls).copied().collect());
                whole
            })
            .collect();
        let outputs = Outputs { every: 1, ..Outputs::default() };
        let mut motion = Motion::default();
        for slice in batch.chunks(slice_len(self.backend)) {
            for (rollout, instance) in
                self.backend.roll_out(slice, &outputs, self.cancel)?.into_iter().zip(slice)
            {
                if rollout.diverged.is_some() {
                    return Ok(None);
                }
                motion.starts.push(instance.initial.positions.clone());
                motion.positions.push(rollout.positions);
            }
        }
        Ok(Some(motion))
    }
}

/// Motion of nodes, by sequence.
#[derive(Default)]
struct Motion {
    /// Shape [N, 3] each.
    starts: Vec<Vec<Point>>,
    /// Shape [F, N, 3] each.
    positions: Vec<Vec<Point>>,
}

impl Motion {
    /// Mean distance of nodes from their initial positions [m].
    fn mean_travel_m(&self) -> f64 {
        let pairs = self.positions.iter().zip(&self.starts);
        mean_and_max(pairs.flat_map(|(p, start)| p.iter().zip(start.iter().cycle()))).0
    }

    /// Mean and largest distance of nodes here from the same nodes there [m].
    fn deviation_m(&self, other: &Self) -> (f64, f64) {
        let pairs = self.positions.iter().zip(&other.positions);
        mean_and_max(pairs.flat_map(|(a, b)| a.iter().zip(b)))
    }
}

fn mean_and_max<'a>(pairs: impl Iterator<Item = (&'a Point, &'a Point)>) -> (f64, f64) {
    let (mut sum, mut max, mut count) = (0.0, 0.0_f64, 0_usize);
    for (a, b) in pairs {
        let apart = difference(*a, *b).iter().map(|x| f64::from(*x).powi(2)).sum::<f64>().sqrt();
        sum += apart;
        max = max.max(apart);
        count += 1;
    }
    (sum / count.max(1) as f64, max)
}

fn spread(sequences: &[Sequence]) -> Vec<&Sequence> {
    let count = sequences.len().min(SEQUENCES);
    (0..count).map(|i| &sequences[i * sequences.len() / count]).collect()
}

#[cfg(test)]
mod tests;
