//! The HTTP form of the API: JSON resources, raw content, server-sent events, a document that
//! describes all of it, and the console that uses it. No decisions are made here.

mod captures;
mod console;
mod describe;
mod docs;
mod download;
mod evaluations;
mod events;
mod extract;
mod fits;
mod keys;
mod labels;
mod message;
mod operations;
pub(crate) mod origin;
mod plans;
mod plays;
mod registrations;
mod resource;
mod rollouts;
pub(crate) mod root_service;
mod sessions;
mod twins;
pub(crate) mod uploads;
mod workers;

use axum::http::StatusCode;
use utoipa::OpenApi;
use utoipa_axum::{router::OpenApiRouter, routes};

use crate::{app::App, error::Refusal};

/// Result of a handler.
type Result<T, E = Refusal> = std::result::Result<T, E>;

#[derive(OpenApi)]
#[openapi(
    info(
        title = "BendTwin",
        description = "Captures in, twins out, rollouts served. The same API over gRPC is \
                       bendtwin.v1, on the same port."
    ),
    tags(
        (name = "captures", description = "Recordings of soft objects"),
        (name = "uploads", description = "Resumable uploads of captures: tus 1.0.0"),
        (name = "fits", description = "Fit jobs: capture in, twin out"),
        (name = "twins", description = "Fitted twins"),
        (name = "rollouts", description = "Predictions"),
        (name = "plans", description = "Actions that lower the costs of a rollout"),
        (name = "plays", description = "Simulations in real time that a person moves"),
        (name = "sessions", description = "Simulations that stay between calls"),
        (name = "keys", description = "Keys of clients: scope `admin`"),
        (name = "workers", description = "Worker processes"),
        (name = "operations", description = "Health and metrics"),
    )
)]
struct Description;

/// All routes, and the fallbacks for what is none.
pub(crate) fn router(app: &App) -> axum::Router {
    let (router, description) = described().split_for_parts();
    let router = router
        .merge(docs::router(&description))
        .merge(console::router())
        .route_layer(axum::middleware::from_fn(root_service::authorize))
        .route_layer(axum::middleware::from_fn(root_service::note_route));
    with_fallbacks(router).with_state(app.clone())
}

/// The routes of the workers' listener, for operators.
pub(crate) fn operations_router(app: &App) -> axum::Router {
    let (router, _) = OpenApiRouter::new()
        .routes(routes!(operations::healthz))
        .routes(routes!(operations::readyz))
        .routes(routes!(operations::metrics))
        .split_for_parts();
    let router = router
        .route_layer(axum::middleware::from_fn(root_service::authorize))
        .route_layer(axum::middleware::from_fn(root_service::note_route));
    with_fallbacks(router).with_state(app.clone())
}

fn with_fallbacks(router: axum::Router<App>) -> axum::Router<App> {
    router.fallback(|| async { no_such_route() }).method_not_allowed_fallback(|| async {
        let message = "this path does not have that method: see /docs for what it has";
        Refusal::http_only(StatusCode::METHOD_NOT_ALLOWED, "METHOD_NOT_ALLOWED", message)
    })
}

fn no_such_route() -> Refusal {
    let message = "there is nothing at this path: see /docs for what there is";
    Refusal::http_only(StatusCode::NOT_FOUND, "NO_SUCH_ROUTE", message)
}

pub(crate) fn described() -> OpenApiRouter<App> {
    OpenApiRouter::with_openapi(Description::openapi())
        .routes(routes!(captures::list, captures::create))
        .routes(routes!(captures::get, captures::update, captures::delete))
        .routes(routes!(captures::content))
        .routes(routes!(captures::ingest))
        .routes(routes!(captures::cancel_ingest))
        .routes(routes!(captures::report))
        .routes(routes!(captures::report_page))
        .routes(routes!(captures::observation))
        .routes(routes!(captures::playback))
        .routes(routes!(events::watch_ingest))
        .merge(uploads::routes())
        .routes(routes!(fits::list, fits::create))
        .routes(routes!(fits::get, fits::update, fits::delete))
        .routes(routes!(fits::losses))
        .routes(routes!(fits::cancel))
        .routes(routes!(events::watch))
        .routes(routes!(twins::list, twins::create))
        .routes(routes!(twins::get, twins::update, twins::delete))
        .routes(routes!(twins::content))
        .routes(routes!(twins::geometry))
        .routes(routes!(rollouts::create))
        .routes(routes!(rollouts::stream::stream))
        .routes(routes!(plans::create))
        .routes(routes!(registrations::register))
        .routes(routes!(evaluations::create))
        .routes(routes!(sessions::open))
        .routes(routes!(sessions::get, sessions::close))
        .routes(routes!(sessions::states))
        .routes(routes!(sessions::advance))
        .routes(routes!(sessions::correct))
        .routes(routes!(sessions::fork))
        .routes(routes!(sessions::reset))
        .routes(routes!(sessions::step))
        .routes(routes!(plays::play))
        .routes(routes!(plays::watch))
        .routes(routes!(plays::recording, plays::put_recording))
        .routes(routes!(keys::list, keys::create))
        .routes(routes!(keys::get, keys::revoke))
        .routes(routes!(workers::list))
        .routes(routes!(workers::get))
        .routes(routes!(workers::drain))
        .routes(routes!(operations::healthz))
        .routes(routes!(operations::readyz))
        .routes(routes!(operations::metrics))
}
