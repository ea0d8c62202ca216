//! The headers of tus 1.0.0: their names, those of every request and response, and their parsing.

use axum::{
    extract::Request,
    http::{HeaderMap, HeaderName, HeaderValue, Method, StatusCode, header},
    middleware::Next,
    response::{IntoResponse, Response},
};
use jiff::Timestamp;

use super::super::{Result, extract};
use crate::{
    app::{Checksum, Error, capture_name},
    refusal::Refusal,
};

pub(super) const VERSION: &str = "1.0.0";
pub(super) const EXTENSIONS: [&str; 6] = [
    "creation",
    "creation-with-upload",
    "creation-defer-length",
    "checksum",
    "expiration",
    "termination",
];
/// The media type of every part of an upload.
pub(super) const OFFSET_TYPE: &str = "application/offset+octet-stream";
/// Path of all uploads.
const PATH: &str = "/v1/uploads";

const TUS_RESUMABLE: HeaderName = HeaderName::from_static("tus-resumable");
pub(super) const TUS_VERSION: HeaderName = HeaderName::from_static("tus-version");
pub(super) const TUS_EXTENSION: HeaderName = HeaderName::from_static("tus-extension");
pub(super) const TUS_MAX_SIZE: HeaderName = HeaderName::from_static("tus-max-size");
pub(super) const TUS_CHECKSUM_ALGORITHM: HeaderName =
    HeaderName::from_static("tus-checksum-algorithm");
pub(super) const UPLOAD_OFFSET: HeaderName = HeaderName::from_static("upload-offset");
pub(super) const UPLOAD_LENGTH: HeaderName = HeaderName::from_static("upload-length");
pub(super) const UPLOAD_DEFER_LENGTH: HeaderName = HeaderName::from_static("upload-defer-length");
pub(super) const UPLOAD_METADATA: HeaderName = HeaderName::from_static("upload-metadata");
pub(super) const UPLOAD_EXPIRES: HeaderName = HeaderName::from_static("upload-expires");
const UPLOAD_CHECKSUM: HeaderName = HeaderName::from_static("upload-checksum");
/// Names the capture that an upload became.
pub(super) const BENDTWIN_CAPTURE: HeaderName = HeaderName::from_static("bendtwin-capture");
const METHOD_OVERRIDE: HeaderName = HeaderName::from_static("x-http-method-override");

/// Replaces the method by the one of `X-HTTP-Method-Override`, for clients that cannot send PATCH
/// or DELETE.
pub(crate) fn with_overridden_method<B>(
    mut request: axum::http::Request<B>,
) -> axum::http::Request<B> {
    let path = request.uri().path();
    let is_ours =
        path.strip_prefix(PATH).is_some_and(|rest| rest.is_empty() || rest.starts_with('/'));
    if is_ours
        && let Some(name) = request.headers_mut().remove(METHOD_OVERRIDE)
        && let Ok(method) = Method::from_bytes(name.as_bytes())
    {
        *request.method_mut() = method;
    }
    request
}

/// Refuses other versions of the protocol, and names the supported one in every response. OPTIONS
/// needs no version, because clients learn it there; GET is not part of the protocol; and DELETE
/// means the same with and without it.
pub(super) async fn require_version(request: Request, next: Next) -> Response {
    let free = [Method::OPTIONS, Method::GET].contains(request.method());
    let version = request.headers().get(TUS_RESUMABLE);
    let free = free || version.is_none() && request.method() == Method::DELETE;
    let mut response = if free || version.is_some_and(|v| v == VERSION) {
        next.run(request).await
    } else {
        let message = "send `Tus-Resumable: 1.0.0`, the only version of tus that is supported";
        let status = StatusCode::PRECONDITION_FAILED;
        let mut response =
            Refusal::http_only(status, "TUS_VERSION_UNSUPPORTED", message).into_response();
        response.headers_mut().insert(TUS_VERSION, HeaderValue::from_static(VERSION));
        response
    };
    response.headers_mut().insert(TUS_RESUMABLE, HeaderValue::from_static(VERSION));
    response
}

