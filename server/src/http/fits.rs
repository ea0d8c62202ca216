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
    labels::{FitList, LabelUpdate, Losses},
    resource::{Fit, Fits, NewFit},
};
use crate::{
    app::{App, FitOrder},
    error::ProblemDocument,
};

/// List fits
#[utoipa::path(get, path = "/v1/fits", tag = "fits", params(FitList),
    responses((status = 200, body = Fits), (status = "default", body = ProblemDocument)))]
pub(super) async fn list(
    State(app): State<App>,
    Params(list): Params<FitList>,
) -> Result<Json<Fits>> {
    let page = app.fits(list.try_into()?).await?;
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
    let order = FitOrder {
        capture: new.capture,
        settings_json: new.settings.map(|s| s.get().to_owned()).unwrap_or_default(),
        priority: new.priority,
        request_id: extract::idempotency_key(&headers)?,
        display_name: new.display_name,
        requirements: new.requirements.into(),
    };
    let fit = app.create_fit(order).await?;
    let location = [(header::LOCATION, format!("/v1/{}", fit.id))];
    Ok((StatusCode::ACCEPTED, location, Json(Fit::from(fit))).into_response())
}

/// One fit
#[utoipa::path(get, path = "/v1/fits/{id}", tag = "fits", params(("id" = String, Path)),
    responses((status = 200, body = Fit), (status = "default", body = ProblemDocument)))]
pub(super) async fn get(State(app): State<App>, Id(id): Id) -> Result<Json<Fit>> {
    Ok(Json(app.fit(&id).await?.into()))
}

/// Change name, note and tags of a fit
#[utoipa::path(patch, path = "/v1/fits/{id}", tag = "fits",
    params(("id" = String, Path)),
    request_body = LabelUpdate,
    responses((status = 200, body = Fit), (status = "default", body = ProblemDocument)))]
pub(super) async fn update(
    State(app): State<App>,
    Id(id): Id,
    extract::Json(change): extract::Json<LabelUpdate>,
) -> Result<Json<Fit>> {
    Ok(Json(app.update_fit(&id, change.into()).await?.into()))
}

/// The losses of a fit
///
/// Of all iterations so far, by stage and model. They stay until the fit is deleted.
#[utoipa::path(get, path = "/v1/fits/{id}/losses", tag = "fits", params(("id" = String, Path)),
    responses((status = 200, body = Losses), (status = "default", body = ProblemDocument)))]
pub(super) async fn losses(State(app): State<App>, Id(id): Id) -> Result<Json<Losses>> {
    Ok(Json(app.fit_losses(&id).await?.into()))
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
