//! `/v1/twins/{id}/register`: the HTTP form of a registration, as JSON or as the protobuf messages of
//! `bendtwin.v1`.

use axum::{
    extract::{Request, State},
    response::Response,
};
use bendtwin_contract::rollout::Encoded;
use bendtwin_core::ids::TwinId;
use bendtwin_proto::v1::RegisterStateRequest;

use super::{
    Result,
    extract::{Id, Params},
    message::Body,
    rollouts::{ReplyParams, schema},
};
use crate::{
    app::{self, App, Error},
    dispatch::{Register, Registered},
    error::ProblemDocument,
};

/// Register a state
///
/// Points that were seen of an object in; the state of its twin that explains them out, with what is
/// left between the two. Body and reply are JSON, or with `application/x-protobuf` the messages
/// RegisterStateRequest and RegisteredState of bendtwin.v1.
#[utoipa::path(post, path = "/v1/twins/{id}/register", tag = "rollouts",
    operation_id = "register",
    params(("id" = String, Path), ReplyParams),
    request_body(content((schema::RegisterStateRequest = "application/json"), (Vec<u8> = "application/x-protobuf"))),
    responses((status = 200, content((schema::RegisteredState = "application/json"), (Vec<u8> = "application/x-protobuf"))),
        (status = "default", body = ProblemDocument)))]
pub(super) async fn register(
    State(app): State<App>,
    Id(id): Id,
    Params(params): Params<ReplyParams>,
    request: Request,
) -> Result<Response> {
    let twin: TwinId = app::name(&id)?;
    let body: Body<RegisterStateRequest> =
        Body::read(&app, request, Encoded::Register, params.tensors()).await?;
    let Body { message, memory, form } = body;
    if !message.twin.is_empty() && message.twin != twin.to_string() {
        let fault = format!("is {}, the path names {twin}: leave it out", message.twin);
        return Err(Error::invalid("twin", fault).into());
    }
    let request = RegisterStateRequest { twin: twin.to_string(), ..message };
    let (timeout, as_lists) = (params.timeout()?, form.is_lists());
    let register = Register { request, timeout, as_lists, memory };
    let Registered { state, held } = app.dispatch.register_state(register).await?;
    form.answer(state, held)
}
