//! `/healthz`, `/readyz`, `/metrics`: for operators.

use axum::{
    Json,
    extract::State,
    http::{StatusCode, header},
    response::{IntoResponse, Response},
};
use serde::Serialize;
use utoipa::ToSchema;

use super::Result;
use crate::{app::App, dispatch::Size, error::ProblemDocument, metrics::Gauges};

/// State of the server as `/readyz` reports it.
#[derive(Serialize, ToSchema)]
pub(super) struct Readiness {
    /// True if the store answers and the server is not stopping.
    ready: bool,
    /// Connected workers; fits and rollouts wait while there is none.
    workers: usize,
    /// Rollouts under way or waiting.
    rollouts: usize,
}

/// Liveness
#[utoipa::path(get, path = "/healthz", tag = "operations",
    responses((status = 200, body = String, content_type = "text/plain")))]
pub(super) async fn healthz() -> &'static str {
    "ok\n"
}

/// Readiness
#[utoipa::path(get, path = "/readyz", tag = "operations",
    responses((status = 200, body = Readiness), (status = 503, body = Readiness)))]
pub(super) async fn readyz(State(app): State<App>) -> Response {
    let ready = !app.stopping.is_cancelled() && app.store.ping().await.is_ok();
    let (workers, rollouts) = app.dispatch.counts();
    let status = if ready { StatusCode::OK } else { StatusCode::SERVICE_UNAVAILABLE };
    (status, Json(Readiness { ready, workers, rollouts })).into_response()
}

/// Metrics for Prometheus
#[utoipa::path(get, path = "/metrics", tag = "operations",
    responses((status = 200, body = String, content_type = "text/plain"),
        (status = "default", body = ProblemDocument)))]
pub(super) async fn metrics(State(app): State<App>) -> Result<Response> {
    let depth = app.store.jobs().depth().await?;
    let uploads = app.store.uploads().in_use().await?;
    let (workers, rollouts) = app.dispatch.counts();
    for (size, waiting) in Size::ALL.into_iter().zip(app.dispatch.waiting()) {
        app.metrics.rollouts_waiting(size.as_str(), waiting);
    }
    let gauges = Gauges { workers, rollouts, memory: app.dispatch.memory(), uploads };
    let text = app.metrics.render(&depth, &gauges);
    Ok(([(header::CONTENT_TYPE, "text/plain; version=0.0.4")], text).into_response())
}
