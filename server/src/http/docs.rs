//! `/openapi.json` and a page that shows it, without external resources.

use axum::{
    Router,
    http::{StatusCode, header},
    response::{Html, IntoResponse, Response},
    routing::get,
};
use bendtwin_proto::OPENAPI;

use crate::app::App;

const PAGE: &str = include_str!("docs/page.html");
/// Mark in the page that is replaced for each response.
const NONCE: &str = "NONCE";

pub(super) fn router() -> Router<App> {
    let document = || async { ([(header::CONTENT_TYPE, "application/json")], OPENAPI) };
    Router::new().route("/openapi.json", get(document)).route("/docs", get(page))
}

/// The page, of which only the parts that are its own run: they have a word that no one can guess.
async fn page() -> Response {
    let nonce = uuid::Uuid::new_v4().simple().to_string();
    let policy = format!(
        "default-src 'none'; connect-src 'self'; script-src 'nonce-{nonce}'; \
         style-src 'nonce-{nonce}'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
    );
    let headers = [
        (header::CONTENT_SECURITY_POLICY, policy.as_str()),
        (header::REFERRER_POLICY, "no-referrer"),
        (header::CACHE_CONTROL, "no-store"),
    ];
    (StatusCode::OK, headers, Html(PAGE.replace(NONCE, &nonce))).into_response()
}
