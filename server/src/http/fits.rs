//! `/v1/fits`: the preview of a fit that runs; its events, and those of ingests, are in `events`.

pub(super) mod events;

use axum::{extract::State, response::Response};

use super::{
    Result,
    extract::{Id, Params, TensorParams},
    rollouts::document::answer,
};
use crate::app::App;

/// What a fit has so far
pub(super) async fn preview(
    State(app): State<App>,
    Id(id): Id,
    Params(params): Params<TensorParams>,
) -> Result<Response> {
    let (preview, held) = app.fit_preview(&id).await?;
    Ok(answer(preview, held, params.tensors)?)
}
