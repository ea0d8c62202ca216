//! Content as responses: whole, or the range that a client asks for to continue a download.

pub(super) mod thumbnails;

use std::ops::Range;

use axum::{
    body::Body,
    http::{HeaderMap, HeaderName, HeaderValue, StatusCode, header},
    response::{IntoResponse, Response},
};
use base64::{Engine as _, prelude::BASE64_STANDARD};
use bendtwin_store::Content;
use futures::TryStreamExt;

use super::Result;
use crate::refusal::Refusal;

/// Digests of RFC 9530: of what a response has, and of the whole that it is a part of.
const CONTENT_DIGEST: HeaderName = HeaderName::from_static("content-digest");
const REPR_DIGEST: HeaderName = HeaderName::from_static("repr-digest");

/// Part of a resource that a request is for.
#[derive(Debug, PartialEq, Eq)]
enum Part {
    Whole,
    Range(Range<u64>),
    /// Beyond the end.
    Nothing,
}

/// Content as a download, or the range of it that the request is for.
pub(super) async fn download(
    request: &HeaderMap,
    content: Content,
    media_type: &'static str,
    file_name: &str,
) -> Result<Response> {
    let size = content.size_bytes;
    let tag = tag(&content);
    let headers = [
        (header::ACCEPT_RANGES, "bytes".to_owned()),
        (header::CONTENT_DISPOSITION, format!("attachment; filename=\"{file_name}\"")),
    ];
    match part(request, size, &tag) {
        Part::Whole => Ok((headers, inline(content, media_type)).into_response()),
        Part::Range(range) => {
            let content_range = format!("bytes {}-{}/{size}", range.start, range.end - 1);
            let length = range.end - range.start;
            let mut part = content.range(range).await?;
            part.size_bytes = length;
            let content_range = [(header::CONTENT_RANGE, content_range)];
            let body = bytes(part, media_type);
            let response = (StatusCode::PARTIAL_CONTENT, headers, content_range, body);
            Ok(response.into_response())
        }
        Part::Nothing => {
            let message = format!("the content has {size} bytes: ask for a range within them");
            let refusal = Refusal::http_only(
                StatusCode::RANGE_NOT_SATISFIABLE,
                "RANGE_NOT_SATISFIABLE",
                &message,
            );
            Ok(([(header::CONTENT_RANGE, format!("bytes */{size}"))], refusal).into_response())
        }
    }
}

/// Content to be shown.
pub(super) fn inline(content: Content, media_type: &'static str) -> Response {
    let digest = [(CONTENT_DIGEST, digest(&content))];
    (digest, bytes(content, media_type)).into_response()
}

/// The bytes of content, or of a part of it. Browsers must not guess another type than the given
/// one.
fn bytes(content: Content, media_type: &'static str) -> Response {
    let headers = [
        (header::CONTENT_TYPE, media_type.to_owned()),
        (header::CONTENT_LENGTH, content.size_bytes.to_string()),
        (header::X_CONTENT_TYPE_OPTIONS, "nosniff".to_owned()),
        (header::ETAG, tag(&content)),
        (REPR_DIGEST, digest(&content)),
    ];
    // A read that fails in mid-stream cuts the body short of its length.
    let chunks = content.chunks.inspect_err(|error| tracing::error!(%error, "download broke off"));
    (headers, Body::from_stream(chunks)).into_response()
}

fn tag(content: &Content) -> String {
    format!("\"{}\"", content.digest.to_hex())
}

/// The digest in the form of RFC 9530, with an algorithm that its registry lacks; uploads declare
/// theirs in the same form.
fn digest(content: &Content) -> String {
    format!("blake3=:{}:", BASE64_STANDARD.encode(content.digest.as_bytes()))
}

/// The requested part. Ranges that are not understood, including several in one request, are
/// ignored, as RFC 9110 requires.
fn part(request: &HeaderMap, size: u64, tag: &str) -> Part {
    let text = |value: &HeaderValue| value.to_str().ok().map(str::to_owned);
    let condition = request.get(header::IF_RANGE);
    if condition.is_some_and(|value| value.as_bytes() != tag.as_bytes()) {
        return Part::Whole;
    }
    let asked = request.get(header::RANGE).and_then(text);
    let Some((first, last)) = asked.as_deref().and_then(bounds) else { return Part::Whole };
    match (first, last) {
        // The last bytes.
        (None, Some(0)) => Part::Nothing,
        (None, Some(count)) if size > 0 => Part::Range(size.saturating_sub(count)..size),
        (Some(first), Some(last)) if last < first => Part::Whole,
        (Some(first), last) if first < size => {
            Part::Range(first..last.map_or(size, |last| last.saturating_add(1).min(size)))
        }
        _ => Part::Nothing,
    }
}

/// First and last byte of `bytes=first-last`; one of them may be missing.
fn bounds(text: &str) -> Option<(Option<u64>, Option<u64>)> {
    let (unit, range) = text.split_once('=')?;
    let (first, last) = range.trim().split_once('-')?;
    let is_bytes = unit.trim().eq_ignore_ascii_case("bytes");
    let number = |text: &str| -> Option<Option<u64>> {
        match text {
            "" => Some(None),
            _ if text.bytes().all(|b| b.is_ascii_digit()) => {
                // More than any size is as good as the largest.
                Some(Some(text.parse().unwrap_or(u64::MAX)))
            }
            _ => None,
        }
    };
    let bounds = (number(first)?, number(last)?);
    (is_bytes && bounds != (None, None)).then_some(bounds)
}

#[cfg(test)]
mod tests;
