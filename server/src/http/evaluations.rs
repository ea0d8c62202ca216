//! `/v1/twins/{id}/evaluations`.

use axum::{Json, extract::State};
use bendtwin_proto::{
    json::{TensorFormat, Write},
    v1::{EvaluateTwinRequest, MotionRequest, PredictedMotion},
};
use prost::Message as _;
use serde::{Deserialize, Serialize};
use serde_json::value::RawValue;
use utoipa::ToSchema;

use super::{
    Result,
    extract::{self, Id, Params},
    resource::raw,
    rollouts::{ReplyParams, schema},
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
    /// Also return the predicted motion of a sequence.
    motion: Option<MotionOf>,
}

/// A sequence whose predicted motion is asked for.
#[derive(Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct MotionOf {
    /// Its index among the sequences of all recordings of the capture, in their order.
    #[serde(default)]
    sequence: u32,
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
    /// The motion that was asked for; missing if the twin could not be registered to its recording,
    /// which a warning of the table explains.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(value_type = Option<schema::PredictedMotion>)]
    motion: Option<Box<RawValue>>,
}

/// Evaluate a twin
///
/// The quality table of a twin on a capture: the twin is rolled out beside every sequence. To a
/// recording of its object that it was not fitted to it is registered first, and all frames count as
/// future. The table is kept nowhere. `motion` also asks for the predicted positions of nodes in a
/// sequence, and its errors frame by frame.
#[utoipa::path(post, path = "/v1/twins/{id}/evaluations", tag = "twins",
    operation_id = "evaluate",
    params(("id" = String, Path), ReplyParams),
    request_body = EvaluateTwin,
    responses((status = 200, body = Evaluation), (status = "default", body = ProblemDocument)))]
pub(super) async fn create(
    State(app): State<App>,
    Id(id): Id,
    Params(params): Params<ReplyParams>,
    extract::Json(body): extract::Json<EvaluateTwin>,
) -> Result<Json<Evaluation>> {
    let motion = body.motion.map(|of| MotionRequest { sequence: of.sequence });
    let request = EvaluateTwinRequest { twin: id, capture: body.capture, motion };
    let evaluation = app.evaluate_twin(request, params.timeout()?).await?;
    let motion = match evaluation.motion {
        Some(motion) => Some(written(&app, motion, params.tensors()).await?),
        None => None,
    };
    Ok(Json(Evaluation {
        twin: evaluation.twin,
        capture: evaluation.capture,
        quality: raw(evaluation.quality_json),
        worker: evaluation.worker,
        motion,
    }))
}

/// A motion as JSON.
async fn written(
    app: &App,
    motion: PredictedMotion,
    tensors: TensorFormat,
) -> Result<Box<RawValue>> {
    let share = app.memory.reply(motion.encoded_len() as u64).await?;
    let written = tokio::task::spawn_blocking(move || {
        let _share = share;
        serde_json::value::to_raw_value(&Write { message: &motion, tensors })
    });
    let fault = |e: &dyn std::fmt::Display| Error::Internal(format!("writing a motion: {e}"));
    Ok(written.await.map_err(|e| fault(&e))?.map_err(|e| fault(&e))?)
}
