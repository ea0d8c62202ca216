//! `/v1/twins/{id}/rollouts/stream`: the parts of a rollout's reply as server-sent events.

use axum::{
    extract::{Request, State},
    response::Response,
};

use bendtwin_proto::json::TensorFormat;

use super::{Asked, ReplyParams, document, read};
use crate::{
    app::{App, InParts, RollOut},
    http::{
        Result,
        extract::{Id, Params},
    },
};

/// Roll out in parts
pub(in crate::http) async fn stream(
    State(app): State<App>,
    Id(id): Id,
    Params(params): Params<ReplyParams>,
    request: Request,
) -> Result<Response> {
    let Asked { rollout, .. } = read(&app, &id, &params, request).await?;
    let as_lists = params.tensors == TensorFormat::Lists;
    let rollout = RollOut { in_parts: true, as_lists, ..rollout };
    let InParts { parts, held } = app.roll_out_in_parts(rollout).await?;
    Ok(document::events(parts, held, params.tensors))
}
