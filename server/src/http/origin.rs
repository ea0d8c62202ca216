//! Requests that a browser sends on behalf of another site. There is no login that would keep them
//! out, so a web page that a user opens must not reach the server on the user's machine.

use std::net::IpAddr;

use axum::{
    body::Body,
    http::{HeaderMap, Request, Uri, header, uri::Authority},
};
use bendtwin_core::{Category, Fault};

use crate::error::Refusal;

/// True if the request comes from a page of another host than the one it is sent to. Programs other
/// than browsers send no `Origin`.
pub(super) fn is_foreign(headers: &HeaderMap) -> bool {
    let Some(origin) = headers.get(header::ORIGIN) else { return false };
    let origin = origin.to_str().ok().and_then(|o| o.parse::<Uri>().ok());
    let host = headers.get(header::HOST).and_then(|h| h.to_str().ok());
    match (origin.as_ref().and_then(Uri::authority), host) {
        (Some(origin), Some(host)) => !origin.as_str().eq_ignore_ascii_case(host),
        // `null`, or nothing to compare it with.
        _ => true,
    }
}

/// True if a request to a server on loopback names a host other than `localhost`: a page whose own
/// name was made to point to this machine does so (DNS rebinding). Its `Origin` and `Host` agree.
pub(super) fn is_rebound(request: &Request<Body>) -> bool {
    let host = request.headers().get(header::HOST).and_then(|h| h.to_str().ok());
    let named = host.and_then(|h| h.parse::<Authority>().ok());
    let Some(authority) = request.uri().authority().cloned().or(named) else { return false };
    let host = authority.host();
    !host.eq_ignore_ascii_case("localhost")
        && host.trim_matches(['[', ']']).parse::<IpAddr>().is_err()
}

pub(super) fn refusal() -> Refusal {
    Refusal::new(Fault {
        category: Category::PermissionDenied,
        reason: "FOREIGN_ORIGIN".to_owned(),
        message: "pages of other sites may not use this server; a program asks for it as localhost or by \
                  its address"
            .to_owned(),
    })
}
