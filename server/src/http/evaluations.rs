//! `/v1/twins/{id}/evaluations`.

use axum::{extract::State, response::Response};
use bendtwin_core::ids::TwinId;
use bendtwin_proto::{json::Read, v1::EvaluateTwinRequest};
use prost::Message as _;

use super::{
    Result,
    extract::{self, Id, Params},
    rollouts::{ReplyParams, document::answer, of_twin},
};
use crate::app::{self, App};

/// Evaluate a twin: the quality table, and the requested motion, in separate memory.
pub(super) async fn create(
    State(app): State<App>,
    Id(id): Id,
    Params(params): Params<ReplyParams>,
    extract::Json(Read(mut request)): extract::Json<Read<EvaluateTwinRequest>>,
) -> Result<Response> {
    let twin = app::whole_name::<TwinId>(&id)?;
    request.twin = of_twin(twin, &request.twin)?;
    let evaluation = app.evaluate_twin(request, params.timeout()?).await?;
    let share = app.reply_memory(evaluation.encoded_len() as u64).await?;
    Ok(answer(evaluation, share, params.tensors())?)
}
