//! The quality table: the twin, the axial-only fit beside it, and the free baselines.

use bendtwin_core::{
    CancelToken, Capture, Quality, Twin,
    quality::{Predictor, Score},
};
use bendtwin_engine::Backend;

use crate::{
    Error, Trajectory,
    baselines::{clamp_interpolation, last_residual, standing_still},
    metrics::{PredictorErrors, Reference},
    predict,
};

/// Contents of the table apart from the twin and the baselines.
#[derive(Clone, Copy, Debug, Default)]
pub struct EvaluateOptions<'a> {
    /// The axial-only fit of the same nodes, as a row beside the twin's.
    pub axial: Option<&'a Twin>,
    /// Keep the errors of every frame.
    pub per_frame: bool,
}

/// Rolls out every sequence from its start without re-seeding and scores it. Held-out sequences and
/// the frames after a split count as future.
///
/// # Errors
/// If the twin does not fit the capture, on cancellation, or if the backend fails.
pub fn evaluate(
    backend: &dyn Backend,
    twin: &Twin,
    capture: &Capture,
    options: &EvaluateOptions<'_>,
    cancel: &CancelToken,
) -> Result<Quality, Error> {
    let predictions = predict(backend, twin, capture, cancel)?;
    let axial = match options.axial {
        Some(axial) => Some((axial, predict(backend, axial, capture, cancel)?)),
        None => None,
    };
    let axial = axial.as_ref().map(|(twin, p)| (*twin, p.as_slice()));
    Ok(score(twin, &predictions, axial, capture, options.per_frame))
}

/// The quality table of predictions that were made already by [`predict`].
pub fn score(
    twin: &Twin,
    predictions: &[Trajectory],
    axial: Option<(&Twin, &[Trajectory])>,
    capture: &Capture,
    per_frame: bool,
) -> Quality {
    let own = if twin.graph.triplets.is_empty() { Predictor::Axial } else { Predictor::Bending };
    let mut rows = vec![Row::new(own)];
    if axial.is_some() && own == Predictor::Bending {
        rows.push(Row::new(Predictor::Axial));
    }
    let free = rows.len();
    rows.push(Row::new(Predictor::StandingStill));
    rows.push(Row::new(Predictor::LastResidual));
    rows.push(Row::new(Predictor::ClampInterpolation));

    for (index, (sequence, prediction)) in capture.sequences.iter().zip(predictions).enumerate() {
        let graph = &twin.graph;
        let Some(start) = prediction.at(sequence.start_frame()) else { continue };
        let reference = Reference::new(capture, sequence, graph, start);
        rows[0].errors.add(&reference, prediction);
        if let (Some((other, predictions)), 2) = (axial, free)
            && let Some(prediction) = predictions.get(index)
            && let Some(start) = prediction.at(sequence.start_frame())
        {
            let reference = Reference::new(capture, sequence, &other.graph, start);
            rows[1].errors.add(&reference, prediction);
        }
        rows[free].errors.add(&reference, &standing_still(graph, sequence, start));
        if let Some(corrected) = last_residual(graph, sequence, prediction) {
            rows[free + 1].errors.add(&reference, &corrected);
        }
        if let Some(between) = clamp_interpolation(capture, graph, sequence, start) {
            rows[free + 2].errors.add(&reference, &between);
        }
    }
    let mut quality = Quality {
        scores: rows.into_iter().filter_map(|row| row.score(per_frame)).collect(),
        warnings: divergences(capture, predictions),
        fast: None,
    };
    if let Some((_, predictions)) = axial {
        let named = |w: String| format!("the axial-only fit: {w}");
        quality.warnings.extend(divergences(capture, predictions).into_iter().map(named));
    }
    let warning = beaten_by_standing_still(&quality, own);
    quality.warnings.extend(warning);
    quality
}

struct Row {
    predictor: Predictor,
    errors: PredictorErrors,
}

impl Row {
    fn new(predictor: Predictor) -> Self {
        Self { predictor, errors: PredictorErrors::default() }
    }

    /// `None` if the predictor made no prediction.
    fn score(self, per_frame: bool) -> Option<Score> {
        let mut train = self.errors.train.summary();
        let future = self.errors.future.summary();
        if self.predictor == Predictor::LastResidual {
            // It uses the last training frame: errors before that mean nothing.
            train = Default::default();
        }
        let errors = if per_frame && self.predictor != Predictor::LastResidual {
            self.errors.per_frame()
        } else {
            Vec::new()
        };
        let nothing = Default::default();
        (train != nothing || future != nothing).then_some(Score {
            predictor: self.predictor,
            train,
            future,
            per_frame: errors,
        })
    }
}

fn divergences(capture: &Capture, predictions: &[Trajectory]) -> Vec<String> {
    let pairs = capture.sequences.iter().zip(predictions);
    let diverged = pairs.filter_map(|(s, p)| Some((s, p.diverged?, p.start_frame)));
    diverged
        .map(|(s, at, start)| {
            format!(
                "the simulation of sequence `{}` diverged in frame {} at node {}; it is scored as if \
                 the object had stopped there",
                s.name,
                start + at.frame,
                at.node
            )
        })
        .collect()
}

fn beaten_by_standing_still(quality: &Quality, own: Predictor) -> Option<String> {
    let (twin, still) = (quality.score(own)?, quality.score(Predictor::StandingStill)?);
    let measure = |s: &Score| {
        let part = if s.future == Default::default() { s.train } else { s.future };
        part.track_m.or(part.chamfer_l1_m)
    };
    let (ours, theirs) = (measure(twin)?, measure(still)?);
    (ours >= theirs).then(|| {
        format!(
            "the twin ({:.1} mm) predicts no better than standing still ({:.1} mm)",
            1e3 * ours,
            1e3 * theirs
        )
    })
}

#[cfg(test)]
mod tests;
