//! `/v1/twins/{id}/evaluations`.

use std::time::Duration;

use axum::{Json, extract::State};
use serde::{Deserialize, Serialize};
use serde_json::value::RawValue;
use utoipa::{IntoParams, ToSchema};

use super::{
    Result,
    extract::{self, Id, Params},
    resource::raw,
};
use crate::{
    app::{App, Error},
    error::ProblemDocument,
};

/// A recording to evaluate a twin on.
#[derive(Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct EvaluateTwin {
    /// `captures/{uuid}`
    capture: String,
}

/// The quality of a twin on a recording.
#[derive(Serialize, ToSchema)]
pub(super) struct Evaluation {
    /// `twins/{uuid}`
    twin: String,
    /// `captures/{uuid}`
    capture: String,
    /// The quality table, with its assessment; `recordings` says how well the twin was registered.
    #[schema(value_type = Object)]
    quality: Box<RawValue>,
    /// `workers/{uuid}`
    worker: String,
}

/// Time for an answer.
#[derive(Deserialize, IntoParams)]
#[serde(deny_unknown_fields)]
#[into_params(parameter_in = Query)]
pub(super) struct Time {
    /// Give up after so many seconds.
    timeout_s: Option<f64>,
}

/// Evaluate a twin
///
/// The quality table of a twin on a capture: the twin is rolled out beside every sequence. To a
/// recording of its object that it was not fitted to it is registered first, and all frames count as
/// future. The table is kept nowhere.
#[utoipa::path(post, path = "/v1/twins/{id}/evaluations", tag = "twins",
    operation_id = "evaluate",
    params(("id" = String, Path), Time),
    request_body = EvaluateTwin,
    responses((status = 200, body = Evaluation), (status = "default", body = ProblemDocument)))]
pub(super) async fn create(
    State(app): State<App>,
    Id(id): Id,
    Params(time): Params<Time>,
    extract::Json(body): extract::Json<EvaluateTwin>,
) -> Result<Json<Evaluation>> {
    let timeout = time.timeout_s.map(Duration::try_from_secs_f64).transpose();
    let fault = "is negative, too large or not a number";
    let timeout = timeout.map_err(|_| Error::invalid("timeout_s", fault))?;
    let evaluation = app.evaluate_twin(&id, &body.capture, timeout).await?;
    Ok(Json(Evaluation {
        twin: evaluation.twin,
        capture: evaluation.capture,
        quality: raw(evaluation.quality_json),
        worker: evaluation.worker,
    }))
}