/// A header's text.
pub(super) fn text<'a>(headers: &'a HeaderMap, name: &HeaderName) -> Result<Option<&'a str>> {
    let mut values = headers.get_all(name).iter();
    let (Some(value), None) = (values.next(), values.next()) else {
        return if headers.contains_key(name) {
            Err(invalid(name, "is given twice"))
        } else {
            Ok(None)
        };
    };
    value.to_str().map(Some).map_err(|_| invalid(name, "is not printable ASCII"))
}

/// A header's non-negative integer.
pub(super) fn number(headers: &HeaderMap, name: &HeaderName) -> Result<Option<u64>> {
    let Some(text) = text(headers, name)? else { return Ok(None) };
    let digits = Some(text.trim()).filter(|t| t.bytes().all(|b| b.is_ascii_digit()));
    let number = digits.and_then(|d| d.parse().ok());
    number.map(Some).ok_or_else(|| invalid(name, "is not a non-negative integer"))
}

/// Offset at which the body begins.
pub(super) fn offset(headers: &HeaderMap) -> Result<u64> {
    number(headers, &UPLOAD_OFFSET)?.ok_or_else(|| {
        invalid(&UPLOAD_OFFSET, "is missing: send the offset at which the body begins")
    })
}

/// The length of a new upload, or none if it is declared to be unknown yet.
pub(super) fn declared_length(headers: &HeaderMap) -> Result<Option<u64>> {
    let deferred = match text(headers, &UPLOAD_DEFER_LENGTH)? {
        None => false,
        Some("1") => true,
        Some(_) => return Err(invalid(&UPLOAD_DEFER_LENGTH, "must be 1 where it is given")),
    };
    match (number(headers, &UPLOAD_LENGTH)?, deferred) {
        (Some(length), false) => Ok(Some(length)),
        (None, true) => Ok(None),
        (Some(_), true) => Err(invalid(&UPLOAD_DEFER_LENGTH, "contradicts upload-length")),
        (None, false) => {
            Err(invalid(&UPLOAD_LENGTH, "is missing: give it, or upload-defer-length: 1"))
        }
    }
}

/// Size of the body, if declared.
pub(super) fn body_size(headers: &HeaderMap) -> Result<Option<u64>> {
    number(headers, &header::CONTENT_LENGTH)
}

pub(super) fn checksum(headers: &HeaderMap) -> Result<Option<Checksum>> {
    Ok(text(headers, &UPLOAD_CHECKSUM)?.map(Checksum::parse).transpose()?)
}

/// Refuses every type but that of the protocol; a missing type is refused too, unlike elsewhere.
pub(super) fn expect_offset_type(headers: &HeaderMap) -> Result<()> {
    if headers.contains_key(header::CONTENT_TYPE) {
        return extract::expect_type(headers, &[OFFSET_TYPE]);
    }
    let message = format!("send the body as {OFFSET_TYPE}");
    let status = StatusCode::UNSUPPORTED_MEDIA_TYPE;
    Err(Refusal::http_only(status, "UNSUPPORTED_MEDIA_TYPE", &message))
}

/// Reads headers as the requests of an upload do, without a request; for the fuzzer, which looks for
/// panics. Names and values that HTTP does not allow are left out.
#[doc(hidden)]
pub fn read_upload_headers<'h>(headers: impl Iterator<Item = (&'h [u8], &'h [u8])>) {
    let mut map = HeaderMap::new();
    for (name, value) in headers {
        if let Ok(name) = HeaderName::from_bytes(name)
            && let Ok(value) = HeaderValue::from_bytes(value)
        {
            map.append(name, value);
        }
    }
    let _ = (offset(&map), declared_length(&map), body_size(&map), expect_offset_type(&map));
    if let Ok(Some(metadata)) = text(&map, &UPLOAD_METADATA) {
        let _ = capture_name(metadata);
    }
    if let Ok(Some(mut checksum)) = checksum(&map) {
        checksum.update(b"content");
        let _ = checksum.verify();
    }
}

/// A time as HTTP has it (RFC 9110): `Wed, 25 Jun 2014 16:00:00 GMT`.
pub(super) fn date(time: Timestamp) -> String {
    let printer = jiff::fmt::rfc2822::DateTimePrinter::new();
    printer.timestamp_to_rfc9110_string(&time).unwrap_or_default()
}

fn invalid(name: &HeaderName, fault: &str) -> Refusal {
    Error::Invalid { field: "headers", fault: format!("are not those of tus: {name} {fault}") }
        .into()
}
