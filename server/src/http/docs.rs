//! `/openapi.json` and a page that shows it, without external resources.

use axum::{Router, http::header, response::Html, routing::get};
use bendtwin_proto::OPENAPI;

use crate::app::App;

const PAGE: &str = include_str!("docs/page.html");

pub(super) fn router() -> Router<App> {
    let document = || async { ([(header::CONTENT_TYPE, "application/json")], OPENAPI) };
    Router::new().route("/openapi.json", get(document)).route("/docs", get(|| async { Html(PAGE) }))
}
