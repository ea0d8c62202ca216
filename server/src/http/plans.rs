//! `/v1/plans`: plans as server-sent events.

use std::{convert::Infallible, time::Duration};

use axum::{
    extract::{Request, State},
    response::sse::{Event, KeepAlive, Sse},
};
use bendtwin_contract::rollout::Encoded;
use bendtwin_proto::{
    json::{TensorFormat, Write},
    v1::{PlanRequest, PlanUpdate},
};
use futures::{Stream, StreamExt as _};
use prost::Message as _;

use super::{Result, extract::Params, message::Body, rollouts::ReplyParams};
use crate::{
    app::{App, Error, Plan},
    context::Context,
    refusal::Refusal,
};

const KEEP_ALIVE: Duration = Duration::from_secs(15);
/// Updates beyond this size are written beside the tasks of the runtime [bytes, as protobuf].
const SMALL: usize = 16 << 10;

/// Plan
pub(super) async fn create(
    State(app): State<App>,
    Params(params): Params<ReplyParams>,
    request: Request,
) -> Result<Sse<impl Stream<Item = Result<Event, Infallible>> + Send>> {
    let body: Body<PlanRequest> =
        Body::read(&app, request, Encoded::Plan, params.tensors()).await?;
    let Body { message: request, memory, .. } = body;
    let (timeout, tensors) = (params.timeout()?, params.tensors());
    let as_lists = tensors == TensorFormat::Lists;
    let updates = app.plan(Plan { request, timeout, as_lists, memory }).await?;
    // Streams outlive the scope of the request's context.
    let context = Context::current();
    let events = updates.then(move |update| {
        let context = context.clone();
        async move {
            let event = match update {
                Ok(update) => written(update, tensors).await,
                Err(error) => Err(error),
            };
            Ok(event.unwrap_or_else(|error| failed(error, &context)))
        }
    });
    Ok(Sse::new(events).keep_alive(KeepAlive::new().interval(KEEP_ALIVE)))
}

async fn written(update: PlanUpdate, tensors: TensorFormat) -> Result<Event, Error> {
    let is_small = update.encoded_len() <= SMALL;
    let write = move || {
        let event = Event::default().event("update");
        event
            .json_data(Write { message: &update, tensors })
            .map_err(|e| Error::Internal(format!("an update that cannot be written as JSON: {e}")))
    };
    if is_small {
        return write();
    }
    let event = tokio::task::spawn_blocking(write).await;
    event.map_err(|e| Error::Internal(format!("writing an update: {e}")))?
}

fn failed(error: Error, context: &Context) -> Event {
    let document = Refusal::from(error).document(context);
    let event = Event::default().event("error");
    // A document has nothing but texts and a number.
    event.json_data(document).unwrap_or_default()
}
