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
    json::{TensorFormat, Write},
    v1::{
        AdvanceSessionRequest, CloseSessionRequest, CorrectSessionRequest, ForkSessionRequest,
        GetSessionRequest, GetSessionStatesRequest, OpenSessionRequest, ResetSessionRequest,
        StepSessionRequest,
    },
    worker::v1::manage_session_request::Call,
};
use serde::{Deserialize, Serialize};
use utoipa::IntoParams;

use super::{
    Result,
    extract::{Id, Params},
    message::{Body, Form},
    rollouts::{ReplyParams, schema},
};
use crate::{
    app::{self, App, Error},
    dispatch::{Step, Whole},
    error::ProblemDocument,
};

/// Slots to ask for.
#[derive(Deserialize, IntoParams)]
#[serde(deny_unknown_fields)]
#[into_params(parameter_in = Query)]
pub(super) struct StatesParams {
    /// Numbers of slots with commas between them; all of them by default.
    #[serde(default)]
    #[param(pattern = "^([0-9]+(,[0-9]+)*)?$")]
    slots: String,
    /// `lists` (nested lists of numbers, the default) or `base64`.
    #[serde(default)]
    #[param(value_type = String, pattern = "lists|base64")]
    tensors: TensorFormat,
}

/// Open a session
///
/// Simulations of a twin that stay at a worker until they are closed or nobody has used them for
/// `idle_timeout_s`.
#[utoipa::path(post, path = "/v1/sessions", tag = "sessions", params(ReplyParams),
    request_body(content((schema::OpenSessionRequest = "application/json"), (Vec<u8> = "application/x-protobuf"))),
    responses((status = 201, body = schema::Session), (status = "default", body = ProblemDocument)))]
pub(super) async fn open(
    State(app): State<App>,
    Params(params): Params<ReplyParams>,
    request: Request,
) -> Result<Response> {
    let body: Body<OpenSessionRequest> =
        Body::read(&app, request, Encoded::Open, params.tensors()).await?;
    // Held until the worker has the request.
    let Body { message, memory: _memory, .. } = body;
    let session = app.dispatch.open_session(message, params.timeout()?).await?;
    let location = [(header::LOCATION, format!("/v1/{}", session.name))];
    Ok((StatusCode::CREATED, location, document(&session)).into_response())
}

/// One session
#[utoipa::path(get, path = "/v1/sessions/{id}", tag = "sessions", params(("id" = String, Path)),
    responses((status = 200, body = schema::Session), (status = "default", body = ProblemDocument)))]
pub(super) async fn get(State(app): State<App>, Id(id): Id) -> Result<Response> {
    let name = name(&id, String::new())?;
    let call = Call::Get(GetSessionRequest { name: name.clone() });
    Ok(document(&app.dispatch.session_call(&name, call, None).await?))
}

/// Close a session
///
/// It is no error if it has ended.
#[utoipa::path(delete, path = "/v1/sessions/{id}", tag = "sessions", params(("id" = String, Path)),
    responses((status = 204), (status = "default", body = ProblemDocument)))]
pub(super) async fn close(State(app): State<App>, Id(id): Id) -> Result<StatusCode> {
    let close = CloseSessionRequest { name: name(&id, String::new())? };
    app.dispatch.close_session(close, None).await?;
    Ok(StatusCode::NO_CONTENT)
}

/// States of slots
///
/// `states` is what `initial.given` takes.
#[utoipa::path(get, path = "/v1/sessions/{id}/states", tag = "sessions",
    params(("id" = String, Path), StatesParams),
    responses((status = 200, body = schema::SessionStates), (status = "default", body = ProblemDocument)))]
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
    let (states, held) = app.dispatch.session_states(asked, None, form.is_lists()).await?;
    form.answer(states, held)
}

