//! The one table of what each route and each RPC takes. A call that it does not list is refused to
//! everyone; tests compare it with the description of the HTTP API and with the descriptors of gRPC.

use std::{collections::HashMap, sync::LazyLock};

use axum::http::Method;

use super::Scope;

/// Condition of a call.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Access {
    /// Nothing: it tells nothing of what is stored.
    Open,
    /// The client token, or a key with any scope.
    Anyone,
    /// The token of a worker, which the service checks itself.
    Worker,
    /// The client token, or a key with this scope.
    Scope(Scope),
}

use Access::{Anyone, Open, Worker};

const ADMIN: Access = Access::Scope(Scope::Admin);
const CAPTURES_READ: Access = Access::Scope(Scope::CapturesRead);
const CAPTURES_WRITE: Access = Access::Scope(Scope::CapturesWrite);
const FITS_READ: Access = Access::Scope(Scope::FitsRead);
const FITS_WRITE: Access = Access::Scope(Scope::FitsWrite);
const ROLLOUTS_RUN: Access = Access::Scope(Scope::RolloutsRun);
const TWINS_READ: Access = Access::Scope(Scope::TwinsRead);
const TWINS_WRITE: Access = Access::Scope(Scope::TwinsWrite);

/// Condition of each route, `METHOD /path`, and of each RPC, `/package.Service/Method`.
pub const TABLE: &[(&str, Access)] = &[
    ("GET /", Open),
    ("GET /assets/{file}", Open),
    ("GET /docs", Open),
    ("GET /healthz", Open),
    ("GET /openapi.json", Open),
    ("GET /readyz", Open),
    // What is understood of tus, which its clients ask before they show who they are.
    ("OPTIONS /v1/uploads", Open),
    ("GET /metrics", Anyone),
    ("GET /v1/workers", Anyone),
    ("GET /v1/workers/{id}", Anyone),
    ("POST /v1/workers/{id}/drain", ADMIN),
    ("GET /v1/keys", ADMIN),
    ("POST /v1/keys", ADMIN),
    ("GET /v1/keys/{id}", ADMIN),
    ("DELETE /v1/keys/{id}", ADMIN),
    ("GET /v1/captures", CAPTURES_READ),
    ("GET /v1/captures/{id}", CAPTURES_READ),
    ("GET /v1/captures/{id}/content", CAPTURES_READ),
    ("GET /v1/captures/{id}/events", CAPTURES_READ),
    ("GET /v1/captures/{id}/observation", CAPTURES_READ),
    ("GET /v1/captures/{id}/playback", CAPTURES_READ),
    ("GET /v1/captures/{id}/report", CAPTURES_READ),
    ("GET /v1/captures/{id}/report.html", CAPTURES_READ),
    ("POST /v1/captures", CAPTURES_WRITE),
    ("PATCH /v1/captures/{id}", CAPTURES_WRITE),
    ("DELETE /v1/captures/{id}", CAPTURES_WRITE),
    ("POST /v1/captures/{id}/ingest", CAPTURES_WRITE),
    ("POST /v1/captures/{id}/ingest/cancel", CAPTURES_WRITE),
    ("POST /v1/uploads", CAPTURES_WRITE),
    ("GET /v1/uploads", CAPTURES_WRITE),
    ("HEAD /v1/uploads/{id}", CAPTURES_WRITE),
    ("GET /v1/uploads/{id}", CAPTURES_WRITE),
    ("PATCH /v1/uploads/{id}", CAPTURES_WRITE),
    ("DELETE /v1/uploads/{id}", CAPTURES_WRITE),
    ("GET /v1/fits", FITS_READ),
    ("GET /v1/fits/{id}", FITS_READ),
    ("GET /v1/fits/{id}/events", FITS_READ),
    ("GET /v1/fits/{id}/losses", FITS_READ),
    ("POST /v1/fits", FITS_WRITE),
    ("PATCH /v1/fits/{id}", FITS_WRITE),
    ("DELETE /v1/fits/{id}", FITS_WRITE),
    ("POST /v1/fits/{id}/cancel", FITS_WRITE),
    ("GET /v1/twins", TWINS_READ),
    ("GET /v1/twins/{id}", TWINS_READ),
    ("GET /v1/twins/{id}/content", TWINS_READ),
    ("GET /v1/twins/{id}/geometry", TWINS_READ),
    ("POST /v1/twins", TWINS_WRITE),
    ("PATCH /v1/twins/{id}", TWINS_WRITE),
    ("DELETE /v1/twins/{id}", TWINS_WRITE),
    ("POST /v1/twins/{id}/rollouts", ROLLOUTS_RUN),
    ("POST /v1/twins/{id}/rollouts/stream", ROLLOUTS_RUN),
    ("POST /v1/twins/{id}/register", ROLLOUTS_RUN),
    ("POST /v1/twins/{id}/evaluations", ROLLOUTS_RUN),
    ("POST /v1/plans", ROLLOUTS_RUN),
    ("POST /v1/sessions", ROLLOUTS_RUN),
    ("GET /v1/sessions/{id}", ROLLOUTS_RUN),
    ("DELETE /v1/sessions/{id}", ROLLOUTS_RUN),
    ("GET /v1/sessions/{id}/states", ROLLOUTS_RUN),
    ("POST /v1/sessions/{id}/advance", ROLLOUTS_RUN),
    ("POST /v1/sessions/{id}/correct", ROLLOUTS_RUN),
    ("POST /v1/sessions/{id}/fork", ROLLOUTS_RUN),
    ("POST /v1/sessions/{id}/reset", ROLLOUTS_RUN),
    ("POST /v1/sessions/{id}/step", ROLLOUTS_RUN),
    ("GET /v1/twins/{id}/play", ROLLOUTS_RUN),
    ("GET /v1/plays/{id}/watch", ROLLOUTS_RUN),
    ("GET /v1/plays/{id}/recording", ROLLOUTS_RUN),
    ("PUT /v1/plays/{id}/recording", ROLLOUTS_RUN),
    ("/grpc.health.v1.Health/Check", Open),
    ("/grpc.health.v1.Health/Watch", Open),
    ("/grpc.reflection.v1.ServerReflection/ServerReflectionInfo", Anyone),
    ("/grpc.reflection.v1alpha.ServerReflection/ServerReflectionInfo", Anyone),
    ("/bendtwin.v1.WorkerService/GetWorker", Anyone),
    ("/bendtwin.v1.WorkerService/ListWorkers", Anyone),
    ("/bendtwin.v1.WorkerService/DrainWorker", ADMIN),
    ("/bendtwin.v1.KeyService/CreateKey", ADMIN),
    ("/bendtwin.v1.KeyService/GetKey", ADMIN),
    ("/bendtwin.v1.KeyService/ListKeys", ADMIN),
    ("/bendtwin.v1.KeyService/DeleteKey", ADMIN),
    ("/bendtwin.v1.CaptureService/GetCapture", CAPTURES_READ),
    ("/bendtwin.v1.CaptureService/ListCaptures", CAPTURES_READ),
    ("/bendtwin.v1.CaptureService/WatchIngest", CAPTURES_READ),
    ("/bendtwin.v1.CaptureService/GetCaptureReport", CAPTURES_READ),
    ("/bendtwin.v1.CaptureService/ExportObservation", CAPTURES_READ),
    ("/bendtwin.v1.CaptureService/CreateCapture", CAPTURES_WRITE),
    ("/bendtwin.v1.CaptureService/UpdateCapture", CAPTURES_WRITE),
    ("/bendtwin.v1.CaptureService/DeleteCapture", CAPTURES_WRITE),
    ("/bendtwin.v1.CaptureService/IngestCapture", CAPTURES_WRITE),
    ("/bendtwin.v1.CaptureService/CancelIngest", CAPTURES_WRITE),
    ("/bendtwin.v1.FitService/GetFit", FITS_READ),
    ("/bendtwin.v1.FitService/ListFits", FITS_READ),
    ("/bendtwin.v1.FitService/GetFitLosses", FITS_READ),
    ("/bendtwin.v1.FitService/WatchFit", FITS_READ),
    ("/bendtwin.v1.FitService/CreateFit", FITS_WRITE),
    ("/bendtwin.v1.FitService/UpdateFit", FITS_WRITE),
    ("/bendtwin.v1.FitService/CancelFit", FITS_WRITE),
    ("/bendtwin.v1.FitService/DeleteFit", FITS_WRITE),
    ("/bendtwin.v1.TwinService/GetTwin", TWINS_READ),
    ("/bendtwin.v1.TwinService/ListTwins", TWINS_READ),
    ("/bendtwin.v1.TwinService/ExportTwin", TWINS_READ),
    ("/bendtwin.v1.TwinService/GetTwinGeometry", TWINS_READ),
    ("/bendtwin.v1.TwinService/CreateTwin", TWINS_WRITE),
    ("/bendtwin.v1.TwinService/UpdateTwin", TWINS_WRITE),
    ("/bendtwin.v1.TwinService/DeleteTwin", TWINS_WRITE),
    ("/bendtwin.v1.RolloutService/RollOut", ROLLOUTS_RUN),
    ("/bendtwin.v1.RolloutService/StreamRollOut", ROLLOUTS_RUN),
    ("/bendtwin.v1.PlanningService/Plan", ROLLOUTS_RUN),
    ("/bendtwin.v1.RegistrationService/RegisterState", ROLLOUTS_RUN),
    ("/bendtwin.v1.EvaluationService/EvaluateTwin", ROLLOUTS_RUN),
    ("/bendtwin.v1.SessionService/OpenSession", ROLLOUTS_RUN),
    ("/bendtwin.v1.SessionService/GetSession", ROLLOUTS_RUN),
    ("/bendtwin.v1.SessionService/GetSessionStates", ROLLOUTS_RUN),
    ("/bendtwin.v1.SessionService/AdvanceSession", ROLLOUTS_RUN),
    ("/bendtwin.v1.SessionService/ControlSession", ROLLOUTS_RUN),
    ("/bendtwin.v1.SessionService/ForkSession", ROLLOUTS_RUN),
    ("/bendtwin.v1.SessionService/ResetSession", ROLLOUTS_RUN),
    ("/bendtwin.v1.SessionService/CorrectSession", ROLLOUTS_RUN),
    ("/bendtwin.v1.SessionService/StepSession", ROLLOUTS_RUN),
    ("/bendtwin.v1.SessionService/CloseSession", ROLLOUTS_RUN),
    ("/bendtwin.worker.v1.WorkerLink/Register", Worker),
    ("/bendtwin.worker.v1.WorkerLink/Heartbeat", Worker),
    ("/bendtwin.worker.v1.WorkerLink/LeaseJob", Worker),
    ("/bendtwin.worker.v1.WorkerLink/ReportJob", Worker),
    ("/bendtwin.worker.v1.WorkerLink/SaveCheckpoint", Worker),
    ("/bendtwin.worker.v1.WorkerLink/CompleteFit", Worker),
    ("/bendtwin.worker.v1.WorkerLink/EndIngest", Worker),
    ("/bendtwin.worker.v1.WorkerLink/FailJob", Worker),
    ("/bendtwin.worker.v1.WorkerLink/Download", Worker),
    ("/bendtwin.worker.v1.WorkerLink/Leave", Worker),
];

