//! Errors of predictions in one sequence, and the rows of the table that they add up to.

use bendtwin_core::{
    Capture, Sequence, Twin,
    quality::{ErrorSummary, NodeErrors, Predictor, Score},
};

use crate::{
    Trajectory,
    baselines::last_residual,
    metrics::{PredictorErrors, Reference},
    surface::Surface,
};

/// A sequence that predictions by a twin's nodes are compared with, at its skin and at its nodes.
pub(super) struct Measured<'a> {
    twin: &'a Twin,
    sequence: &'a Sequence,
    points: Surface,
    pub(super) at_skin: Reference<'a>,
    /// `None` if the skin is the nodes.
    at_nodes: Option<(Surface, Reference<'a>)>,
}

impl<'a> Measured<'a> {
    /// `None` if the prediction has no start.
    pub(super) fn new(
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

    /// The same with all frames as future ones.
    pub(super) fn unseen(self) -> Self {
        Self {
            at_skin: self.at_skin.unseen(),
            at_nodes: self.at_nodes.map(|(nodes, reference)| (nodes, reference.unseen())),
            ..self
        }
    }

    /// Adds the errors of a prediction to the row of its predictor.
    pub(super) fn add(&self, prediction: &Trajectory, by: Predictor, rows: &mut [Row]) {
        let Some(row) = row_of(by, rows) else { return };
        row.errors.add(&self.at_skin, &prediction.at_skin(&self.twin.skin));
        if let Some((_, reference)) = &self.at_nodes {
            row.at_nodes.add(reference, prediction);
        }
    }

    /// Adds those of a twin's prediction plus its error in the last training frame.
    pub(super) fn add_last_residual(&self, prediction: &Trajectory, rows: &mut [Row]) {
        let Some(row) = row_of(Predictor::LastResidual, rows) else { return };
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

fn row_of(predictor: Predictor, rows: &mut [Row]) -> Option<&mut Row> {
    rows.iter_mut().find(|row| row.predictor == predictor)
}

pub(super) struct Row {
    predictor: Predictor,
    errors: PredictorErrors,
    at_nodes: PredictorErrors,
}

impl Row {
    pub(super) fn new(predictor: Predictor) -> Self {
        Self { predictor, errors: Default::default(), at_nodes: Default::default() }
    }

    /// `None` if the predictor made no prediction.
    pub(super) fn score(self, per_frame: bool) -> Option<Score> {
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
            rendered: None,
        })
    }
}
