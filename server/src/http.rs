//! The HTTP form of the API: JSON resources, raw content, server-sent events,
//! and a document that describes all of it. No decisions are made here.

mod captures;
mod describe;
mod docs;
mod events;
mod extract;
mod fits;
mod operations;
pub(crate) mod origin;
mod resource;
mod rollouts;
pub(crate) mod root_service;
mod twins;
pub(crate) mod uploads;
mod workers;

use axum::{
    body::Body,
    http::{HeaderName, StatusCode, header},
    response::{IntoResponse, Response},
};
use base64::{Engine as _, prelude::BASE64_STANDARD};
use bendtwin_store::Content;
use futures::TryStreamExt;
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
    let router = router.route_layer(axum::middleware::from_fn(root_service::note_route));
    with_fallbacks(router).with_state(app.clone())
}

fn with_fallbacks(router: axum::Router<App>) -> axum::Router<App> {
    router
        .fallback(|| async {
            let message = "there is nothing at this path: see /docs for what there is";
            Refusal::http_only(StatusCode::NOT_FOUND, "NO_SUCH_ROUTE", message)
        })
        .method_not_allowed_fallback(|| async {
            let message = "this path does not have that method: see /docs for what it has";
            Refusal::http_only(StatusCode::METHOD_NOT_ALLOWED, "METHOD_NOT_ALLOWED", message)
        })
}

fn described() -> OpenApiRouter<App> {
    OpenApiRouter::with_openapi(Description::openapi())
        .routes(routes!(captures::list, captures::create))
        .routes(routes!(captures::get, captures::delete))
        .routes(routes!(captures::content))
        .routes(routes!(captures::ingest))
        .routes(routes!(captures::cancel_ingest))
        .routes(routes!(captures::report))
        .routes(routes!(captures::report_page))
        .routes(routes!(captures::observation))
        .routes(routes!(events::watch_ingest))
        .merge(uploads::routes())
        .routes(routes!(fits::list, fits::create))
        .routes(routes!(fits::get, fits::delete))
        .routes(routes!(fits::cancel))
        .routes(routes!(events::watch))
        .routes(routes!(twins::list, twins::create))
        .routes(routes!(twins::get, twins::delete))
        .routes(routes!(twins::content))
        .routes(routes!(rollouts::create))
        .routes(routes!(workers::list))
        .routes(routes!(workers::get))
        .routes(routes!(operations::healthz))
        .routes(routes!(operations::readyz))
        .routes(routes!(operations::metrics))
}

/// Content as a download.
fn download(content: Content, media_type: &'static str, file_name: &str) -> Response {
    let disposition =
        [(header::CONTENT_DISPOSITION, format!("attachment; filename=\"{file_name}\""))];
    (disposition, inline(content, media_type)).into_response()
}

/// Content to be shown. Browsers must not guess another type than the given one.
fn inline(content: Content, media_type: &'static str) -> Response {
    // RFC 9530, with an algorithm that its registry lacks; uploads declare theirs in the same form.
    let digest = format!("blake3=:{}:", BASE64_STANDARD.encode(content.digest.as_bytes()));
    let headers = [
        (header::CONTENT_TYPE, media_type.to_owned()),
        (header::CONTENT_LENGTH, content.size_bytes.to_string()),
        (header::X_CONTENT_TYPE_OPTIONS, "nosniff".to_owned()),
        (header::ETAG, format!("\"{}\"", content.digest.to_hex())),
        (HeaderName::from_static("content-digest"), digest.clone()),
        (HeaderName::from_static("repr-digest"), digest),
    ];
    // A read that fails in mid-stream cuts the body short of its length.
    let chunks = content.chunks.inspect_err(|error| tracing::error!(%error, "download broke off"));
    (headers, Body::from_stream(chunks)).into_response()
}
