//! The quality table: the twin, the axial-only fit beside it, and the free baselines.

use bendtwin_core::{
    CancelToken, Capture, Quality, Sequence, Twin,
    quality::{ErrorSummary, NodeErrors, Predictor, Score},
};
use bendtwin_engine::Backend;

use crate::{
    Error, Trajectory,
    baselines::{clamp_interpolation, last_residual, standing_still},
    metrics::{PredictorErrors, Reference},
    predict,
    surface::Surface,
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
        let Some(measured) = Measured::new(twin, capture, sequence, prediction) else { continue };
        measured.add(prediction, &mut rows[0]);
        if let (Some((other, predictions)), 2) = (axial, free)
            && let Some(prediction) = predictions.get(index)
            && let Some(measured) = Measured::new(other, capture, sequence, prediction)
        {
            measured.add(prediction, &mut rows[1]);
        }
        let start = &prediction.positions[..prediction.node_count];
        measured.add(&standing_still(&twin.graph, sequence, start), &mut rows[free]);
        measured.add_last_residual(prediction, &mut rows[free + 1]);
        if let Some(between) = clamp_interpolation(capture, &twin.graph, sequence, start) {
            measured.add(&between, &mut rows[free + 2]);
        }
    }
    let mut quality = Quality {
        scores: rows.into_iter().filter_map(|row| row.score(per_frame)).collect(),
        warnings: divergences(capture, predictions),
        choice: None,
        assessment: None,
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

/// A sequence that predictions by a twin's nodes are compared with, at its skin and at its nodes.
struct Measured<'a> {
    twin: &'a Twin,
    sequence: &'a Sequence,
    points: Surface,
    at_skin: Reference<'a>,
    /// None where the skin is the nodes.
    at_nodes: Option<(Surface, Reference<'a>)>,
}

impl<'a> Measured<'a> {
    /// `None` if the prediction has no start.
    fn new(
        twin: &'a Twin,
        capture: &Capture,
        sequence: &'a Sequence,
        prediction: &Trajectory,
    ) -> Option<Self> {
        let start = prediction.at(sequence.start_frame())?;
        let points = Surface::of_skin(&twin.graph, &twin.skin);
        let placed = twin.skin.positions(start);
        let at_skin = Reference::new(capture, sequence, &points, &placed);
        let at_nodes = (!twin.skin.is_nodes(&twin.graph)).then(|| {
            let nodes = Surface::of_nodes(&twin.graph);
            let reference = Reference::new(capture, sequence, &nodes, start);
            (nodes, reference)
        });
        Some(Self { twin, sequence, points, at_skin, at_nodes })
    }

    fn add(&self, prediction: &Trajectory, row: &mut Row) {
        row.errors.add(&self.at_skin, &prediction.at_skin(&self.twin.skin));
        if let Some((_, reference)) = &self.at_nodes {
            row.at_nodes.add(reference, prediction);
        }
    }

    fn add_last_residual(&self, prediction: &Trajectory, row: &mut Row) {
        let placed = prediction.at_skin(&self.twin.skin);
        if let Some(corrected) = last_residual(&self.points, self.sequence, &placed) {
            row.errors.add(&self.at_skin, &corrected);
        }
        if let Some((nodes, reference)) = &self.at_nodes
            && let Some(corrected) = last_residual(nodes, self.sequence, prediction)
        {
            row.at_nodes.add(reference, &corrected);
        }
    }
}

struct Row {
    predictor: Predictor,
    errors: PredictorErrors,
    at_nodes: PredictorErrors,
}

impl Row {
    fn new(predictor: Predictor) -> Self {
        Self { predictor, errors: Default::default(), at_nodes: Default::default() }
    }

    /// `None` if the predictor made no prediction.
    fn score(self, per_frame: bool) -> Option<Score> {
        let nothing = ErrorSummary::default();
        let is_residual = self.predictor == Predictor::LastResidual;
        // It uses the last training frame: errors before that mean nothing.
        let train = |e: &PredictorErrors| if is_residual { nothing } else { e.train.summary() };
        let (train_errors, future) = (train(&self.errors), self.errors.future.summary());
        let per_frame =
            if per_frame && !is_residual { self.errors.per_frame() } else { Vec::new() };
        let at_nodes =
            NodeErrors { train: train(&self.at_nodes), future: self.at_nodes.future.summary() };
        (train_errors != nothing || future != nothing).then_some(Score {
            predictor: self.predictor,
            train: train_errors,
            future,
            per_frame,
            at_nodes: Some(at_nodes).filter(|e| *e != NodeErrors::default()),
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