/// The table by name.
static BY_NAME: LazyLock<HashMap<&str, Access>> = LazyLock::new(|| TABLE.iter().copied().collect());

/// Condition of a route or an RPC; none if it is not listed.
pub(crate) fn find(name: &str) -> Option<Access> {
    BY_NAME.get(name).copied()
}

/// The name of a route in the table. `HEAD` of a route that has none of its own is its `GET`.
pub(crate) fn route_name(method: &Method, pattern: &str) -> String {
    let name = format!("{method} {pattern}");
    match *method {
        Method::HEAD if find(&name).is_none() => format!("{} {pattern}", Method::GET),
        _ => name,
    }
}

/// True if a request takes nothing: its route is open, or, for a method that a path does not have, all
/// routes of the path are.
pub(crate) fn is_open(method: &Method, path: &str) -> bool {
    let routes = TABLE.iter().filter_map(|(name, access)| Some((name.split_once(' ')?, *access)));
    let here = routes.filter(|((_, pattern), _)| is_at(pattern, path));
    let (mut any, mut all) = (false, true);
    for ((own, _), access) in here {
        if own == method.as_str() {
            return access == Open;
        }
        (any, all) = (true, all && access == Open);
    }
    any && all
}

/// True if a path is this pattern, or below one whose last part is a parameter.
fn is_at(pattern: &str, path: &str) -> bool {
    match pattern.rsplit_once('/') {
        Some((folder, last)) if last.starts_with('{') => {
            path.strip_prefix(folder).is_some_and(|rest| rest.starts_with('/'))
        }
        _ => pattern == path,
    }
}

#[cfg(test)]
mod tests;
