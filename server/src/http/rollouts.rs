//! `/v1/twins/{id}/rollouts`: the HTTP form of a rollout, as JSON or as the
//! protobuf messages of `bendtwin.v1`.

pub(super) mod document;
pub(super) mod stream;

use std::time::Duration;

use axum::{
    extract::{Request, State},
    response::Response,
};
use bendtwin_contract::rollout::Encoded;
use bendtwin_core::ids::TwinId;
use bendtwin_proto::{json::TensorFormat, v1::RollOutRequest};
use serde::Deserialize;

use super::{
    Result,
    extract::{Id, Params},
    message::{Body, Form},
};
use crate::app::{self, App, Error, RollOut, Whole};

/// Form of the reply, and the time for it.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ReplyParams {
    /// `lists` (nested lists of numbers, the default) or `base64`.
    #[serde(default)]
    tensors: TensorFormat,
    /// Give up after so many seconds.
    timeout_s: Option<f64>,
}

impl ReplyParams {
    /// The form of tensors.
    pub(super) fn tensors(&self) -> TensorFormat {
        self.tensors
    }

    /// The time that the caller allows, if it said.
    pub(super) fn timeout(&self) -> Result<Option<Duration>> {
        let timeout = self.timeout_s.map(Duration::try_from_secs_f64).transpose();
        let fault = "is negative, too large or not a number";
        Ok(timeout.map_err(|_| Error::invalid("timeout_s", fault))?)
    }
}

/// Roll out
pub(super) async fn create(
    State(app): State<App>,
    Id(id): Id,
    Params(params): Params<ReplyParams>,
    request: Request,
) -> Result<Response> {
    let Asked { rollout, form } = read(&app, &id, &params, request).await?;
    let Whole { response, held } = app.roll_out(rollout).await?;
    form.answer(response, held)
}

/// A rollout that was asked for, and the form that its reply is to have.
struct Asked {
    rollout: RollOut,
    form: Form,
}

/// Reads the request for a rollout of a twin.
async fn read(app: &App, id: &str, params: &ReplyParams, request: Request) -> Result<Asked> {
    let twin = app::whole_name::<TwinId>(id)?;
    let body: Body<RollOutRequest> =
        Body::read(app, request, Encoded::RollOut, params.tensors()).await?;
    let Body { message, memory, form } = body;
    let request = RollOutRequest { twin: of_twin(twin, &message.twin)?, ..message };
    let (commit_slots, timeout) = (Vec::new(), params.timeout()?);
    let as_lists = form.is_lists();
    let rollout = RollOut { request, timeout, in_parts: false, as_lists, commit_slots, memory };
    Ok(Asked { rollout, form })
}

/// The twin that a path names, and no other that the body does.
pub(super) fn of_twin(named: String, given: &str) -> Result<String> {
    if !given.is_empty() && given != named {
        let fault = format!("is {given}, the path names {named}: leave it out");
        return Err(Error::invalid("twin", fault).into());
    }
    Ok(named)
}
