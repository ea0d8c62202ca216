//! `/openapi.json` and a page that shows it, without external resources.

use axum::{Router, http::header, response::Html, routing::get};
use bytes::Bytes;
use utoipa::openapi::OpenApi;

use super::describe;
use crate::app::App;

const PAGE: &str = include_str!("docs/page.html");

pub(super) fn router(description: &OpenApi) -> Router<App> {
    let json = Bytes::from(describe::complete(description).to_string());
    let document = move || {
        let json = json.clone();
        async move { ([(header::CONTENT_TYPE, "application/json")], json) }
    };
    Router::new().route("/openapi.json", get(document)).route("/docs", get(|| async { Html(PAGE) }))
}
