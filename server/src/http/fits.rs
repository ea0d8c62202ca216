//! `/v1/fits`.

use axum::{
    Json,
    extract::State,
    http::{HeaderMap, StatusCode, header},
    response::{IntoResponse, Response},
};

use super::{
    Result,
    extract::{self, Id, Params},
    resource::{Fit, Fits, NewFit, PagingByCapture},
};
use crate::{app::App, error::ProblemDocument};

/// List fits
#[utoipa::path(get, path = "/v1/fits", tag = "fits", params(PagingByCapture),
    responses((status = 200, body = Fits), (status = "default", body = ProblemDocument)))]
pub(super) async fn list(
    State(app): State<App>,
    Params(paging): Params<PagingByCapture>,
) -> Result<Json<Fits>> {
    let (page, capture) = paging.split();
    let page = app.fits(&page, &capture).await?;
    let fits = page.items.into_iter().map(Fit::from).collect();
    Ok(Json(Fits { fits, next_page_token: page.next_token }))
}

/// Queue a fit
#[utoipa::path(post, path = "/v1/fits", tag = "fits",
    params(("Idempotency-Key" = Option<String>, Header, description = "Makes the call idempotent")),
    request_body = NewFit,
    responses((status = 202, body = Fit), (status = "default", body = ProblemDocument)))]
pub(super) async fn create(
    State(app): State<App>,
    headers: HeaderMap,
    extract::Json(new): extract::Json<NewFit>,
) -> Result<Response> {
    let settings = new.settings.as_deref().map_or("", |s| s.get());
    let key = extract::idempotency_key(&headers)?;
    let fit = app.create_fit(&new.capture, settings, new.priority, key).await?;
    let location = [(header::LOCATION, format!("/v1/{}", fit.id))];
    Ok((StatusCode::ACCEPTED, location, Json(Fit::from(fit))).into_response())
}

/// One fit
#[utoipa::path(get, path = "/v1/fits/{id}", tag = "fits", params(("id" = String, Path)),
    responses((status = 200, body = Fit), (status = "default", body = ProblemDocument)))]
pub(super) async fn get(State(app): State<App>, Id(id): Id) -> Result<Json<Fit>> {
    Ok(Json(app.fit(&id).await?.into()))
}

/// Ask a fit to stop
///
/// A fit that has ended is returned as it is.
#[utoipa::path(post, path = "/v1/fits/{id}/cancel", tag = "fits", params(("id" = String, Path)),
    responses((status = 200, body = Fit), (status = "default", body = ProblemDocument)))]
pub(super) async fn cancel(State(app): State<App>, Id(id): Id) -> Result<Json<Fit>> {
    Ok(Json(app.cancel_fit(&id).await?.into()))
}

/// Delete a fit
///
/// Refused while it runs. Its twin stays.
#[utoipa::path(delete, path = "/v1/fits/{id}", tag = "fits", params(("id" = String, Path)),
    responses((status = 204), (status = "default", body = ProblemDocument)))]
pub(super) async fn delete(State(app): State<App>, Id(id): Id) -> Result<StatusCode> {
    app.delete_fit(&id).await?;
    Ok(StatusCode::NO_CONTENT)
}
