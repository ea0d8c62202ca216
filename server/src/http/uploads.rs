//! `/v1/uploads`: resumable uploads of captures by the tus protocol, 1.0.0
//! (<https://tus.io/protocols/resumable-upload>), with its extensions creation,
//! creation-with-upload, creation-defer-length, checksum, expiration and
//! termination. `protocol.rs` has the headers, `listing.rs` what is no part of the protocol.

mod listing;
mod protocol;

use axum::{
    extract::{Request, State},
    http::{HeaderMap, HeaderName, HeaderValue, StatusCode, header},
    response::{IntoResponse, Response},
};
use bendtwin_store::{ResumableUpload, UploadState};

use super::{
    Result, Routes,
    extract::{self, Id},
};
use crate::{
    app::{self, ALGORITHMS, App, Append, NewUpload},
    refusal::Refusal,
};

pub use protocol::read_upload_headers;
pub(crate) use protocol::with_overridden_method;
use protocol::{
    BENDTWIN_CAPTURE, EXTENSIONS, TUS_CHECKSUM_ALGORITHM, TUS_EXTENSION, TUS_MAX_SIZE, TUS_VERSION,
    UPLOAD_DEFER_LENGTH, UPLOAD_EXPIRES, UPLOAD_LENGTH, UPLOAD_METADATA, UPLOAD_OFFSET, VERSION,
};

/// The routes, with the headers that the protocol requires in every request and response.
pub(super) fn routes() -> Routes {
    let routes = Routes::default()
        .on("OPTIONS", "/v1/uploads", options)
        .on("POST", "/v1/uploads", create)
        .on("GET", "/v1/uploads", listing::list)
        .on("HEAD", "/v1/uploads/{id}", head)
        .on("GET", "/v1/uploads/{id}", listing::get)
        .on("PATCH", "/v1/uploads/{id}", append)
        .on("DELETE", "/v1/uploads/{id}", terminate);
    let version = axum::middleware::from_fn(protocol::require_version);
    Routes { router: routes.router.route_layer(version), ..routes }
}

/// Supported features of tus
async fn options(State(app): State<App>) -> Response {
    let headers = [
        (TUS_VERSION, VERSION.to_owned()),
        (TUS_EXTENSION, EXTENSIONS.join(",")),
        (TUS_MAX_SIZE, app.options().limits.capture_bytes.to_string()),
        (TUS_CHECKSUM_ALGORITHM, ALGORITHMS.join(",")),
    ];
    (StatusCode::NO_CONTENT, headers).into_response()
}

/// Begin a resumable upload
async fn create(State(app): State<App>, request: Request) -> Result<Response> {
    let headers = request.headers();
    // With a body, the rules of PATCH hold; a wrong type is refused before anything is made.
    let body = match protocol::body_size(headers)? {
        Some(0) => None,
        None if !headers.contains_key(header::TRANSFER_ENCODING)
            && !headers.contains_key(header::CONTENT_TYPE) =>
        {
            None
        }
        size_bytes => {
            protocol::expect_offset_type(headers)?;
            Some((size_bytes, protocol::checksum(headers)?))
        }
    };
    let new = NewUpload {
        length_bytes: protocol::declared_length(headers)?,
        metadata: protocol::text(headers, &UPLOAD_METADATA)?.unwrap_or_default().to_owned(),
        request_id: extract::idempotency_key(headers)?,
        has_content: body.is_some(),
    };
    let mut upload = app.create_upload(new).await.map_err(refused)?;
    if let Some((size_bytes, checksum)) = body
        && upload.offset_bytes == 0
    {
        let body = extract::upload_body(request);
        let append = Append { offset: 0, size_bytes, length_bytes: None, checksum, body };
        upload = app.append_upload(&upload.id.to_string(), append).await.map_err(refused)?;
    }
    let location = [(header::LOCATION, format!("/v1/{}", upload.id))];
    Ok((StatusCode::CREATED, location, state_of(&upload)).into_response())
}

/// Offset at which to resume
async fn head(State(app): State<App>, Id(id): Id) -> Result<Response> {
    let upload = app.resume_upload(&id).await.map_err(refused)?;
    let mut response = state_of(&upload);
    match upload.length_bytes {
        Some(length) => response.insert(UPLOAD_LENGTH, length.into()),
        None => response.insert(UPLOAD_DEFER_LENGTH, HeaderValue::from_static("1")),
    };
    if !upload.metadata.is_empty()
        && let Ok(metadata) = HeaderValue::from_str(&upload.metadata)
    {
        response.insert(UPLOAD_METADATA, metadata);
    }
    response.insert(header::CACHE_CONTROL, HeaderValue::from_static("no-store"));
    Ok((StatusCode::OK, response).into_response())
}

/// Append to an upload
async fn append(State(app): State<App>, Id(id): Id, request: Request) -> Result<Response> {
    let headers = request.headers();
    protocol::expect_offset_type(headers)?;
    let append = Append {
        offset: protocol::offset(headers)?,
        size_bytes: protocol::body_size(headers)?,
        length_bytes: protocol::number(headers, &UPLOAD_LENGTH)?,
        checksum: protocol::checksum(headers)?,
        body: extract::upload_body(request),
    };
    let upload = app.append_upload(&id, append).await.map_err(refused)?;
    Ok((StatusCode::NO_CONTENT, state_of(&upload)).into_response())
}

/// Terminate an upload
async fn terminate(State(app): State<App>, Id(id): Id) -> Result<StatusCode> {
    app.terminate_upload(&id).await.map_err(refused)?;
    Ok(StatusCode::NO_CONTENT)
}

/// The headers that tell of an upload in every answer about it.
fn state_of(upload: &ResumableUpload) -> HeaderMap {
    let mut headers = HeaderMap::new();
    headers.insert(UPLOAD_OFFSET, upload.offset_bytes.into());
    let mut set = |name: HeaderName, value: String| {
        if let Ok(value) = HeaderValue::from_str(&value) {
            headers.insert(name, value);
        }
    };
    match upload.state {
        UploadState::Stored(capture) => {
            set(BENDTWIN_CAPTURE, capture.to_string());
            set(header::CONTENT_LOCATION, format!("/v1/{capture}"));
        }
        _ => set(UPLOAD_EXPIRES, protocol::date(upload.expires)),
    }
    headers
}

fn refused(error: app::Error) -> Refusal {
    Refusal::from(error).with_tus_status()
}
