//! The service around every request of either transport: request id, tracing span, metrics, and an
//! answer for handlers that panic.

mod security;

use std::{
    collections::HashSet, convert::Infallible, panic::AssertUnwindSafe, sync::Arc, time::Instant,
};

use axum::{
    body::Body,
    extract::MatchedPath,
    http::{HeaderValue, Request, Response, StatusCode, header},
    response::IntoResponse,
};
use bendtwin_core::{Category, Fault};
use bendtwin_tls::Certificate;
use futures::FutureExt;
use http_body_util::BodyExt as _;
use tower::ServiceExt;
use tracing::Instrument;

use super::{
    origin::{self, Hosts},
    uploads,
};
use crate::{
    access::{self, Access, Caller, Flight, Gate, client_token},
    context::Context,
    deadline::{Call, Cut},
    metrics::Metrics,
    refusal::Refusal,
};

/// Both transports behind one service.
#[derive(Clone)]
pub(crate) struct RootService {
    pub(crate) http: axum::Router,
    pub(crate) grpc: axum::Router,
    pub(crate) metrics: Metrics,
    /// Paths of all gRPC methods that there are.
    pub(crate) methods: Arc<HashSet<String>>,
    pub(crate) hosts: Hosts,
    pub(crate) gate: Gate,
    pub(crate) transport: Transport,
}

/// Facts about the connection of a request.
#[derive(Clone, Debug, Default)]
pub(crate) enum Transport {
    /// Nothing was demanded of it.
    #[default]
    Plain,
    /// Over TLS, with the certificate of the peer if it was to show one.
    Tls(Option<PeerCertificate>),
    /// Without TLS, on a listener that has it.
    Refused,
}

/// Certificate that the peer of a connection showed.
#[derive(Clone, Debug)]
pub(crate) struct PeerCertificate(pub(crate) Arc<Certificate>);

impl RootService {
    /// The service of a connection over TLS.
    pub(crate) fn with_certificate(self, peer: Option<Certificate>) -> Self {
        let peer = peer.map(|certificate| PeerCertificate(certificate.into()));
        Self { transport: Transport::Tls(peer), ..self }
    }

    /// The service of a connection that began without TLS where it must not.
    pub(crate) fn refusing_without_tls(self) -> Self {
        Self { transport: Transport::Refused, ..self }
    }

    /// Answers one request.
    pub(crate) async fn answer(
        self,
        request: Request<Body>,
        call: &Call,
    ) -> Result<Response<Body>, Infallible> {
        let started = Instant::now();
        let Call { context, is_grpc, .. } = call;
        let is_grpc = *is_grpc;
        let trace_parent = context.client_trace_parent.as_deref().unwrap_or_default();
        let span = tracing::info_span!(
            "request",
            method = %request.method(),
            path = request.uri().path(),
            request_id = context.request_id,
            trace_parent,
        );
        bendtwin_telemetry::continue_from(&span, trace_parent);
        // The pattern or the method that matches, never any path: labels of metrics are to be few.
        let method = is_grpc.then(|| self.methods.get(request.uri().path()).cloned()).flatten();
        let metrics = self.metrics.clone();
        let is_encrypted = matches!(self.transport, Transport::Tls(_));
        let host = origin::host(&request).ok().flatten().map(|host| host.host().to_owned());
        let answered = context.clone().scope(self.admit_and_answer(request, call));
        let mut response = answered.instrument(span.clone()).await;
        if let Ok(id) = HeaderValue::from_str(&context.request_id) {
            response.headers_mut().insert("x-request-id", id);
        }
        if !is_grpc {
            security::harden(&mut response, host.as_deref(), is_encrypted);
        }
        let took = started.elapsed();
        let transport = if is_grpc { "grpc" } else { "http" };
        let code =
            if is_grpc { grpc_code(&response) } else { response.status().as_str().to_owned() };
        let matched = response.extensions().get::<Route>().map(|r| r.0.clone());
        let route = method.or(matched).unwrap_or_else(|| "none".to_owned());
        span.in_scope(|| tracing::debug!(code, took_s = took.as_secs_f64(), "answered"));
        let failed = is_grpc && code != "0" || response.status().is_server_error();
        bendtwin_telemetry::answered(&span, &route, &code, failed);
        metrics.request(transport, &route, &code, took);
        Ok(response)
    }

