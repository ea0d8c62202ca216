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
    rollouts::{ReplyParams, of_twin},
};
use crate::app::{self, App, Register, Registered};

/// Register a state
pub(super) async fn register(
    State(app): State<App>,
    Id(id): Id,
    Params(params): Params<ReplyParams>,
    request: Request,
) -> Result<Response> {
    let twin = app::whole_name::<TwinId>(&id)?;
    let body: Body<RegisterStateRequest> =
        Body::read(&app, request, Encoded::Register, params.tensors()).await?;
    let Body { message, memory, form } = body;
    let request = RegisterStateRequest { twin: of_twin(twin, &message.twin)?, ..message };
    let (timeout, as_lists) = (params.timeout()?, form.is_lists());
    let register = Register { request, timeout, as_lists, memory };
    let Registered { state, held } = app.register_state(register).await?;
    form.answer(state, held)
}
