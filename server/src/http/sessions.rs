//! `/v1/sessions`: simulations that stay at a worker between calls. A rollout from one names it as
//! `initial.session`; the stream of controls is a call of gRPC alone.

use axum::{
    extract::{Request, State},
    http::{StatusCode, header},
    response::{IntoResponse, Response},
};
use bendtwin_contract::rollout::Encoded;
use bendtwin_core::ids::SessionId;
use bendtwin_proto::{
    json::TensorFormat,
    v1::{
        AdvanceSessionRequest, CorrectSessionRequest, ForkSessionRequest, GetSessionStatesRequest,
        OpenSessionRequest, RenderSessionRequest, ResetSessionRequest, StepSessionRequest,
    },
    worker::v1::manage_session_request::Call,
};
use serde::Deserialize;

use super::{
    Result,
    extract::{Id, Params},
    message::{Body, Form, document},
    rollouts::ReplyParams,
};
use crate::app::{self, App, Error, Step, Whole};

/// Slots to ask for.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct StatesParams {
    /// Numbers of slots with commas between them; all of them by default.
    #[serde(default)]
    slots: String,
    /// `lists` (nested lists of numbers, the default) or `base64`.
    #[serde(default)]
    tensors: TensorFormat,
}

/// Open a session
pub(super) async fn open(
    State(app): State<App>,
    Params(params): Params<ReplyParams>,
    request: Request,
) -> Result<Response> {
    let body: Body<OpenSessionRequest> =
        Body::read(&app, request, Encoded::Open, params.tensors()).await?;
    // Held until the worker has the request.
    let Body { message, memory: _memory, .. } = body;
    let session = app.open_session(message, params.timeout()?).await?;
    let location = [(header::LOCATION, format!("/v1/{}", session.name))];
    Ok((StatusCode::CREATED, location, document(&session)).into_response())
}

/// States of slots
pub(super) async fn states(
    State(app): State<App>,
    Id(id): Id,
    Params(params): Params<StatesParams>,
) -> Result<Response> {
    let numbers = params.slots.split(',').filter(|number| !number.is_empty());
    let slots: Vec<u32> = numbers
        .map(|number| number.trim().parse())
        .collect::<Result<_, _>>()
        .map_err(|_| Error::invalid("slots", "is no list of numbers such as 0,1,5"))?;
    let asked = GetSessionStatesRequest { name: name(&id, String::new())?, slots };
    let form = Form::Json(params.tensors);
    let (states, held) = app.session_states(asked, None, form.is_lists()).await?;
    form.answer(states, held)
}

/// Advance a session
pub(super) async fn advance(
    State(app): State<App>,
    Id(id): Id,
    Params(params): Params<ReplyParams>,
    request: Request,
) -> Result<Response> {
    let body: Body<AdvanceSessionRequest> =
        Body::read(&app, request, Encoded::Advance, params.tensors()).await?;
    let Body { mut message, memory, form } = body;
    message.name = name(&id, message.name)?;
    let (timeout, as_lists) = (params.timeout()?, form.is_lists());
    let advanced = app.advance_session(message, timeout, as_lists, memory).await?;
    let Whole { response, held } = advanced;
    form.answer(response, held)
}

/// Copy the state of a slot to others
pub(super) async fn fork(
    State(app): State<App>,
    Id(id): Id,
    Params(params): Params<ReplyParams>,
    request: Request,
) -> Result<Response> {
    let body: Body<ForkSessionRequest> =
        Body::read(&app, request, Encoded::Other, params.tensors()).await?;
    let Body { mut message, memory: _memory, .. } = body;
    let name = name(&id, std::mem::take(&mut message.name))?;
    message.name.clone_from(&name);
    let call = Call::Fork(message);
    Ok(document(&app.session_call(&name, call, params.timeout()?).await?))
}

/// Correct slots by what is seen
pub(super) async fn correct(
    State(app): State<App>,
    Id(id): Id,
    Params(params): Params<ReplyParams>,
    request: Request,
) -> Result<Response> {
    let body: Body<CorrectSessionRequest> =
        Body::read(&app, request, Encoded::Correct, params.tensors()).await?;
    // Held until the worker has the request.
    let Body { mut message, memory: _memory, form } = body;
    message.name = name(&id, message.name)?;
    let (timeout, as_lists) = (params.timeout()?, form.is_lists());
    let (corrected, held) = app.correct_session(message, timeout, as_lists).await?;
    form.answer(corrected, held)
}

/// Take pictures of slots
pub(super) async fn render(
    State(app): State<App>,
    Id(id): Id,
    Params(params): Params<ReplyParams>,
    request: Request,
) -> Result<Response> {
    let body: Body<RenderSessionRequest> =
        Body::read(&app, request, Encoded::Render, params.tensors()).await?;
    // Held until the worker has the request.
    let Body { mut message, memory: _memory, form } = body;
    message.name = name(&id, message.name)?;
    let (timeout, as_lists) = (params.timeout()?, form.is_lists());
    let (rendered, held) = app.render_session(message, timeout, as_lists).await?;
    form.answer(rendered, held)
}

/// Set slots back
pub(super) async fn reset(
    State(app): State<App>,
    Id(id): Id,
    Params(params): Params<ReplyParams>,
    request: Request,
) -> Result<Response> {
    let body: Body<ResetSessionRequest> =
        Body::read(&app, request, Encoded::Reset, params.tensors()).await?;
    let Body { mut message, memory: _memory, .. } = body;
    let name = name(&id, std::mem::take(&mut message.name))?;
    message.name.clone_from(&name);
    let call = Call::Reset(message);
    Ok(document(&app.session_call(&name, call, params.timeout()?).await?))
}

/// Take a step of a closed loop
pub(super) async fn step(
    State(app): State<App>,
    Id(id): Id,
    Params(params): Params<ReplyParams>,
    request: Request,
) -> Result<Response> {
    let body: Body<StepSessionRequest> =
        Body::read(&app, request, Encoded::Step, params.tensors()).await?;
    let Body { message: mut request, memory, form } = body;
    request.name = name(&id, request.name)?;
    let (timeout, as_lists) = (params.timeout()?, form.is_lists());
    let step = Step { request, timeout, as_lists, memory };
    let stepped = app.step_session(step).await?;
    form.answer(stepped.response, stepped.held)
}

/// The session that a path names, and no other that the body does.
fn name(id: &str, given: String) -> Result<String> {
    let named = app::whole_name::<SessionId>(id)?;
    if !given.is_empty() && given != named {
        let fault = format!("is {given}, the path names {named}: leave it out");
        return Err(Error::invalid("name", fault).into());
    }
    Ok(named)
}