    async fn admit_and_answer(self, request: Request<Body>, call: &Call) -> Response<Body> {
        let admission = self.admission(&request, call.is_grpc);
        let admitted = match admission {
            Ok(Admission::Free) => Ok((Caller::default(), None)),
            Ok(Admission::Identified { access }) => {
                let identified = self.gate.identify(request.headers()).await;
                identified.and_then(|caller| {
                    let enter = |access| caller.enter(access, request.uri().path());
                    let flight = access.map(enter).transpose()?;
                    Ok((caller, flight.flatten()))
                })
            }
            Err(refusal) => Err(refusal),
        };
        let (caller, flight) = match admitted {
            Ok(admitted) => admitted,
            Err(refusal) => {
                let mut response = refused(refusal, call.is_grpc);
                if response.status() == StatusCode::UNAUTHORIZED {
                    for challenge in client_token::challenges(request.headers()) {
                        response.headers_mut().append(header::WWW_AUTHENTICATE, challenge);
                    }
                }
                return response;
            }
        };
        let context = Context { caller, ..call.context.clone() };
        let router = if call.is_grpc { self.grpc } else { self.http };
        let mut request = uploads::with_overridden_method(request);
        if let Transport::Tls(Some(peer)) = self.transport {
            request.extensions_mut().insert(peer);
        }
        let answering = AssertUnwindSafe(context.scope(router.oneshot(request))).catch_unwind();
        tokio::select! {
            answered = answering => match answered {
                Ok(Ok(response)) => counted(response, flight),
                Ok(Err(never)) => match never {},
                Err(_) => refused(panicked(), call.is_grpc),
            },
            () = call.passed() => refused(Cut::Deadline.refusal(), call.is_grpc),
        }
    }

    /// Checks what every request has to fulfil, before it is looked at, and says what more it takes.
    fn admission(&self, request: &Request<Body>, is_grpc: bool) -> Result<Admission, Refusal> {
        if matches!(self.transport, Transport::Refused) {
            return Err(without_tls());
        }
        let path = request.uri().path();
        let access = if is_grpc { access::find(path) } else { None };
        // Workers call by any name that they were given, and show their own token.
        if access == Some(Access::Worker) {
            return Ok(Admission::Free);
        }
        self.hosts.check(request)?;
        if access == Some(Access::Open) || !is_grpc && access::is_open(request.method(), path) {
            return Ok(Admission::Free);
        }
        // The router reports a method that does not exist.
        let is_method = is_grpc && (access.is_some() || self.methods.contains(path));
        Ok(Admission::Identified { access: is_method.then_some(access) })
    }
}

/// Condition of an answer.
enum Admission {
    /// Nothing here.
    Free,
    /// A caller that is known, and may do what the entry of the table says. Of HTTP that is checked
    /// by [`authorize`], once the route is known.
    Identified { access: Option<Option<Access>> },
}

/// A response whose call is counted until its end.
fn counted(response: Response<Body>, flight: Option<Flight>) -> Response<Body> {
    let Some(flight) = flight else { return response };
    response.map(|body| {
        Body::new(body.map_frame(move |frame| {
            let _held = &flight;
            frame
        }))
    })
}

/// Refuses what the caller may not do; a layer of the routes of HTTP.
pub(crate) async fn authorize(
    matched: MatchedPath,
    request: axum::extract::Request,
    next: axum::middleware::Next,
) -> Response<Body> {
    let route = access::route_name(request.method(), matched.as_str());
    match Context::current().caller.enter(access::find(&route), &route) {
        Ok(flight) => counted(next.run(request).await, flight),
        Err(refusal) => refusal.into_response(),
    }
}

/// The matched route pattern, passed on with the response.
#[derive(Clone)]
struct Route(String);

/// Records which route answered; a layer of the HTTP router.
pub(crate) async fn note_route(
    matched: Option<MatchedPath>,
    request: axum::extract::Request,
    next: axum::middleware::Next,
) -> Response<Body> {
    let mut response = next.run(request).await;
    if let Some(path) = matched {
        response.extensions_mut().insert(Route(path.as_str().to_owned()));
    }
    response
}

/// The code of a call that failed immediately; others end in trailers, after this.
fn grpc_code(response: &Response<Body>) -> String {
    let code = response.headers().get("grpc-status").and_then(|v| v.to_str().ok());
    code.unwrap_or("0").to_owned()
}

fn refused(refusal: Refusal, is_grpc: bool) -> Response<Body> {
    if is_grpc { tonic::Status::from(refusal).into_http() } else { refusal.into_response() }
}

fn without_tls() -> Refusal {
    let message = "this port is for TLS: use https:// in the address, and name the authority of \
                   the server's certificate if it is a private one (--ca FILE, BENDTWIN_CA)";
    Refusal::http_only(StatusCode::BAD_REQUEST, "TLS_REQUIRED", message)
}

fn panicked() -> Refusal {
    Refusal::new(Fault {
        category: Category::Internal,
        reason: "PANICKED".to_owned(),
        message: "a handler panicked".to_owned(),
    })
}
