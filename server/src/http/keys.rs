//! `/v1/keys`.

use axum::{
    Json,
    extract::State,
    http::{StatusCode, header},
    response::{IntoResponse, Response},
};
use bendtwin_store as store;
use jiff::Timestamp;
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::{
    Result,
    extract::{self, Id, Params},
    resource::Paging,
};
use crate::{
    app::{App, Error, KeyOrder},
    error::ProblemDocument,
};

/// A key with which clients identify themselves.
#[derive(Serialize, ToSchema)]
struct Key {
    /// `keys/{uuid}`
    name: String,
    display_name: String,
    /// Recorded as `owner` of the captures, fits and twins that are made with the key.
    owner: String,
    /// Sorted: admin, captures:read, captures:write, fits:read, fits:write, rollouts:run,
    /// twins:read, twins:write.
    scopes: Vec<String>,
    /// RFC 3339.
    create_time: String,
    /// From then on it is refused; null: never.
    expire_time: Option<String>,
    /// Null unless it has been revoked.
    revoke_time: Option<String>,
    /// To about a minute; null if it has not been used.
    last_use_time: Option<String>,
    quotas: Quotas,
}

/// Bounds on what the owner of a key may have when the key asks for more; none where a field is
/// null.
#[derive(Default, Serialize, Deserialize, ToSchema)]
#[schema(as = KeyQuotas)]
#[serde(default, deny_unknown_fields)]
struct Quotas {
    /// Fits and ingests that wait for a worker.
    queued_jobs: Option<u64>,
    /// Size of captures, twin files and resumable uploads under way [bytes].
    stored_bytes: Option<u64>,
    /// Rollouts, plans, registrations and evaluations under way at one server.
    rollouts: Option<u64>,
}

impl From<store::Key> for Key {
    fn from(key: store::Key) -> Self {
        let time = |t: Option<Timestamp>| t.map(|t| t.to_string());
        let store::Quotas { queued_jobs, stored_bytes, rollouts } = key.quotas;
        Self {
            name: key.id.to_string(),
            display_name: key.display_name,
            owner: key.owner,
            scopes: key.scopes,
            create_time: key.created.to_string(),
            expire_time: time(key.expires),
            revoke_time: time(key.revoked),
            last_use_time: time(key.used),
            quotas: Quotas { queued_jobs, stored_bytes, rollouts },
        }
    }
}

/// A page of keys, newest first.
#[derive(Serialize, ToSchema)]
pub(super) struct Keys {
    keys: Vec<Key>,
    /// Empty on the last page.
    next_page_token: String,
}

/// A key to be made.
#[derive(Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct NewKey {
    /// 1 to 200 characters.
    display_name: String,
    /// Up to 200 characters; empty means the display name.
    #[serde(default)]
    owner: String,
    /// At least one.
    scopes: Vec<String>,
    /// RFC 3339; without it the key does not expire.
    expire_time: Option<String>,
    #[serde(default)]
    quotas: Quotas,
}

/// A key that was made.
#[derive(Serialize, ToSchema)]
struct MadeKey {
    key: Key,
    /// The key itself, `bt_{id}_{secret}`: what clients show. It is told here and nowhere else.
    secret_key: String,
}

impl TryFrom<NewKey> for KeyOrder {
    type Error = Error;
    fn try_from(new: NewKey) -> Result<Self, Error> {
        let NewKey { display_name, owner, scopes, expire_time, quotas } = new;
        let Quotas { queued_jobs, stored_bytes, rollouts } = quotas;
        let time = |text: String| {
            let fault = "is no time of RFC 3339, such as 2030-01-31T12:00:00Z";
            text.parse().map_err(|_| Error::invalid("expire_time", fault))
        };
        Ok(Self {
            display_name,
            owner,
            scopes,
            expires: expire_time.map(time).transpose()?,
            quotas: store::Quotas { queued_jobs, stored_bytes, rollouts },
        })
    }
}

/// List keys
///
/// Newest first; revoked and expired keys are among them.
#[utoipa::path(get, path = "/v1/keys", tag = "keys", params(Paging),
    responses((status = 200, body = Keys), (status = "default", body = ProblemDocument)))]
pub(super) async fn list(
    State(app): State<App>,
    Params(paging): Params<Paging>,
) -> Result<Json<Keys>> {
    let page = app.list_keys(&paging.into()).await?;
    let keys = page.items.into_iter().map(Key::from).collect();
    Ok(Json(Keys { keys, next_page_token: page.next_token }))
}

/// Make a key
///
/// The response has the key itself, which is stored nowhere: keep it.
#[utoipa::path(post, path = "/v1/keys", tag = "keys",
    request_body = NewKey,
    responses((status = 201, body = MadeKey), (status = "default", body = ProblemDocument)))]
pub(super) async fn create(
    State(app): State<App>,
    extract::Json(new): extract::Json<NewKey>,
) -> Result<Response> {
    let (key, secret_key) = app.create_key(new.try_into()?).await?;
    let headers = [
        (header::LOCATION, format!("/v1/{}", key.id)),
        (header::CACHE_CONTROL, "no-store".to_owned()),
    ];
    let made = MadeKey { key: key.into(), secret_key };
    Ok((StatusCode::CREATED, headers, Json(made)).into_response())
}

/// One key
#[utoipa::path(get, path = "/v1/keys/{id}", tag = "keys", params(("id" = String, Path)),
    responses((status = 200, body = Key), (status = "default", body = ProblemDocument)))]
pub(super) async fn get(State(app): State<App>, Id(id): Id) -> Result<Response> {
    Ok(Json(Key::from(app.key(&id).await?)).into_response())
}

/// Revoke a key
///
/// No server accepts it 30 s later. It stays in the list, with its `revoke_time`.
#[utoipa::path(delete, path = "/v1/keys/{id}", tag = "keys", params(("id" = String, Path)),
    responses((status = 204), (status = "default", body = ProblemDocument)))]
pub(super) async fn revoke(State(app): State<App>, Id(id): Id) -> Result<StatusCode> {
    app.revoke_key(&id).await?;
    Ok(StatusCode::NO_CONTENT)
}
