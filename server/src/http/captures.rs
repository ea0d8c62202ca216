//! `/v1/captures`.

use axum::{
    Json,
    extract::{Request, State},
    http::{HeaderMap, HeaderValue, StatusCode, header},
    response::{IntoResponse, Response},
};

use super::{
    Result,
    download::{download, inline},
    extract::{self, Id, Params},
    labels::{CaptureList, LabelUpdate},
    resource::{Capture, CaptureParams, Captures, NewIngest},
};
use crate::{
    app::{App, CaptureUpload, read_requirements},
    error::ProblemDocument,
};

/// Security policy of a report's page. The page was made from an untrusted file, so it may show its
/// text and embedded pictures, and has no scripts, no network, no forms and no origin.
const REPORT_POLICY: &str = "default-src 'none'; style-src 'unsafe-inline'; img-src data:; \
                             base-uri 'none'; form-action 'none'; frame-ancestors 'none'; sandbox";

/// Media types of an upload: what it holds is told by its content.
const ARCHIVES: &[&str] =
    &["application/zip", "application/x-tar", "application/gzip", "application/octet-stream"];

/// List captures
#[utoipa::path(get, path = "/v1/captures", tag = "captures", params(CaptureList),
    responses((status = 200, body = Captures), (status = "default", body = ProblemDocument)))]
pub(super) async fn list(
    State(app): State<App>,
    Params(list): Params<CaptureList>,
) -> Result<Json<Captures>> {
    let page = app.captures(list.into()).await?;
    let captures = page.items.into_iter().map(Capture::from).collect();
    Ok(Json(Captures { captures, next_page_token: page.next_token }))
}

/// Upload a capture
///
/// The body is the archive, ZIP or tar, or an MCAP file. It is read in the background: `ingest` in the response has the
/// progress. The same archive under the same `Idempotency-Key` answers with the existing capture.
#[utoipa::path(post, path = "/v1/captures", tag = "captures",
    params(
        CaptureParams,
        ("Idempotency-Key" = Option<String>, Header, description = "Makes the upload idempotent"),
        ("X-Content-Blake3" = Option<String>, Header, description = "BLAKE3 of the body, hex; checked"),
        ("Content-Digest" = Option<String>, Header, description = "blake3=:{base64}:; checked")),
    request_body(content = Vec<u8>, content_type = "application/zip"),
    responses((status = 201, body = Capture), (status = "default", body = ProblemDocument)))]
pub(super) async fn create(
    State(app): State<App>,
    Params(params): Params<CaptureParams>,
    request: Request,
) -> Result<Response> {
    extract::expect_type(request.headers(), ARCHIVES)?;
    let upload = CaptureUpload {
        display_name: params.display_name,
        request_id: extract::idempotency_key(request.headers())?,
        digest: extract::declared_digest(request.headers(), params.digest)?,
        ingest_json: params.ingest,
        requirements: read_requirements(&params.ingest_requirements)?,
        body: extract::upload_body(request),
    };
    let capture = app.create_capture(upload).await?;
    let location = [(header::LOCATION, format!("/v1/{}", capture.capture.id))];
    Ok((StatusCode::CREATED, location, Json(Capture::from(capture))).into_response())
}

/// One capture
#[utoipa::path(get, path = "/v1/captures/{id}", tag = "captures",
    params(("id" = String, Path)),
    responses((status = 200, body = Capture), (status = "default", body = ProblemDocument)))]
pub(super) async fn get(State(app): State<App>, Id(id): Id) -> Result<Json<Capture>> {
    Ok(Json(app.capture(&id).await?.into()))
}

/// Change name, note and tags of a capture
#[utoipa::path(patch, path = "/v1/captures/{id}", tag = "captures",
    params(("id" = String, Path)),
    request_body = LabelUpdate,
    responses((status = 200, body = Capture), (status = "default", body = ProblemDocument)))]
pub(super) async fn update(
    State(app): State<App>,
    Id(id): Id,
    extract::Json(change): extract::Json<LabelUpdate>,
) -> Result<Json<Capture>> {
    Ok(Json(app.update_capture(&id, change.into()).await?.into()))
}

/// Delete a capture
///
/// Its observation, playback and report are deleted, too. Refused while a fit of it is queued or running. Its
/// twins stay.
#[utoipa::path(delete, path = "/v1/captures/{id}", tag = "captures",
    params(("id" = String, Path)),
    responses((status = 204), (status = "default", body = ProblemDocument)))]
pub(super) async fn delete(State(app): State<App>, Id(id): Id) -> Result<StatusCode> {
    app.delete_capture(&id).await?;
    Ok(StatusCode::NO_CONTENT)
}

/// Download the archive of a capture
#[utoipa::path(get, path = "/v1/captures/{id}/content", tag = "captures",
    params(("id" = String, Path),
        ("Range" = Option<String>, Header, description = "One range of bytes"),
        ("If-Range" = Option<String>, Header, description = "The ETag that the range is of")),
    responses((status = 200, body = Vec<u8>, content_type = "application/zip"),
        (status = 206, body = Vec<u8>, content_type = "application/zip"),
        (status = "default", body = ProblemDocument)))]
