//! `/healthz`, `/readyz`, `/metrics`: for operators.

use axum::{
    Json,
    extract::State,
    http::{StatusCode, header},
    response::{IntoResponse, Response},
};
use serde::{Deserialize, Serialize};

use super::{Result, extract::Params};
use crate::app::{App, Check};

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

/// The query of `/readyz`.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ReadinessQuery {
    /// Names of checks to leave out, with commas between them.
    #[serde(default)]
    without: String,
}

/// Liveness
pub(super) async fn healthz() -> &'static str {
    "ok\n"
}

/// Readiness
pub(super) async fn readyz(
    State(app): State<App>,
    Params(ReadinessQuery { without }): Params<ReadinessQuery>,
) -> Result<Response> {
    let without: Vec<&str> = without.split(',').filter(|name| !name.is_empty()).collect();
    let checks = app.readiness_without(&without).await?;
    let ready = checks.iter().all(|check| check.ok);
    let (workers, rollouts) = app.counts();
    let status = if ready { StatusCode::OK } else { StatusCode::SERVICE_UNAVAILABLE };
    let build = bendtwin_core::BUILD;
    Ok((status, Json(Readiness { ready, checks, workers, rollouts, build })).into_response())
}

/// Metrics for Prometheus
pub(super) async fn metrics(State(app): State<App>) -> Response {
    let text = app.metrics_text().await;
    ([(header::CONTENT_TYPE, "text/plain; version=0.0.4")], text).into_response()
}
