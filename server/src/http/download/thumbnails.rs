//! Small pictures for lists: `/v1/twins/{id}/thumbnail` and `/v1/captures/{id}/thumbnail`.

use axum::{
    extract::State,
    http::{HeaderMap, StatusCode, header},
    response::{IntoResponse, Response},
};
use serde::Deserialize;

use crate::{
    app::{App, Shown},
    http::{
        Result,
        extract::{Id, Params},
    },
};

/// Width of a picture that is not said [pixels].
const WIDTH: u32 = 160;
/// A twin never changes, and the playback of a capture seldom does. The picture is for the caller alone.
const KEPT: &str = "private, max-age=600";

/// The size of a picture.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(in crate::http) struct WidthParams {
    /// Width [pixels], 16 to 1024; the height is three quarters of it. Images of a camera have their own size.
    width: Option<u32>,
}

/// A small picture of a twin
pub(in crate::http) async fn twin(
    State(app): State<App>,
    Id(id): Id,
    Params(params): Params<WidthParams>,
    headers: HeaderMap,
) -> Result<Response> {
    picture(&app, Shown::Twin, &id, &params, &headers).await
}

/// A small picture of a capture
pub(in crate::http) async fn capture(
    State(app): State<App>,
    Id(id): Id,
    Params(params): Params<WidthParams>,
    headers: HeaderMap,
) -> Result<Response> {
    picture(&app, Shown::Capture, &id, &params, &headers).await
}

async fn picture(
    app: &App,
    shown: Shown,
    id: &str,
    params: &WidthParams,
    headers: &HeaderMap,
) -> Result<Response> {
    let width = params.width.unwrap_or(WIDTH);
    let picture = app.thumbnail(shown, id, width).await?;
    let tag = format!("\"{}-{width}\"", picture.source.to_hex());
    let kept = [(header::ETAG, tag.clone()), (header::CACHE_CONTROL, KEPT.to_owned())];
    let is_known =
        headers.get(header::IF_NONE_MATCH).is_some_and(|known| known.as_bytes() == tag.as_bytes());
    if is_known {
        return Ok((StatusCode::NOT_MODIFIED, kept).into_response());
    }
    let what =
        [(header::CONTENT_TYPE, picture.media_type), (header::X_CONTENT_TYPE_OPTIONS, "nosniff")];
    Ok((kept, what, picture.bytes).into_response())
}
