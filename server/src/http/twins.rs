//! `/v1/twins`.

use axum::{
    Json,
    extract::{Request, State},
    http::{HeaderMap, StatusCode, header},
    response::{IntoResponse, Response},
};

use bendtwin_proto::json::TensorFormat;
use serde::Deserialize;
use utoipa::IntoParams;

use super::{
    Result,
    download::download,
    extract::{self, Id, Params},
    labels::{LabelUpdate, TwinList},
    resource::{Twin, Twins, UploadParams},
    rollouts::{document, schema},
};
use crate::{
    app::{App, Geometry, TwinUpload},
    error::ProblemDocument,
};

/// List twins
#[utoipa::path(get, path = "/v1/twins", tag = "twins", params(TwinList),
    responses((status = 200, body = Twins), (status = "default", body = ProblemDocument)))]
pub(super) async fn list(
    State(app): State<App>,
    Params(list): Params<TwinList>,
) -> Result<Json<Twins>> {
    let page = app.twins(list.into()).await?;
    let twins = page.items.into_iter().map(Twin::from).collect();
    Ok(Json(Twins { twins, next_page_token: page.next_token }))
}

/// Import a twin file
#[utoipa::path(post, path = "/v1/twins", tag = "twins",
    params(
        UploadParams,
        ("Idempotency-Key" = Option<String>, Header, description = "Makes the import idempotent"),
        ("X-Content-Blake3" = Option<String>, Header, description = "BLAKE3 of the body, hex; checked")),
    request_body(content = Vec<u8>, content_type = "application/octet-stream"),
    responses((status = 201, body = Twin), (status = "default", body = ProblemDocument)))]
pub(super) async fn create(
    State(app): State<App>,
    Params(params): Params<UploadParams>,
    request: Request,
) -> Result<Response> {
    extract::expect_type(request.headers(), &["application/octet-stream"])?;
    let upload = TwinUpload {
        display_name: params.display_name,
        request_id: extract::idempotency_key(request.headers())?,
        digest: extract::declared_digest(request.headers(), params.digest)?,
        body: extract::upload_body(request),
    };
    let twin = app.create_twin(upload).await?;
    let location = [(header::LOCATION, format!("/v1/{}", twin.id))];
    Ok((StatusCode::CREATED, location, Json(Twin::from(twin))).into_response())
}

/// One twin
#[utoipa::path(get, path = "/v1/twins/{id}", tag = "twins", params(("id" = String, Path)),
    responses((status = 200, body = Twin), (status = "default", body = ProblemDocument)))]
pub(super) async fn get(State(app): State<App>, Id(id): Id) -> Result<Json<Twin>> {
    Ok(Json(app.twin(&id).await?.into()))
}

/// Form of tensors.
#[derive(Deserialize, IntoParams)]
#[serde(deny_unknown_fields)]
#[into_params(parameter_in = Query)]
pub(super) struct TensorParams {
    /// `lists` (nested lists of numbers, the default) or `base64`.
    #[serde(default)]
    #[param(value_type = String, pattern = "lists|base64")]
    tensors: TensorFormat,
}

/// The geometry of a twin
///
/// What planners need to know of a twin without reading its file: nodes, springs, control points
/// and the hand that each belongs to.
#[utoipa::path(get, path = "/v1/twins/{id}/geometry", tag = "twins",
    params(("id" = String, Path), TensorParams),
    responses((status = 200, body = schema::TwinGeometry), (status = "default", body = ProblemDocument)))]
pub(super) async fn geometry(
    State(app): State<App>,
    Id(id): Id,
    Params(params): Params<TensorParams>,
) -> Result<Response> {
    let as_lists = params.tensors == TensorFormat::Lists;
    let Geometry { message, held } = app.twin_geometry(&id, as_lists).await?;
    Ok(document::answer(message, held, params.tensors)?)
}

/// Change name, note and tags of a twin
#[utoipa::path(patch, path = "/v1/twins/{id}", tag = "twins",
    params(("id" = String, Path)),
    request_body = LabelUpdate,
    responses((status = 200, body = Twin), (status = "default", body = ProblemDocument)))]
pub(super) async fn update(
    State(app): State<App>,
    Id(id): Id,
    extract::Json(change): extract::Json<LabelUpdate>,
) -> Result<Json<Twin>> {
    Ok(Json(app.update_twin(&id, change.into()).await?.into()))
}

/// Delete a twin
#[utoipa::path(delete, path = "/v1/twins/{id}", tag = "twins", params(("id" = String, Path)),
    responses((status = 204), (status = "default", body = ProblemDocument)))]
pub(super) async fn delete(State(app): State<App>, Id(id): Id) -> Result<StatusCode> {
    app.delete_twin(&id).await?;
    Ok(StatusCode::NO_CONTENT)
}

/// Download a twin file
#[utoipa::path(get, path = "/v1/twins/{id}/content", tag = "twins",
    params(("id" = String, Path),
        ("Range" = Option<String>, Header, description = "One range of bytes"),
        ("If-Range" = Option<String>, Header, description = "The ETag that the range is of")),
    responses((status = 200, body = Vec<u8>, content_type = "application/octet-stream"),
        (status = 206, body = Vec<u8>, content_type = "application/octet-stream"),
        (status = "default", body = ProblemDocument)))]
pub(super) async fn content(
    State(app): State<App>,
    Id(id): Id,
    headers: HeaderMap,
) -> Result<Response> {
    let (twin, content) = app.twin_content(&id).await?;
    let file_name = format!("{}.safetensors", twin.id.uuid());
    download(&headers, content, "application/octet-stream", &file_name).await
}
