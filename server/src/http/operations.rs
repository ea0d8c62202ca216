//! `/healthz`, `/readyz`, `/metrics`: for operators.

use axum::{
    Json,
    extract::State,
    http::{StatusCode, header},
    response::{IntoResponse, Response},
};
use serde::Serialize;

use super::Result;
use crate::{app::App, dispatch::Size, metrics::Gauges, readiness::Check};

/// State of the server as `/readyz` reports it.
#[derive(Serialize)]
pub(super) struct Readiness {
    /// True if all checks are ok.
    ready: bool,
    /// `running`: the server is not stopping; `writes`: a change can be made to last; `disk`: there
    /// is more free space than the floor; `workers`: at least one answers.
    checks: Vec<Check>,
    /// Registered workers.
    workers: usize,
    /// Rollouts under way or waiting.
    rollouts: usize,
    /// Name and version of the server's program.
    build: &'static str,
}

/// Liveness
pub(super) async fn healthz() -> &'static str {
    "ok\n"
}

/// Readiness
pub(super) async fn readyz(State(app): State<App>) -> Response {
    let checks = app.readiness().await;
    let ready = checks.iter().all(|check| check.ok);
    let (workers, rollouts) = app.dispatch.counts();
    let status = if ready { StatusCode::OK } else { StatusCode::SERVICE_UNAVAILABLE };
    let build = bendtwin_core::BUILD;
    (status, Json(Readiness { ready, checks, workers, rollouts, build })).into_response()
}

/// Metrics for Prometheus
pub(super) async fn metrics(State(app): State<App>) -> Result<Response> {
    // Sets the gauges of readiness and of the disk.
    app.readiness().await;
    let depth = app.store.jobs().depth().await?;
    let uploads = app.store.uploads().in_use().await?;
    let (workers, rollouts) = app.dispatch.counts();
    for (size, waiting) in Size::ALL.into_iter().zip(app.dispatch.waiting()) {
        app.metrics.rollouts_waiting(size.as_str(), waiting);
    }
    let gauges = Gauges { workers, rollouts, memory: app.dispatch.memory(), uploads };
    let (used, total) = app.memory.state();
    app.metrics.memory_budget(used, total);
    app.certificates.measure(&app.metrics);
    let text = app.metrics.render(&depth, &gauges);
    Ok(([(header::CONTENT_TYPE, "text/plain; version=0.0.4")], text).into_response())
}