/// Advance a session
///
/// Simulates the rollout from where slots are, and leaves them where it ends. Nothing changes if it
/// fails or an instance diverges.
#[utoipa::path(post, path = "/v1/sessions/{id}/advance", tag = "sessions",
    params(("id" = String, Path), ReplyParams),
    request_body(content((schema::AdvanceSessionRequest = "application/json"), (Vec<u8> = "application/x-protobuf"))),
    responses((status = 200, content((schema::RollOutResponse = "application/json"), (Vec<u8> = "application/x-protobuf"))),
        (status = "default", body = ProblemDocument)))]
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
    let advanced = app.dispatch.advance_session(message, timeout, as_lists, memory).await?;
    let Whole { response, held } = advanced;
    form.answer(response, held)
}

/// Copy the state of a slot to others
#[utoipa::path(post, path = "/v1/sessions/{id}/fork", tag = "sessions",
    params(("id" = String, Path), ReplyParams),
    request_body(content((schema::ForkSessionRequest = "application/json"), (Vec<u8> = "application/x-protobuf"))),
    responses((status = 200, body = schema::Session), (status = "default", body = ProblemDocument)))]
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
    Ok(document(&app.dispatch.session_call(&name, call, params.timeout()?).await?))
}

/// Correct slots by what is seen
///
/// Brings their states closer to points that were seen of the object, in place and outside of
/// obstacles; all of them, or none if more than the stated residual is left at one. The reply has the
/// corrected states, and says whether slots still follow their object.
#[utoipa::path(post, path = "/v1/sessions/{id}/correct", tag = "sessions",
    params(("id" = String, Path), ReplyParams),
    request_body(content((schema::CorrectSessionRequest = "application/json"), (Vec<u8> = "application/x-protobuf"))),
    responses((status = 200, content((schema::CorrectedSession = "application/json"), (Vec<u8> = "application/x-protobuf"))),
        (status = "default", body = ProblemDocument)))]
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
    let (corrected, held) = app.dispatch.correct_session(message, timeout, as_lists).await?;
    form.answer(corrected, held)
}

/// Set slots back
///
/// To the session's first state, or to a given one.
#[utoipa::path(post, path = "/v1/sessions/{id}/reset", tag = "sessions",
    params(("id" = String, Path), ReplyParams),
    request_body(content((schema::ResetSessionRequest = "application/json"), (Vec<u8> = "application/x-protobuf"))),
    responses((status = 200, body = schema::Session), (status = "default", body = ProblemDocument)))]
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
    Ok(document(&app.dispatch.session_call(&name, call, params.timeout()?).await?))
}

/// Take a step of a closed loop
///
/// Corrects a slot by what is seen, plans from there, and advances the slot by the first frames of the
/// best plan. All of the request is checked before anything changes.
#[utoipa::path(post, path = "/v1/sessions/{id}/step", tag = "sessions",
    params(("id" = String, Path), ReplyParams),
    request_body(content((schema::StepSessionRequest = "application/json"), (Vec<u8> = "application/x-protobuf"))),
    responses((status = 200, content((schema::SteppedSession = "application/json"), (Vec<u8> = "application/x-protobuf"))),
        (status = "default", body = ProblemDocument)))]
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
    let (timeout, as_lists, stopping) = (params.timeout()?, form.is_lists(), app.stopping.clone());
    let step = Step { request, timeout, as_lists, memory, stopping };
    let stepped = app.dispatch.step_session(step).await?;
    form.answer(stepped.response, stepped.held)
}

/// The session that a path names, and no other that the body does.
fn name(id: &str, given: String) -> Result<String> {
    let session: SessionId = app::name(id)?;
    let named = session.to_string();
    if !given.is_empty() && given != named {
        let fault = format!("is {given}, the path names {named}: leave it out");
        return Err(Error::invalid("name", fault).into());
    }
    Ok(named)
}

fn document<M>(message: &M) -> Response
where
    for<'m> Write<'m, M>: Serialize,
{
    axum::Json(Write { message, tensors: TensorFormat::default() }).into_response()
}
