//! Reading requests: axum's extractors with this API's problem documents.

use axum::{
    extract::{FromRequest, FromRequestParts, Path, Query, Request},
    http::{HeaderMap, StatusCode, header, request::Parts},
};
use bendtwin_contract::rollout;
use bendtwin_proto::json::{Fields, TensorFormat, from_query};
use futures::{StreamExt, TryStreamExt};
use hyper::body::Body as HttpBody;
use serde::{Deserialize, de::DeserializeOwned};

use crate::{
    app::{self, App, Error},
    listen::is_too_slow,
    memory::{Kind, ReceiveError, Received},
    refusal::Refusal,
};

/// The id of a path.
pub(super) struct Id(pub(super) String);

impl<S: Send + Sync> FromRequestParts<S> for Id {
    type Rejection = Refusal;
    async fn from_request_parts(parts: &mut Parts, state: &S) -> Result<Self, Refusal> {
        let path = Path::<String>::from_request_parts(parts, state).await;
        path.map(|Path(id)| Self(id)).map_err(|e| Error::invalid("path", e.body_text()).into())
    }
}

/// The id of a path, and the kind behind it.
pub(super) struct IdAndKind(pub(super) String, pub(super) String);

impl<S: Send + Sync> FromRequestParts<S> for IdAndKind {
    type Rejection = Refusal;
    async fn from_request_parts(parts: &mut Parts, state: &S) -> Result<Self, Refusal> {
        let path = Path::<(String, String)>::from_request_parts(parts, state).await;
        path.map(|Path((id, kind))| Self(id, kind))
            .map_err(|e| Error::invalid("path", e.body_text()).into())
    }
}

/// Query parameters.
pub(super) struct Params<T>(pub(super) T);

impl<T: DeserializeOwned, S: Send + Sync> FromRequestParts<S> for Params<T> {
    type Rejection = Refusal;
    async fn from_request_parts(parts: &mut Parts, state: &S) -> Result<Self, Refusal> {
        let query = Query::<T>::from_request_parts(parts, state).await;
        query.map(|Query(t)| Self(t)).map_err(|e| Error::invalid("query", e.body_text()).into())
    }
}

/// Form of the tensors of a reply.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct TensorParams {
    /// `lists` (nested lists of numbers, the default) or `base64`.
    #[serde(default)]
    pub(super) tensors: TensorFormat,
}

/// The metadata of an upload, in the query.
pub(super) struct Metadata<M>(pub(super) M);

impl<M: Fields, S: Send + Sync> FromRequestParts<S> for Metadata<M> {
    type Rejection = Refusal;
    async fn from_request_parts(parts: &mut Parts, _: &S) -> Result<Self, Refusal> {
        let read = from_query(parts.uri.query().unwrap_or_default());
        read.map(Self).map_err(|e| Error::invalid("query", e.to_string()).into())
    }
}

/// A JSON body of ordinary size.
pub(super) struct Json<T>(pub(super) T);

impl<T: DeserializeOwned> FromRequest<App> for Json<T> {
    type Rejection = Refusal;
    async fn from_request(request: Request, app: &App) -> Result<Self, Refusal> {
        expect_type(request.headers(), &["application/json"])?;
        let limit = app.options().limits.json_bytes as u64;
        let received = whole(app, request, Kind::Document, limit, |_| Ok(())).await?;
        json(&received.bytes).map(Self)
    }
}

/// Refuses bodies of another declared type; a missing type is accepted.
pub(super) fn expect_type(headers: &HeaderMap, types: &[&str]) -> Result<(), Refusal> {
    let Some(given) = headers.get(header::CONTENT_TYPE) else { return Ok(()) };
    let given = given.to_str().unwrap_or_default();
    let media_type = given.split(';').next().unwrap_or_default().trim();
    if types.iter().any(|t| media_type.eq_ignore_ascii_case(t)) {
        return Ok(());
    }
    let message = format!("send the body as {}", types.join(" or "));
    Err(Refusal::http_only(StatusCode::UNSUPPORTED_MEDIA_TYPE, "UNSUPPORTED_MEDIA_TYPE", &message))
}

