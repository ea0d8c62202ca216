//! The service around every request of either transport: request id, tracing span, metrics, and an
//! answer for handlers that panic.

use std::{convert::Infallible, panic::AssertUnwindSafe, time::Instant};

use axum::{
    body::Body,
    extract::MatchedPath,
    http::{HeaderValue, Request, Response, header},
    response::IntoResponse,
};
use bendtwin_core::{Category, Fault};
use futures::FutureExt;
use tower::ServiceExt;
use tracing::Instrument;

use super::{origin, uploads};
use crate::{context::Context, error::Refusal, metrics::Metrics};

/// Both transports behind one service.
#[derive(Clone)]
pub(crate) struct RootService {
    pub(crate) http: axum::Router,
    pub(crate) grpc: axum::Router,
    pub(crate) metrics: Metrics,
    /// True if only this machine can reach the server.
    pub(crate) loopback: bool,
}

impl RootService {
    /// Answers one request.
    pub(crate) async fn answer(self, request: Request<Body>) -> Result<Response<Body>, Infallible> {
        let started = Instant::now();
        let context = Context::of(request.headers(), request.extensions());
        let is_grpc = is_grpc(&request);
        let span = tracing::info_span!(
            "request",
            method = %request.method(),
            path = request.uri().path(),
            request_id = context.request_id,
            trace_parent = context.trace_parent.as_deref().unwrap_or_default(),
        );
        let router = if is_grpc { self.grpc } else { self.http };
        // The pattern that matches, never the path itself: labels of metrics are to be few.
        let grpc_route = is_grpc.then(|| request.uri().path().to_owned());
        let loopback = self.loopback;
        let answered = context.clone().scope(async move {
            if origin::is_foreign(request.headers()) || loopback && origin::is_rebound(&request) {
                return Ok(origin::refusal().into_response());
            }
            let request = uploads::with_overridden_method(request);
            let caught = AssertUnwindSafe(router.oneshot(request)).catch_unwind().await;
            caught.unwrap_or_else(|_| Ok(panicked(is_grpc)))
        });
        let mut response = match answered.instrument(span.clone()).await {
            Ok(response) => response,
            Err(never) => match never {},
        };
        if let Ok(id) = HeaderValue::from_str(&context.request_id) {
            response.headers_mut().insert("x-request-id", id);
        }
        let took = started.elapsed();
        let transport = if is_grpc { "grpc" } else { "http" };
        let code =
            if is_grpc { grpc_code(&response) } else { response.status().as_str().to_owned() };
        let matched = response.extensions().get::<Route>().map(|r| r.0.clone());
        // Methods that do not exist share one label.
        let grpc_route = grpc_route.filter(|_| code != UNIMPLEMENTED);
        let route = grpc_route.or(matched).unwrap_or_else(|| "none".to_owned());
        span.in_scope(|| tracing::debug!(code, took_s = took.as_secs_f64(), "answered"));
        self.metrics.request(transport, &route, &code, took);
        Ok(response)
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

fn is_grpc(request: &Request<Body>) -> bool {
    let content_type = request.headers().get(header::CONTENT_TYPE);
    content_type.is_some_and(|v| v.as_bytes().starts_with(b"application/grpc"))
}

/// The number of the gRPC code.
const UNIMPLEMENTED: &str = "12";

/// The code of a call that failed at once; others end in trailers, after this.
fn grpc_code(response: &Response<Body>) -> String {
    let code = response.headers().get("grpc-status").and_then(|v| v.to_str().ok());
    code.unwrap_or("0").to_owned()
}

fn panicked(is_grpc: bool) -> Response<Body> {
    let refusal = Refusal::new(Fault {
        category: Category::Internal,
        reason: "PANICKED".to_owned(),
        message: "a handler panicked".to_owned(),
    });
    if is_grpc { tonic::Status::from(refusal).into_http() } else { refusal.into_response() }
}