pub(super) async fn content(
    State(app): State<App>,
    Id(id): Id,
    headers: HeaderMap,
) -> Result<Response> {
    let (capture, content) = app.capture_content(&id).await?;
    let file_name = format!("{}.zip", capture.id.uuid());
    download(&headers, content, "application/zip", &file_name).await
}

/// Read a capture again
///
/// For example with other settings. Refused while it is being read, and while a fit of it is queued
/// or running.
#[utoipa::path(post, path = "/v1/captures/{id}/ingest", tag = "captures",
    params(("id" = String, Path),
        ("Idempotency-Key" = Option<String>, Header, description = "Makes the call idempotent")),
    request_body = NewIngest,
    responses((status = 202, body = Capture), (status = "default", body = ProblemDocument)))]
pub(super) async fn ingest(
    State(app): State<App>,
    Id(id): Id,
    headers: HeaderMap,
    extract::Json(new): extract::Json<NewIngest>,
) -> Result<Response> {
    let settings = new.settings.as_deref().map_or("", |s| s.get());
    let key = extract::idempotency_key(&headers)?;
    let requirements = new.requirements.into();
    let capture = app.ingest_capture(&id, settings, requirements, key).await?;
    Ok((StatusCode::ACCEPTED, Json(Capture::from(capture))).into_response())
}

/// Ask the ingest of a capture to stop
///
/// An ingest that has ended is returned as it is.
#[utoipa::path(post, path = "/v1/captures/{id}/ingest/cancel", tag = "captures",
    params(("id" = String, Path)),
    responses((status = 200, body = Capture), (status = "default", body = ProblemDocument)))]
pub(super) async fn cancel_ingest(State(app): State<App>, Id(id): Id) -> Result<Json<Capture>> {
    Ok(Json(app.cancel_ingest(&id).await?.into()))
}

/// The report of a capture
#[utoipa::path(get, path = "/v1/captures/{id}/report", tag = "captures",
    params(("id" = String, Path)),
    responses((status = 200, body = Object, content_type = "application/json"),
        (status = "default", body = ProblemDocument)))]
pub(super) async fn report(State(app): State<App>, Id(id): Id) -> Result<Response> {
    let content = app.capture_report(&id, false).await?;
    Ok(inline(content, "application/json"))
}

/// The report of a capture as a page
///
/// The pictures are embedded. The page has no scripts, and its security policy allows none.
#[utoipa::path(get, path = "/v1/captures/{id}/report.html", tag = "captures",
    params(("id" = String, Path)),
    responses((status = 200, body = String, content_type = "text/html"),
        (status = "default", body = ProblemDocument)))]
pub(super) async fn report_page(State(app): State<App>, Id(id): Id) -> Result<Response> {
    let content = app.capture_report(&id, true).await?;
    let mut page = inline(content, "text/html; charset=utf-8");
    page.headers_mut()
        .insert(header::CONTENT_SECURITY_POLICY, HeaderValue::from_static(REPORT_POLICY));
    Ok(page)
}

/// Download the observation of a capture
///
/// The bundle that fits read: tracked points in space, whatever the format of the capture.
#[utoipa::path(get, path = "/v1/captures/{id}/observation", tag = "captures",
    params(("id" = String, Path),
        ("Range" = Option<String>, Header, description = "One range of bytes"),
        ("If-Range" = Option<String>, Header, description = "The ETag that the range is of")),
    responses((status = 200, body = Vec<u8>, content_type = "application/zip"),
        (status = 206, body = Vec<u8>, content_type = "application/zip"),
        (status = "default", body = ProblemDocument)))]
pub(super) async fn observation(
    State(app): State<App>,
    Id(id): Id,
    headers: HeaderMap,
) -> Result<Response> {
    let (capture, _, content) = app.observation(&id).await?;
    let file_name = format!("{}-observation.zip", capture.uuid());
    download(&headers, content, "application/zip", &file_name).await
}

/// Download the playback of a capture
///
/// What a player shows, for reading by ranges: tracked points as 16-bit numbers and small images of
/// the cameras (docs/formats/playback.md). A capture that was read before there were playbacks has none until
/// its ingest is run again.
#[utoipa::path(get, path = "/v1/captures/{id}/playback", tag = "captures",
    params(("id" = String, Path),
        ("Range" = Option<String>, Header, description = "One range of bytes"),
        ("If-Range" = Option<String>, Header, description = "The ETag that the range is of")),
    responses((status = 200, body = Vec<u8>, content_type = "application/octet-stream"),
        (status = 206, body = Vec<u8>, content_type = "application/octet-stream"),
        (status = "default", body = ProblemDocument)))]
pub(super) async fn playback(
    State(app): State<App>,
    Id(id): Id,
    headers: HeaderMap,
) -> Result<Response> {
    let (capture, content) = app.playback(&id).await?;
    let file_name = format!("{}.playback", capture.uuid());
    download(&headers, content, "application/octet-stream", &file_name).await
}
