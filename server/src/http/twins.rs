//! `/v1/twins`: imports, downloads and geometry.

use std::convert::Infallible;

use axum::{
    body::Body,
    extract::{Request, State},
    http::{HeaderMap, StatusCode, header},
    response::{IntoResponse, Response},
};
use bendtwin_proto::{json::TensorFormat, v1::TwinMetadata};
use bytes::Bytes;
use futures::stream;
use serde::Deserialize;

use super::{
    Result,
    download::download,
    extract::{self, Id, Metadata, Params, TensorParams},
    message::document,
    rollouts::document::answer,
};
use crate::{
    app::{App, Exported, Geometry, SurfaceReply},
    grpc::convert,
};

/// Format of an export that is not said.
const FORMAT: &str = "glb";
/// Bytes of a chunk of an export.
const CHUNK: usize = 64 << 10;

/// Import a twin file
pub(super) async fn create(
    State(app): State<App>,
    Metadata(mut metadata): Metadata<TwinMetadata>,
    request: Request,
) -> Result<Response> {
    extract::expect_type(request.headers(), &["application/octet-stream"])?;
    metadata.request_id = extract::idempotency_key(request.headers())?;
    metadata.digest = extract::declared_digest(request.headers(), metadata.digest)?;
    let body = extract::upload_body(request);
    let twin = convert::twin(app.create_twin(metadata, body).await?);
    let location = [(header::LOCATION, format!("/v1/{}", twin.name))];
    Ok((StatusCode::CREATED, location, document(&twin)).into_response())
}

/// The geometry of a twin
pub(super) async fn geometry(
    State(app): State<App>,
    Id(id): Id,
    Params(params): Params<TensorParams>,
) -> Result<Response> {
    let as_lists = params.tensors == TensorFormat::Lists;
    let Geometry { message, held } = app.twin_geometry(&id, as_lists).await?;
    Ok(answer(message, held, params.tensors)?)
}

/// The surface of a twin
pub(super) async fn surface(
    State(app): State<App>,
    Id(id): Id,
    Params(params): Params<TensorParams>,
) -> Result<Response> {
    let as_lists = params.tensors == TensorFormat::Lists;
    let SurfaceReply { message, held } = app.twin_surface(&id, as_lists).await?;
    Ok(answer(message, held, params.tensors)?)
}

/// The format of an export.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ExportParams {
    /// A word of `bendtwin twin export --format`; `glb` by default.
    format: Option<String>,
}

/// Download a twin in the format of another program
pub(super) async fn export(
    State(app): State<App>,
    Id(id): Id,
    Params(params): Params<ExportParams>,
) -> Result<Response> {
    let Exported { bytes, file_name, held } =
        app.export_as(&id, params.format.as_deref().unwrap_or(FORMAT)).await?;
    let headers = [
        (header::CONTENT_TYPE, "application/octet-stream".to_owned()),
        (header::CONTENT_DISPOSITION, format!("attachment; filename=\"{file_name}\"")),
        (header::X_CONTENT_TYPE_OPTIONS, "nosniff".to_owned()),
        (header::CONTENT_LENGTH, bytes.len().to_string()),
    ];
    // In chunks, so that its memory is held until the client has read it.
    let bytes = Bytes::from(bytes);
    let chunks = (0..bytes.len()).step_by(CHUNK).map(move |from| {
        let _held = &held;
        Ok::<_, Infallible>(bytes.slice(from..bytes.len().min(from + CHUNK)))
    });
    Ok((headers, Body::from_stream(stream::iter(chunks))).into_response())
}

/// Download a twin file
pub(super) async fn content(
    State(app): State<App>,
    Id(id): Id,
    headers: HeaderMap,
) -> Result<Response> {
    let (twin, content) = app.twin_content(&id).await?;
    let file_name = format!("{}.safetensors", twin.id.uuid());
    download(&headers, content, "application/octet-stream", &file_name).await
}
