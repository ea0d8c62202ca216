//! A picture of predicted against observed motion.

use std::path::Path;

use anyhow::Context as _;
use bendtwin_core::{CancelToken, Capture, Twin, quality::Predictor};
use bendtwin_engine::Backend;
use bendtwin_eval::{
    picture::{Model, Picture},
    predict, predictor_name,
};

use crate::failure;

/// Number of frames side by side.
const COLUMNS: usize = 4;

/// Draws a twin, and the axial-only one below it, over a sequence of the capture that the fit did
/// not see, if there is one.
pub(crate) fn draw(
    path: &Path,
    twin: &Twin,
    axial: Option<&Twin>,
    capture: &Capture,
    backend: &dyn Backend,
    cancel: &CancelToken,
) -> anyhow::Result<()> {
    let sequence = capture.sequences.iter().position(bendtwin_core::Sequence::is_held_out);
    let sequence = sequence.unwrap_or(0);
    let twins: Vec<&Twin> = std::iter::once(twin).chain(axial).collect();
    let mut predictions = Vec::with_capacity(twins.len());
    for twin in &twins {
        let all = predict(backend, twin, capture, cancel).map_err(failure::failed)?;
        predictions.push(all.into_iter().nth(sequence).context("the capture has no sequence")?);
    }
    let models: Vec<Model<'_>> = twins
        .iter()
        .zip(&predictions)
        .map(|(twin, trajectory)| Model { name: name_of(twin), twin, trajectory })
        .collect();
    let picture = Picture { capture, sequence, models: &models, columns: COLUMNS };
    let png = picture.to_png().map_err(failure::failed)?;
    std::fs::write(path, png).with_context(|| format!("cannot write {}", path.display()))
}

fn name_of(twin: &Twin) -> &'static str {
    let is_axial = twin.graph.triplets.is_empty();
    predictor_name(if is_axial { Predictor::Axial } else { Predictor::Bending })
}
