//! `/v1/twins/{id}/rollouts`: the HTTP form of a rollout, as JSON or as the
//! protobuf messages of `bendtwin.v1`.

pub(super) mod document;
pub(super) mod schema;
pub(super) mod stream;

use std::{sync::Arc, time::Duration};

use axum::{
    extract::{Request, State},
    http::header,
    response::{IntoResponse, Response},
};
use bendtwin_proto::{
    json::{Read, TensorFormat},
    rollout,
    v1::RollOutRequest,
};
use bytes::Bytes;
use prost::Message;
use serde::Deserialize;
use utoipa::IntoParams;

use super::{
    Result,
    extract::{self, Id, Params},
};
use crate::{
    app::{self, App, Error},
    dispatch::{RollOut, Whole},
    error::{ProblemDocument, Refusal},
    memory::{Kind, Shares},
};
use bendtwin_core::ids::TwinId;

/// Texts beyond this size are read beside the tasks of the runtime [bytes].
const SMALL_TEXT: usize = 16 << 10;

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
/// RollOutResponse of bendtwin.v1. A large body must be protobuf, and a large
/// reply base64 or protobuf.
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
    let Asked { rollout, as_protobuf } = read(&app, &id, &params, request).await?;
    let Whole { response, held } = app.dispatch.roll_out(rollout).await?;
    if as_protobuf {
        let body = bendtwin_budget::held(response.encode_to_vec().into(), held.memory());
        return Ok(([(header::CONTENT_TYPE, PROTOBUF)], body).into_response());
    }
    Ok(document::answer(response, held, params.tensors)?)
}

/// A rollout that was asked for.
struct Asked {
    rollout: RollOut,
    /// True if the client speaks protobuf.
    as_protobuf: bool,
}

/// Reads the request for a rollout of a twin.
async fn read(app: &App, id: &str, params: &ReplyParams, request: Request) -> Result<Asked> {
    let twin: TwinId = app::name(id)?;
    extract::expect_type(request.headers(), &["application/json", PROTOBUF])?;
    let wants_protobuf = names_protobuf(&request, header::ACCEPT);
    let sends_protobuf = names_protobuf(&request, header::CONTENT_TYPE);
    let limits = app.options.limits.rollout;
    let (kind, most) = if sends_protobuf {
        (Kind::Protobuf, limits.request_bytes)
    } else {
        (Kind::Json, limits.json_bytes)
    };
    let received = extract::whole(app, request, kind, most).await?;
    let message = if sends_protobuf {
        rollout::check_encoded(rollout::Encoded::RollOut, &received.bytes, &limits)
            .map_err(Error::Rollout)?;
        RollOutRequest::decode(received.bytes)
            .map_err(|e| Error::invalid("body", format!("is no RollOutRequest: {e}")))?
    } else {
        read_json(received.bytes, &received.memory).await?
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
    let as_protobuf = wants_protobuf || sends_protobuf;
    let as_lists = !as_protobuf && params.tensors == TensorFormat::Lists;
    let memory = received.memory;
    let commit_slots = Vec::new();
    let rollout = RollOut { request, timeout, in_parts: false, as_lists, commit_slots, memory };
    Ok(Asked { rollout, as_protobuf })
}

/// Reads a request. `memory` is held until that has ended, also when nobody waits any more.
async fn read_json(text: Bytes, memory: &Arc<Shares>) -> Result<RollOutRequest> {
    if text.len() <= SMALL_TEXT {
        return Ok(extract::json::<Read<RollOutRequest>>(&text)?.0);
    }
    let memory = Arc::clone(memory);
    let read = tokio::task::spawn_blocking(move || {
        let read = extract::json::<Read<RollOutRequest>>(&text)?;
        drop(text);
        memory.decoded(read.0.encoded_len());
        Ok::<_, Refusal>(read)
    });
    let read = read.await.map_err(|e| Error::Internal(format!("reading a rollout: {e}")))?;
    Ok(read?.0)
}

fn names_protobuf(request: &Request, name: header::HeaderName) -> bool {
    let value = request.headers().get(name).and_then(|v| v.to_str().ok());
    value.is_some_and(|v| v.trim().starts_with(PROTOBUF))
}
