//! `/v1/captures`: uploads, downloads, reports, and files that are added later.

use axum::{
    extract::{Request, State},
    http::{HeaderMap, HeaderValue, StatusCode, header},
    response::{IntoResponse, Response},
};

use bendtwin_proto::v1::{CaptureMetadata, SupplementMetadata};
use bendtwin_store::SupplementKind;
use serde::Deserialize;

use super::{
    Result,
    download::{download, inline},
    extract::{self, Id, IdAndKind, Metadata, Params},
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

/// Media types of a file that is added to a capture.
const SUPPLEMENTS: &[&str] = &[
    "application/zip",
    "application/x-tar",
    "application/gzip",
    "application/json",
    "application/octet-stream",
];

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

/// Download the masks of a capture
pub(super) async fn masks(
    State(app): State<App>,
    Id(id): Id,
    headers: HeaderMap,
) -> Result<Response> {
    let (capture, content) = app.masks(&id).await?;
    let file_name = format!("{}-masks.zip", capture.uuid());
    download(&headers, content, "application/zip", &file_name).await
}

/// The digest of a body.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct DigestParams {
    /// BLAKE3, hex; checked.
    #[serde(default)]
    digest: String,
}

/// Add a file to a capture
pub(super) async fn add_supplement(
    State(app): State<App>,
    IdAndKind(id, kind): IdAndKind,
    Params(params): Params<DigestParams>,
    request: Request,
) -> Result<Response> {
    extract::expect_type(request.headers(), SUPPLEMENTS)?;
    let digest = extract::declared_digest(request.headers(), params.digest)?;
    let metadata = SupplementMetadata { name: id, kind, digest };
    let body = extract::upload_body(request);
    let capture = convert::capture(app.add_supplement(metadata, body).await?);
    Ok(document(&capture).into_response())
}

/// Download a file that was added to a capture
pub(super) async fn supplement(
    State(app): State<App>,
    IdAndKind(id, kind): IdAndKind,
    headers: HeaderMap,
) -> Result<Response> {
    let (capture, kind, content) = app.supplement(&id, &kind).await?;
    let (media_type, ending) = match kind {
        SupplementKind::Masks => ("application/octet-stream", ""),
        SupplementKind::Calibration => ("application/json", ".json"),
    };
    let file_name = format!("{}-{kind}{ending}", capture.uuid());
    download(&headers, content, media_type, &file_name).await
}

/// Remove a file that was added to a capture
pub(super) async fn delete_supplement(
    State(app): State<App>,
    IdAndKind(id, kind): IdAndKind,
) -> Result<StatusCode> {
    app.delete_supplement(&id, &kind).await?;
    Ok(StatusCode::NO_CONTENT)
}
