//! Headers of every response that tell browsers and proxies what not to do with it.

use axum::{
    body::Body,
    http::{HeaderName, HeaderValue, Response, header},
};

/// Tells nginx not to collect a stream of events before it passes it on.
const UNBUFFERED: HeaderName = HeaderName::from_static("x-accel-buffering");
/// A year, as browsers' lists of such sites require.
const ENCRYPTED_ONLY: HeaderValue = HeaderValue::from_static("max-age=31536000");

/// Adds the headers of every response. `host` is the name by which the server was called, over TLS if
/// `is_encrypted`.
pub(super) fn harden(response: &mut Response<Body>, host: Option<&str>, is_encrypted: bool) {
    let headers = response.headers_mut();
    headers.entry(header::X_CONTENT_TYPE_OPTIONS).or_insert(HeaderValue::from_static("nosniff"));
    let media_type = headers.get(header::CONTENT_TYPE).map(HeaderValue::as_bytes);
    if media_type.is_some_and(|kind| kind.starts_with(b"text/event-stream")) {
        headers.insert(UNBUFFERED, HeaderValue::from_static("no"));
    }
    // A browser takes it for all ports of a name: for `localhost`, those of other programs.
    if is_encrypted && host.is_some_and(|host| !host.eq_ignore_ascii_case("localhost")) {
        headers.insert(header::STRICT_TRANSPORT_SECURITY, ENCRYPTED_ONLY);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn hardened(kind: &'static str, host: &str, is_encrypted: bool) -> axum::http::HeaderMap {
        let mut response = Response::builder().header(header::CONTENT_TYPE, kind);
        response = response.header("x-kept", "1");
        let mut response = response.body(Body::empty()).unwrap();
        harden(&mut response, Some(host), is_encrypted);
        response.into_parts().0.headers
    }

    #[test]
    fn responses_are_neither_guessed_nor_collected_nor_repeated_without_tls() {
        let json = hardened("application/json", "twin.example.org", false);
        assert_eq!(json["x-content-type-options"], "nosniff");
        assert!(!json.contains_key("strict-transport-security"));
        assert!(!json.contains_key("x-accel-buffering"));
        let events = hardened("text/event-stream", "twin.example.org", true);
        assert_eq!(events["x-accel-buffering"], "no");
        assert_eq!(events["strict-transport-security"], "max-age=31536000");
        let local = hardened("application/json", "LOCALHOST", true);
        assert!(!local.contains_key("strict-transport-security"));
    }
}
