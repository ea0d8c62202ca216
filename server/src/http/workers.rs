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
    let workers = app.workers(&page.token).await?.into_iter().map(Worker::from).collect();
    Ok(Json(Workers { workers, next_page_token: String::new() }))
}

/// One worker
#[utoipa::path(get, path = "/v1/workers/{id}", tag = "workers", params(("id" = String, Path)),
    responses((status = 200, body = Worker), (status = "default", body = ProblemDocument)))]
pub(super) async fn get(State(app): State<App>, Id(id): Id) -> Result<Json<Worker>> {
    Ok(Json(app.worker(&id).await?.into()))
}

/// Drain a worker
///
/// It takes no more jobs and rollouts, hands its job back with a checkpoint, finishes the rollouts
/// under way and exits; its sessions end with it. It is no error to ask again.
#[utoipa::path(post, path = "/v1/workers/{id}/drain", tag = "workers",
    params(("id" = String, Path)),
    responses((status = 200, body = Worker), (status = "default", body = ProblemDocument)))]
pub(super) async fn drain(State(app): State<App>, Id(id): Id) -> Result<Json<Worker>> {
    Ok(Json(app.drain_worker(&id).await?.into()))
}
