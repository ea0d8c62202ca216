//! The HTTP form of the API: JSON resources, raw content, server-sent events, a document that
//! describes all of it, and the console that uses it. No decisions are made here.

mod captures;
mod console;
mod docs;
mod download;
mod evaluations;
mod extract;
mod fits;
mod gateway;
mod guide;
mod message;
mod operations;
pub(crate) mod origin;
mod plans;
mod plays;
mod registrations;
mod rollouts;
pub(crate) mod root_service;
mod sessions;
mod twins;
pub(crate) mod uploads;

use axum::{handler::Handler, http::StatusCode, routing, routing::MethodFilter};

use crate::{app::App, refusal::Refusal};

/// Result of a handler.
type Result<T, E = Refusal> = std::result::Result<T, E>;

/// All routes, and the fallbacks for unknown ones. The services of gRPC answer those of plain
/// messages.
pub(crate) fn router(app: &App, grpc: &axum::Router) -> axum::Router {
    let router = gateway::router(grpc)
        .merge(by_hand().router)
        .merge(docs::router())
        .merge(console::router())
        .merge(guide::router())
        .route_layer(axum::middleware::from_fn(root_service::authorize))
        .route_layer(axum::middleware::from_fn(root_service::note_route));
    with_fallbacks(router).with_state(app.clone())
}

/// The routes of the workers' listener, for operators.
pub(crate) fn operations_router(app: &App) -> axum::Router {
    let router = for_operators()
        .router
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

/// Routes with separate handlers, and the name of each, `METHOD /path`, which a test compares with
/// the contract.
#[derive(Default)]
pub(crate) struct Routes {
    router: axum::Router<App>,
    pub(crate) names: Vec<String>,
}

impl Routes {
    fn on<H, T>(mut self, method: &str, path: &str, handler: H) -> Self
    where
        H: Handler<T, App>,
        T: 'static,
    {
        self.names.push(format!("{method} {path}"));
        let router = self.router.route(path, routing::on(method_filter(method), handler));
        Self { router, ..self }
    }

    fn merge(mut self, others: Self) -> Self {
        self.names.extend(others.names);
        Self { router: self.router.merge(others.router), ..self }
    }
}

fn method_filter(method: &str) -> MethodFilter {
    match method {
        "GET" => MethodFilter::GET,
        "HEAD" => MethodFilter::HEAD,
        "POST" => MethodFilter::POST,
        "PUT" => MethodFilter::PUT,
        "PATCH" => MethodFilter::PATCH,
        "DELETE" => MethodFilter::DELETE,
        _ => MethodFilter::OPTIONS,
    }
}

/// Bytes, events, plays, and messages with tensors, whose memory is counted.
pub(crate) fn by_hand() -> Routes {
    for_operators()
        .merge(uploads::routes())
        .on("POST", "/v1/captures", captures::create)
        .on("GET", "/v1/captures/{id}/content", captures::content)
        .on("GET", "/v1/captures/{id}/report", captures::report)
        .on("GET", "/v1/captures/{id}/report.html", captures::report_page)
        .on("GET", "/v1/captures/{id}/observation", captures::observation)
        .on("GET", "/v1/captures/{id}/playback", captures::playback)
        .on("GET", "/v1/captures/{id}/masks", captures::masks)
        .on("PUT", "/v1/captures/{id}/supplements/{kind}", captures::add_supplement)
        .on("GET", "/v1/captures/{id}/supplements/{kind}", captures::supplement)
        .on("DELETE", "/v1/captures/{id}/supplements/{kind}", captures::delete_supplement)
        .on("GET", "/v1/captures/{id}/events", fits::events::watch_ingest)
        .on("GET", "/v1/fits/{id}/events", fits::events::watch)
        .on("GET", "/v1/fits/{id}/preview", fits::preview)
        .on("POST", "/v1/twins", twins::create)
        .on("GET", "/v1/twins/{id}/content", twins::content)
        .on("GET", "/v1/twins/{id}/geometry", twins::geometry)
        .on("GET", "/v1/twins/{id}/surface", twins::surface)
        .on("GET", "/v1/twins/{id}/export", twins::export)
        .on("GET", "/v1/twins/{id}/thumbnail", download::thumbnails::twin)
        .on("GET", "/v1/captures/{id}/thumbnail", download::thumbnails::capture)
        .on("POST", "/v1/twins/{id}/rollouts", rollouts::create)
        .on("POST", "/v1/twins/{id}/rollouts/stream", rollouts::stream::stream)
        .on("POST", "/v1/twins/{id}/register", registrations::register)
        .on("POST", "/v1/twins/{id}/evaluations", evaluations::create)
        .on("POST", "/v1/plans", plans::create)
        .on("POST", "/v1/sessions", sessions::open)
        .on("GET", "/v1/sessions/{id}/states", sessions::states)
        .on("POST", "/v1/sessions/{id}/advance", sessions::advance)
        .on("POST", "/v1/sessions/{id}/correct", sessions::correct)
        .on("POST", "/v1/sessions/{id}/fork", sessions::fork)
        .on("POST", "/v1/sessions/{id}/render", sessions::render)
        .on("POST", "/v1/sessions/{id}/reset", sessions::reset)
        .on("POST", "/v1/sessions/{id}/step", sessions::step)
        .on("GET", "/v1/twins/{id}/play", plays::play)
        .on("GET", "/v1/plays/{id}/watch", plays::watch)
        .on("GET", "/v1/plays/{id}/recording", plays::recording)
        .on("PUT", "/v1/plays/{id}/recording", plays::put_recording)
}

fn for_operators() -> Routes {
    Routes::default()
        .on("GET", "/healthz", operations::healthz)
        .on("GET", "/readyz", operations::readyz)
        .on("GET", "/metrics", operations::metrics)
}
