//! `/v1/twins/{id}/rollouts`: the HTTP form of a rollout, as JSON or as the
//! protobuf messages of `bendtwin.v1`.

mod schema;

use std::time::Duration;

use axum::{
    extract::{Request, State},
    http::header,
    response::{IntoResponse, Response},
};
use bendtwin_proto::{
    json::{Read, TensorFormat, Write},
    v1::{RollOutRequest, RollOutResponse},
};
use prost::Message;
use serde::Deserialize;
use utoipa::IntoParams;

use super::{
    Result,
    extract::{self, Id, Params},
};
use crate::{
    app::{self, App, Error},
    dispatch::RollOut,
    error::ProblemDocument,
};
use bendtwin_core::ids::TwinId;

const PROTOBUF: &str = "application/x-protobuf";

/// Form of the reply, and the time for it.
#[derive(Deserialize, IntoParams)]
#[serde(deny_unknown_fields)]
#[into_params(parameter_in = Query)]
pub(super) struct ReplyParams {
    /// `lists` (nested lists of numbers, the default) or `base64`.
    #[serde(default)]
    #[param(value_type = String, pattern = "lists|base64")]
    tensors: TensorFormat,
    /// Give up after so many seconds.
    timeout_s: Option<f64>,
}

/// Roll out
///
/// Robot actions in; motion, costs or gradients out. Body and reply are JSON,
/// or with `application/x-protobuf` the messages RollOutRequest and
/// RollOutResponse of bendtwin.v1.
#[utoipa::path(post, path = "/v1/twins/{id}/rollouts", tag = "rollouts",
    params(("id" = String, Path), ReplyParams),
    request_body(content((schema::RollOutRequest = "application/json"), (Vec<u8> = "application/x-protobuf"))),
    responses((status = 200, content((schema::RollOutResponse = "application/json"), (Vec<u8> = "application/x-protobuf"))),
        (status = "default", body = ProblemDocument)))]
pub(super) async fn create(
    State(app): State<App>,
    Id(id): Id,
    Params(params): Params<ReplyParams>,
    request: Request,
) -> Result<Response> {
    let twin: TwinId = app::name(&id)?;
    extract::expect_type(request.headers(), &["application/json", PROTOBUF])?;
    let wants_protobuf = names_protobuf(&request, header::ACCEPT);
    let sends_protobuf = names_protobuf(&request, header::CONTENT_TYPE);
    let most = usize::try_from(app.options.limits.rollout.request_bytes).unwrap_or(usize::MAX);
    let bytes = extract::whole(request, most).await?;
    let message = if sends_protobuf {
        RollOutRequest::decode(bytes)
            .map_err(|e| Error::invalid("body", format!("is no RollOutRequest: {e}")))?
    } else {
        extract::json::<Read<RollOutRequest>>(&bytes)?.0
    };
    let timeout = params
        .timeout_s
        .map(Duration::try_from_secs_f64)
        .transpose()
        .map_err(|_| Error::invalid("timeout_s", "is negative, too large or not a number"))?;
    if !message.twin.is_empty() && message.twin != twin.to_string() {
        let fault = format!("is {}, the path names {twin}: leave it out", message.twin);
        return Err(Error::invalid("twin", fault).into());
    }
    let request = RollOutRequest { twin: twin.to_string(), ..message };
    let response = app.dispatch.roll_out(RollOut { request, timeout, in_parts: false }).await?;
    if wants_protobuf || sends_protobuf {
        let headers = [(header::CONTENT_TYPE, PROTOBUF)];
        return Ok((headers, response.encode_to_vec()).into_response());
    }
    let json = document(&response, params.tensors)?;
    Ok(([(header::CONTENT_TYPE, "application/json")], json).into_response())
}

fn document(response: &RollOutResponse, tensors: TensorFormat) -> app::Result<Vec<u8>> {
    serde_json::to_vec(&Write { message: response, tensors })
        .map_err(|e| Error::Internal(format!("a reply that cannot be written as JSON: {e}")))
}

fn names_protobuf(request: &Request, name: header::HeaderName) -> bool {
    let value = request.headers().get(name).and_then(|v| v.to_str().ok());
    value.is_some_and(|v| v.trim().starts_with(PROTOBUF))
}
