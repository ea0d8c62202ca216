//! Requests that a browser sends on behalf of another site: a web page that a user opens must not
//! reach the server on the user's machine. A page gives itself away by its `Origin`, or by the name
//! of its own site as the host, where that name was made to point here (DNS rebinding).

use std::{net::IpAddr, sync::Arc};

use axum::{
    body::Body,
    http::{HeaderMap, Request, StatusCode, Uri, header, uri::Authority},
};
use bendtwin_core::{Category, Fault};

use crate::refusal::Refusal;

/// The names by which a server may be called.
#[derive(Clone, Debug)]
pub(crate) struct Hosts {
    /// `*` means any.
    names: Arc<[String]>,
}

impl Hosts {
    pub(crate) fn new(names: &[String]) -> Self {
        Self { names: names.into() }
    }

    /// Checks the host that a request is for, and the page that it comes from.
    pub(super) fn check(&self, request: &Request<Body>) -> Result<(), Refusal> {
        let host = host(request)?;
        if let Some(host) = &host
            && !self.allows(host.host())
        {
            return Err(unknown_host(host.host()));
        }
        if is_foreign(request.headers(), host.as_ref()) { Err(foreign()) } else { Ok(()) }
    }

    /// `localhost`, any address, and the configured names: a page elsewhere has no such name.
    pub(crate) fn allows(&self, host: &str) -> bool {
        host.eq_ignore_ascii_case("localhost")
            || host.trim_matches(['[', ']']).parse::<IpAddr>().is_ok()
            || self.names.iter().any(|name| name == "*" || name.eq_ignore_ascii_case(host))
    }
}

/// The one host that a request names; HTTP/1.0 does without.
pub(super) fn host(request: &Request<Body>) -> Result<Option<Authority>, Refusal> {
    let mut headers = request.headers().get_all(header::HOST).iter();
    let first = headers.next();
    if headers.next().is_some() {
        return Err(invalid_host("there are several Host headers"));
    }
    let named = match first.map(|value| value.to_str().map(str::parse::<Authority>)) {
        None => None,
        Some(Ok(Ok(host))) if !host.as_str().contains('@') => Some(host),
        Some(_) => return Err(invalid_host("the Host header is not of the form host:port")),
    };
    match (request.uri().authority(), named) {
        (Some(target), _) if target.as_str().contains('@') => {
            Err(invalid_host("the address of the request has a user name"))
        }
        (Some(target), Some(named)) if *target != named => {
            Err(invalid_host("the Host header differs from the address of the request"))
        }
        (Some(target), _) => Ok(Some(target.clone())),
        (None, named) => Ok(named),
    }
}

/// True if the request comes from a page of another host than the one it is sent to. Programs other
/// than browsers send no `Origin`.
fn is_foreign(headers: &HeaderMap, host: Option<&Authority>) -> bool {
    let mut origins = headers.get_all(header::ORIGIN).iter();
    let Some(origin) = origins.next() else { return false };
    let origin = origin.to_str().ok().and_then(|o| o.parse::<Uri>().ok());
    match (origin.as_ref().and_then(Uri::authority), host) {
        // Authorities are equal regardless of case.
        (Some(origin), Some(host)) => origin != host || origins.next().is_some(),
        // `null`, or nothing to compare it with.
        _ => true,
    }
}

fn invalid_host(fault: &str) -> Refusal {
    let message = format!("{fault}: name the server once");
    Refusal::http_only(StatusCode::BAD_REQUEST, "INVALID_HOST", &message)
}

fn unknown_host(host: &str) -> Refusal {
    let host: String = host.chars().take(100).collect();
    Refusal::new(Fault {
        category: Category::PermissionDenied,
        reason: "HOST_NOT_ALLOWED".to_owned(),
        message: format!(
            "`{host}` is not a name of this server: call it as localhost or by its address, or \
             start it with --allowed-host {host} (option allowed_hosts)"
        ),
    })
}

fn foreign() -> Refusal {
    Refusal::new(Fault {
        category: Category::PermissionDenied,
        reason: "FOREIGN_ORIGIN".to_owned(),
        message:
            "pages of other sites may not use this server: use it from a program, or from its \
                  own pages"
                .to_owned(),
    })
}

#[cfg(test)]
mod tests;
