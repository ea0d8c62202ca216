//! `/v1/workers`.

use axum::{Json, extract::State};

use super::{
    Result,
    extract::{Id, Params},
    resource::{Paging, Worker, Workers},
};
use crate::{app::App, error::ProblemDocument};

/// List workers
#[utoipa::path(get, path = "/v1/workers", tag = "workers", params(Paging),
    responses((status = 200, body = Workers), (status = "default", body = ProblemDocument)))]
pub(super) async fn list(
    State(app): State<App>,
    Params(paging): Params<Paging>,
) -> Result<Json<Workers>> {
    let page: bendtwin_store::PageRequest = paging.into();
    let workers = app.workers(&page.token)?.into_iter().map(Worker::from).collect();
    Ok(Json(Workers { workers, next_page_token: String::new() }))
}

/// One worker
#[utoipa::path(get, path = "/v1/workers/{id}", tag = "workers", params(("id" = String, Path)),
    responses((status = 200, body = Worker), (status = "default", body = ProblemDocument)))]
pub(super) async fn get(State(app): State<App>, Id(id): Id) -> Result<Json<Worker>> {
    Ok(Json(app.worker(&id)?.into()))
}
