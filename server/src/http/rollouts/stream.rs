//! `/v1/twins/{id}/rollouts/stream`: the parts of a rollout's reply as server-sent events.

use axum::{
    extract::{Request, State},
    response::Response,
};

use bendtwin_proto::json::TensorFormat;

use super::{Asked, ReplyParams, document, read};
use crate::{
    app::App,
    dispatch::{InParts, RollOut},
    error::ProblemDocument,
    http::{
        Result,
        extract::{Id, Params},
    },
};

/// Roll out in parts
///
/// The same rollout, whose reply comes in parts as instances finish, and with
/// `returns.part_frames` in time as well: server-sent events named `part`, each with a
/// RollOutResponse as data. The stream ends after the last part. If something fails under way, an
/// event named `error` has the problem document. The request may be protobuf, the parts are JSON.
#[utoipa::path(post, path = "/v1/twins/{id}/rollouts/stream", tag = "rollouts",
    params(("id" = String, Path), ReplyParams),
    request_body(content((super::schema::RollOutRequest = "application/json"), (Vec<u8> = "application/x-protobuf"))),
    responses((status = 200, description = "Parts of the reply", body = String, content_type = "text/event-stream"),
        (status = "default", body = ProblemDocument)))]
pub(in crate::http) async fn stream(
    State(app): State<App>,
    Id(id): Id,
    Params(params): Params<ReplyParams>,
    request: Request,
) -> Result<Response> {
    let Asked { rollout, .. } = read(&app, &id, &params, request).await?;
    let as_lists = params.tensors == TensorFormat::Lists;
    let rollout = RollOut { in_parts: true, as_lists, ..rollout };
    let InParts { parts, held } = app.dispatch.parts(rollout).await?;
    Ok(document::events(parts, held, params.tensors))
}
