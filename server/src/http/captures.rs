//! `/v1/captures`.

use axum::{
    Json,
    extract::{Request, State},
    http::{StatusCode, header},
    response::{IntoResponse, Response},
};

use super::{
    Result,
    extract::{self, Id, Params},
    resource::{Capture, Captures, Paging, UploadParams},
};
use crate::{
    app::{App, CaptureUpload},
    error::ProblemDocument,
};

/// List captures
#[utoipa::path(get, path = "/v1/captures", tag = "captures", params(Paging),
    responses((status = 200, body = Captures), (status = "default", body = ProblemDocument)))]
pub(super) async fn list(
    State(app): State<App>,
    Params(paging): Params<Paging>,
) -> Result<Json<Captures>> {
    let page = app.captures(&paging.into()).await?;
    let captures = page.items.into_iter().map(Capture::from).collect();
    Ok(Json(Captures { captures, next_page_token: page.next_token }))
}

/// Upload a capture
///
/// The body is the archive. The same archive under the same `Idempotency-Key`
/// answers with the capture that exists already.
#[utoipa::path(post, path = "/v1/captures", tag = "captures",
    params(
        UploadParams,
        ("Idempotency-Key" = Option<String>, Header, description = "Makes the upload idempotent"),
        ("X-Content-Blake3" = Option<String>, Header, description = "BLAKE3 of the body, hex; checked"),
        ("Content-Digest" = Option<String>, Header, description = "blake3=:{base64}:; checked")),
    request_body(content = Vec<u8>, content_type = "application/zip"),
    responses((status = 201, body = Capture), (status = "default", body = ProblemDocument)))]
pub(super) async fn create(
    State(app): State<App>,
    Params(params): Params<UploadParams>,
    request: Request,
) -> Result<Response> {
    extract::expect_type(request.headers(), &["application/zip", "application/octet-stream"])?;
    let upload = CaptureUpload {
        display_name: params.display_name,
        request_id: extract::idempotency_key(request.headers())?,
        digest: extract::declared_digest(request.headers(), params.digest)?,
        body: extract::upload_body(request),
    };
    let capture = app.create_capture(upload).await?;
    let location = [(header::LOCATION, format!("/v1/{}", capture.id))];
    Ok((StatusCode::CREATED, location, Json(Capture::from(capture))).into_response())
}

/// One capture
#[utoipa::path(get, path = "/v1/captures/{id}", tag = "captures",
    params(("id" = String, Path)),
    responses((status = 200, body = Capture), (status = "default", body = ProblemDocument)))]
pub(super) async fn get(State(app): State<App>, Id(id): Id) -> Result<Json<Capture>> {
    Ok(Json(app.capture(&id).await?.into()))
}

/// Delete a capture
///
/// Refused while a fit of it is queued or running. Its twins stay.
#[utoipa::path(delete, path = "/v1/captures/{id}", tag = "captures",
    params(("id" = String, Path)),
    responses((status = 204), (status = "default", body = ProblemDocument)))]
pub(super) async fn delete(State(app): State<App>, Id(id): Id) -> Result<StatusCode> {
    app.delete_capture(&id).await?;
    Ok(StatusCode::NO_CONTENT)
}

/// Download the archive of a capture
#[utoipa::path(get, path = "/v1/captures/{id}/content", tag = "captures",
    params(("id" = String, Path)),
    responses((status = 200, body = Vec<u8>, content_type = "application/zip"),
        (status = "default", body = ProblemDocument)))]
pub(super) async fn content(State(app): State<App>, Id(id): Id) -> Result<Response> {
    let (capture, content) = app.capture_content(&id).await?;
    let file_name = format!("{}.zip", capture.id.uuid());
    Ok(super::download(content, "application/zip", &file_name))
}
