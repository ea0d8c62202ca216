//! `/v1/twins`: imports, downloads and geometry.

use axum::{
    extract::{Request, State},
    http::{HeaderMap, StatusCode, header},
    response::{IntoResponse, Response},
};
use bendtwin_proto::{json::TensorFormat, v1::TwinMetadata};

use super::{
    Result,
    download::download,
    extract::{self, Id, Metadata, Params, TensorParams},
    message::document,
    rollouts::document::answer,
};
use crate::{
    app::{App, Geometry},
    grpc::convert,
};

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