pub(super) fn json<T: DeserializeOwned>(bytes: &[u8]) -> Result<T, Refusal> {
    serde_json::from_slice(bytes).map_err(|e| {
        let fault = format!("is not the JSON that is expected: {e}");
        Error::Invalid { field: "body", fault }.into()
    })
}

/// A body read to its end, in memory that it has taken before, unless `look` refuses its beginning.
pub(super) async fn whole(
    app: &App,
    request: Request,
    kind: Kind,
    limit: u64,
    look: impl Fn(&[u8]) -> Result<(), rollout::Error>,
) -> Result<Received, Refusal> {
    let received = app.receive_whole(request.into_body(), kind, limit, look).await;
    received.map_err(|error| match error {
        ReceiveError::TooLong => {
            let advice = match kind {
                Kind::Json => ": send application/x-protobuf, which may be larger",
                Kind::Protobuf | Kind::Document => "",
            };
            let message = format!("the body is larger than the limit of {limit} bytes{advice}");
            Refusal::http_only(StatusCode::PAYLOAD_TOO_LARGE, "CONTENT_TOO_LARGE", &message)
        }
        ReceiveError::Memory(error) => error.into(),
        ReceiveError::Refused(error) => Error::Rollout(error).into(),
        ReceiveError::Broken(error) => broken(&error).into(),
    })
}

/// A body to be streamed.
pub(super) fn upload_body(request: Request) -> app::Body {
    let body = request.into_body();
    let size_bytes = HttpBody::size_hint(&body).exact();
    let chunks = TryStreamExt::map_err(body.into_data_stream(), |e| broken(&e)).boxed();
    app::Body { chunks, size_bytes }
}

fn broken(error: &(dyn std::error::Error + 'static)) -> Error {
    if is_too_slow(error) {
        return Error::BodyTooSlow;
    }
    Error::UploadBroken("the body ended early".to_owned())
}

/// The digest that an upload declares: `?digest={hex}`, `X-Content-Blake3: {hex}`
/// or `Content-Digest: blake3=:{base64}:` (RFC 9530). Empty if none.
pub(super) fn declared_digest(headers: &HeaderMap, query: String) -> Result<String, Refusal> {
    use base64::{Engine, prelude::BASE64_STANDARD};
    if !query.is_empty() {
        return Ok(query);
    }
    let text = |name: &str| headers.get(name).map(|v| v.to_str().unwrap_or("?"));
    if let Some(hex) = text("x-content-blake3") {
        return Ok(hex.to_owned());
    }
    let Some(digests) = text("content-digest") else { return Ok(String::new()) };
    let member = digests.split(',').find_map(|d| d.trim().strip_prefix("blake3="));
    // Other algorithms are not known here; RFC 9530 lets them be ignored.
    let Some(member) = member else { return Ok(String::new()) };
    let bytes = member
        .strip_prefix(':')
        .and_then(|m| m.strip_suffix(':'))
        .and_then(|m| BASE64_STANDARD.decode(m).ok())
        .and_then(|b| <[u8; 32]>::try_from(b).ok())
        .ok_or_else(|| Error::invalid("content-digest", "is not blake3=:{base64 of 32 bytes}:"))?;
    Ok(bendtwin_store::Digest::from_bytes(bytes).to_hex().to_string())
}

/// The idempotency key of a creation; empty if none.
pub(super) fn idempotency_key(headers: &HeaderMap) -> Result<String, Refusal> {
    match headers.get("idempotency-key").map(|v| v.to_str()) {
        None => Ok(String::new()),
        Some(Ok(key)) if !key.is_empty() => Ok(key.to_owned()),
        Some(_) => {
            Err(Error::invalid("idempotency-key", "must be printable ASCII and not empty").into())
        }
    }
}
