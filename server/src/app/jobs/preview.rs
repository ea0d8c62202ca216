//! Previews of fits that run: checked when they come from a worker, since browsers draw them, and kept
//! in the database as text.

use std::sync::Arc;

use base64::{Engine as _, prelude::BASE64_STANDARD};
use bendtwin_budget::Share;
use bendtwin_core::{Stage, quality::Measure};
use bendtwin_proto::{
    json::timestamp,
    v1::{FitPreview, tensor::Dtype},
};
use bendtwin_store::StoredPreview;
use prost::Message as _;

use crate::{
    access::Scope,
    app::{App, Error, Result},
};

/// Size of the largest preview [bytes].
const MOST_BYTES: usize = 64 << 10;
/// Length of the longest name of a model.
const LONGEST_VARIANT: usize = 64;

impl App {
    /// The newest preview of a fit, and its memory.
    pub(crate) async fn fit_preview(&self, name: &str) -> Result<(FitPreview, Arc<Share>)> {
        let fit = self.reach(Scope::FitsRead, name).await?;
        let preview = decode(name, self.store.jobs().preview(fit).await?)?;
        let held = self.memory.reply(preview.encoded_len() as u64).await?;
        Ok((preview, Arc::new(held)))
    }
}

/// The text of a preview that a worker sent.
///
/// # Errors
/// If it is not one, or too large.
pub(super) fn encode(preview: &FitPreview) -> Result<String> {
    check(preview).map_err(|fault| Error::invalid("preview", fault))?;
    Ok(BASE64_STANDARD.encode(preview.encode_to_vec()))
}

fn decode(name: &str, stored: StoredPreview) -> Result<FitPreview> {
    let bytes = BASE64_STANDARD.decode(stored.content).ok();
    let preview = bytes.and_then(|bytes| FitPreview::decode(&bytes[..]).ok());
    let corrupt = || Error::Internal(format!("the stored preview of {name} cannot be read"));
    let preview = preview.ok_or_else(corrupt)?;
    Ok(FitPreview { create_time: Some(timestamp(stored.created)), ..preview })
}

fn check(preview: &FitPreview) -> std::result::Result<(), String> {
    let size = preview.encoded_len();
    if size > MOST_BYTES {
        return Err(format!("has {size} bytes: at most {MOST_BYTES} are accepted"));
    }
    let stage = Stage::parse(&preview.stage);
    if !matches!(stage, Some(Stage::Search | Stage::Refine)) {
        return Err("is of a stage without previews".to_owned());
    }
    if preview.variant.chars().count() > LONGEST_VARIANT {
        return Err(format!("has a variant of more than {LONGEST_VARIANT} characters"));
    }
    if Measure::parse(&preview.measure).is_none() {
        return Err("has an unknown measure".to_owned());
    }
    let FitPreview { error_m, baseline_m, held_back_m, .. } = *preview;
    let errors = [error_m, baseline_m, held_back_m.unwrap_or_default()];
    if !errors.iter().all(|error| error.is_finite() && *error >= 0.0) {
        return Err("has an error that is no distance".to_owned());
    }
    let frames = preview.frames.as_ref().ok_or("has no frames")?;
    let (shape, frames) = frames.unpack::<u32>("frames").map_err(|e| e.to_string())?;
    if shape.len() != 1 || frames.is_empty() || !frames.is_sorted_by(|a, b| a < b) {
        return Err("has no ascending frames".to_owned());
    }
    let positions = preview.positions.as_ref().ok_or("has no positions")?;
    let shape = positions.checked_shape("positions").map_err(|e| e.to_string())?;
    let fits = matches!(shape[..], [count, points, 3] if count == frames.len() && points > 0);
    let scaled = positions.dtype() == Dtype::Int16Scaled;
    let far = f32::from(i16::MAX) * positions.scale + positions.offset.abs();
    if !(fits && scaled && positions.scale > 0.0 && far.is_finite()) {
        return Err("has positions that are not INT16_SCALED [frames, points, 3]".to_owned());
    }
    Ok(())
}

#[cfg(test)]
mod tests;
