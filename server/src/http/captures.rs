//! `/v1/captures`: uploads, downloads and reports.

use axum::{
    extract::{Request, State},
    http::{HeaderMap, HeaderValue, StatusCode, header},
    response::{IntoResponse, Response},
};

use bendtwin_proto::v1::CaptureMetadata;

use super::{
    Result,
    download::{download, inline},
    extract::{self, Id, Metadata},
    message::document,
};
use crate::{app::App, grpc::convert};

/// Security policy of a report's page. The page was made from an untrusted file, so it may show its
/// text and embedded pictures, and has no scripts, no network, no forms and no origin.
const REPORT_POLICY: &str = "default-src 'none'; style-src 'unsafe-inline'; img-src data:; \
                             base-uri 'none'; form-action 'none'; frame-ancestors 'none'; sandbox";

/// Media types of an upload: its kind is recognised by its content.
const ARCHIVES: &[&str] =
    &["application/zip", "application/x-tar", "application/gzip", "application/octet-stream"];

/// Upload a capture
pub(super) async fn create(
    State(app): State<App>,
    Metadata(mut metadata): Metadata<CaptureMetadata>,
    request: Request,
) -> Result<Response> {
    extract::expect_type(request.headers(), ARCHIVES)?;
    metadata.request_id = extract::idempotency_key(request.headers())?;
    metadata.digest = extract::declared_digest(request.headers(), metadata.digest)?;
    let body = extract::upload_body(request);
    let capture = convert::capture(app.create_capture(metadata, body).await?);
    let location = [(header::LOCATION, format!("/v1/{}", capture.name))];
    Ok((StatusCode::CREATED, location, document(&capture)).into_response())
}

/// Download the archive of a capture
pub(super) async fn content(
    State(app): State<App>,
    Id(id): Id,
    headers: HeaderMap,
) -> Result<Response> {
    let (capture, content) = app.capture_content(&id).await?;
    let file_name = format!("{}.zip", capture.id.uuid());
    download(&headers, content, "application/zip", &file_name).await
}

/// The report of a capture
pub(super) async fn report(State(app): State<App>, Id(id): Id) -> Result<Response> {
    let content = app.capture_report(&id, false).await?;
    Ok(inline(content, "application/json"))
}

/// The report of a capture as a page
pub(super) async fn report_page(State(app): State<App>, Id(id): Id) -> Result<Response> {
    let content = app.capture_report(&id, true).await?;
    let mut page = inline(content, "text/html; charset=utf-8");
    page.headers_mut()
        .insert(header::CONTENT_SECURITY_POLICY, HeaderValue::from_static(REPORT_POLICY));
    Ok(page)
}

/// Download the observation of a capture
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
pub(super) async fn playback(
    State(app): State<App>,
    Id(id): Id,
    headers: HeaderMap,
) -> Result<Response> {
    let (capture, content) = app.playback(&id).await?;
    let file_name = format!("{}.playback", capture.uuid());
    download(&headers, content, "application/octet-stream", &file_name).await
}
