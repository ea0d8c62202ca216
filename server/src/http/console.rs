//! `/` and `/assets/…`: the console, a page that is compiled in. Its files are built from `console/`
//! and committed compressed in `console/built`, so building the server takes no other tools.

use std::{
    collections::HashMap,
    io::{self, Read as _},
    sync::{LazyLock, OnceLock},
};

use axum::{
    Router,
    extract::Request,
    http::{HeaderMap, HeaderName, StatusCode, header},
    response::{IntoResponse, Redirect, Response},
    routing::get,
};
use bytes::Bytes;
use flate2::read::GzDecoder;

use super::no_such_route;
use crate::{access::PAGES, app::App};

/// Address, media type and compressed content of each file.
const FILES: &[(&str, &str, &[u8])] = include!("../../embedded/console/files.rs");
/// Files by address.
static ASSETS: LazyLock<HashMap<&str, Asset>> = LazyLock::new(|| {
    FILES.iter().map(|(path, ..)| *path).zip(FILES.iter().map(Asset::new)).collect()
});

/// Sources that the page may load from and connect to: this server alone. Nothing inline runs, and
/// text does not become markup (trusted types).
const POLICY: &str = "default-src 'self'; connect-src 'self'; img-src 'self' data: blob:; \
                      media-src 'self' blob:; frame-src 'none'; object-src 'none'; \
                      base-uri 'none'; form-action 'none'; frame-ancestors 'none'; \
                      require-trusted-types-for 'script'; trusted-types 'none'";
/// Headers of every file.
const HEADERS: [(HeaderName, &str); 7] = [
    (header::CONTENT_SECURITY_POLICY, POLICY),
    (header::X_CONTENT_TYPE_OPTIONS, "nosniff"),
    (header::REFERRER_POLICY, "no-referrer"),
    (HeaderName::from_static("cross-origin-opener-policy"), "same-origin"),
    (HeaderName::from_static("cross-origin-resource-policy"), "same-origin"),
    (HeaderName::from_static("permissions-policy"), "camera=(), geolocation=(), microphone=()"),
    (header::VARY, "accept-encoding"),
];

pub(super) fn router() -> Router<App> {
    Router::new()
        .route("/", get(file))
        // The page to which an identity provider sends a browser back.
        .route("/sign-in", get(page))
        .route("/assets/{file}", get(file))
        .merge(pages())
}

/// Addresses of pages as people type them, without the `#`.
fn pages() -> Router<App> {
    PAGES.iter().fold(Router::new(), |router, page| {
        let below = format!("{page}/{{*rest}}");
        router.route(page, get(to_page)).route(&below, get(to_page))
    })
}

/// Leads to the page behind the `#`.
async fn to_page(request: Request) -> Redirect {
    let wanted = request.uri().path_and_query().map_or("/", |path| path.as_str());
    Redirect::to(&format!("/#{wanted}"))
}

async fn file(request: Request) -> Response {
    match ASSETS.get(request.uri().path()) {
        Some(asset) => asset.answer(request.uri().path(), request.headers()),
        None => no_such_route().into_response(),
    }
}

async fn page(request: Request) -> Response {
    match ASSETS.get("/") {
        Some(asset) => asset.answer("/", request.headers()),
        None => no_such_route().into_response(),
    }
}

/// A file of the console.
struct Asset {
    media_type: &'static str,
    compressed: &'static [u8],
    /// BLAKE3 of the compressed content, hex.
    digest: String,
    /// The uncompressed content, for clients that take no gzip; made when the first one asks.
    plain: OnceLock<Bytes>,
}

impl Asset {
    fn new((_, media_type, compressed): &(&str, &'static str, &'static [u8])) -> Self {
        let digest = blake3::hash(compressed).to_hex().to_string();
        Self { media_type, compressed, digest, plain: OnceLock::new() }
    }

    fn answer(&self, path: &str, request: &HeaderMap) -> Response {
        let is_compressed = takes_gzip(request);
        let coding = if is_compressed { "gzip" } else { "identity" };
        let tag = format!("\"{}-{coding}\"", self.digest);
        // Names of assets have a hash of their content.
        let caching = if path == "/" { "no-cache" } else { "public, max-age=31536000, immutable" };
        let headers =
            (HEADERS, [(header::ETAG, tag.clone()), (header::CACHE_CONTROL, caching.to_owned())]);
        if is_known(request, &tag) {
            return (StatusCode::NOT_MODIFIED, headers).into_response();
        }
        let body =
            if is_compressed { Ok(Bytes::from_static(self.compressed)) } else { self.plain() };
        let Ok(body) = body else {
            tracing::error!(path, "the console is damaged");
            return StatusCode::INTERNAL_SERVER_ERROR.into_response();
        };
        let encoding = is_compressed.then_some([(header::CONTENT_ENCODING, "gzip")]);
        (headers, [(header::CONTENT_TYPE, self.media_type)], encoding, body).into_response()
    }

    fn plain(&self) -> io::Result<Bytes> {
        if let Some(plain) = self.plain.get() {
            return Ok(plain.clone());
        }
        let mut plain = Vec::new();
        GzDecoder::new(self.compressed).read_to_end(&mut plain)?;
        Ok(self.plain.get_or_init(|| plain.into()).clone())
    }
}

/// True if the client says that it takes gzip.
fn takes_gzip(request: &HeaderMap) -> bool {
    let values = request.get_all(header::ACCEPT_ENCODING).iter().filter_map(|v| v.to_str().ok());
    values.flat_map(|value| value.split(',')).any(|coding| {
        let mut parts = coding.split(';').map(str::trim);
        let is_gzip = parts.next().is_some_and(|name| name.eq_ignore_ascii_case("gzip"));
        let weight = parts.find_map(|part| part.strip_prefix("q="));
        is_gzip && weight.is_none_or(|q| q.parse::<f32>().is_ok_and(|q| q > 0.0))
    })
}

/// True if the client has the content with this tag.
fn is_known(request: &HeaderMap, tag: &str) -> bool {
    let values = request.get_all(header::IF_NONE_MATCH).iter().filter_map(|v| v.to_str().ok());
    values
        .flat_map(|value| value.split(','))
        .map(|known| known.trim())
        .any(|known| known == "*" || known.trim_start_matches("W/") == tag)
}

#[cfg(test)]
mod tests;
