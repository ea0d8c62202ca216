//! The service around every request of either transport: request id, tracing span, metrics, and an
//! answer for handlers that panic.

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
use futures::FutureExt;
use tower::ServiceExt;
use tracing::Instrument;

use super::{console, origin::Hosts, uploads};
use crate::{
    client_token::{self, ClientToken},
    deadline::{Call, Cut},
    error::Refusal,
    metrics::Metrics,
};

/// Paths that need no token: they tell nothing of what is stored.
const OPEN_PATHS: [&str; 4] = ["/healthz", "/readyz", "/docs", "/openapi.json"];
/// The service that needs no token, for the same reason.
const OPEN_SERVICE: &str = "/grpc.health.v1.Health/";
/// The service with a token of its own, which no page and no client has.
const WORKER_LINK: &str = "/bendtwin.worker.v1.WorkerLink/";

/// Both transports behind one service.
#[derive(Clone)]
pub(crate) struct RootService {
    pub(crate) http: axum::Router,
    pub(crate) grpc: axum::Router,
    pub(crate) metrics: Metrics,
    /// Paths of all gRPC methods that there are.
    pub(crate) methods: Arc<HashSet<String>>,
    pub(crate) hosts: Hosts,
    /// None if everyone may call.
    pub(crate) token: Option<ClientToken>,
}

impl RootService {
    /// Answers one request.
    pub(crate) async fn answer(
        self,
        request: Request<Body>,
        call: &Call,
    ) -> Result<Response<Body>, Infallible> {
        let started = Instant::now();
        let Call { context, is_grpc, .. } = call;
        let is_grpc = *is_grpc;
        let span = tracing::info_span!(
            "request",
            method = %request.method(),
            path = request.uri().path(),
            request_id = context.request_id,
            trace_parent = context.trace_parent.as_deref().unwrap_or_default(),
        );
        // The pattern or the method that matches, never any path: labels of metrics are to be few.
        let method = is_grpc.then(|| self.methods.get(request.uri().path()).cloned()).flatten();
        let metrics = self.metrics.clone();
        let answered = context.clone().scope(self.admit_and_answer(request, call));
        let mut response = answered.instrument(span.clone()).await;
        if let Ok(id) = HeaderValue::from_str(&context.request_id) {
            response.headers_mut().insert("x-request-id", id);
        }
        let took = started.elapsed();
        let transport = if is_grpc { "grpc" } else { "http" };
        let code =
            if is_grpc { grpc_code(&response) } else { response.status().as_str().to_owned() };
        let matched = response.extensions().get::<Route>().map(|r| r.0.clone());
        let route = method.or(matched).unwrap_or_else(|| "none".to_owned());
        span.in_scope(|| tracing::debug!(code, took_s = took.as_secs_f64(), "answered"));
        metrics.request(transport, &route, &code, took);
        Ok(response)
    }

    async fn admit_and_answer(self, request: Request<Body>, call: &Call) -> Response<Body> {
        if let Err(refusal) = self.admit(&request, call.is_grpc) {
            let mut response = refused(refusal, call.is_grpc);
            if response.status() == StatusCode::UNAUTHORIZED {
                for challenge in client_token::challenges(request.headers()) {
                    response.headers_mut().append(header::WWW_AUTHENTICATE, challenge);
                }
            }
            return response;
        }
        let router = if call.is_grpc { self.grpc } else { self.http };
        let request = uploads::with_overridden_method(request);
        let answering = AssertUnwindSafe(router.oneshot(request)).catch_unwind();
        tokio::select! {
            answered = answering => match answered {
                Ok(Ok(response)) => response,
                Ok(Err(never)) => match never {},
                Err(_) => refused(panicked(), call.is_grpc),
            },
            () = call.passed() => refused(Cut::Deadline.refusal(), call.is_grpc),
        }
    }

    /// Checks what every request has to fulfil, before it is looked at.
    fn admit(&self, request: &Request<Body>, is_grpc: bool) -> Result<(), Refusal> {
        let path = request.uri().path();
        if is_grpc && path.starts_with(WORKER_LINK) {
            return Ok(());
        }
        self.hosts.check(request)?;
        let is_open = if is_grpc {
            path.starts_with(OPEN_SERVICE)
        } else {
            OPEN_PATHS.contains(&path) || console::is_open(path)
        };
        match &self.token {
            Some(token) if !is_open => token.check(request.headers()),
            _ => Ok(()),
        }
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

/// The code of a call that failed at once; others end in trailers, after this.
fn grpc_code(response: &Response<Body>) -> String {
    let code = response.headers().get("grpc-status").and_then(|v| v.to_str().ok());
    code.unwrap_or("0").to_owned()
}

fn refused(refusal: Refusal, is_grpc: bool) -> Response<Body> {
    if is_grpc { tonic::Status::from(refusal).into_http() } else { refusal.into_response() }
}

fn panicked() -> Refusal {
    Refusal::new(Fault {
        category: Category::Internal,
        reason: "PANICKED".to_owned(),
        message: "a handler panicked".to_owned(),
    })
}
