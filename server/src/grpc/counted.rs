//! The rollout service behind the memory of the server: a message is received in memory taken
//! before, checked before it is decoded, and its reply holds memory until it has been sent.

use std::{
    convert::Infallible,
    sync::Arc,
    task::{Context, Poll},
};

use bendtwin_contract::rollout::{self, Encoded};
use bendtwin_core::Problem as _;
use bendtwin_proto::fault;
use bytes::Bytes;
use http_body_util::{BodyExt as _, Full};
use tonic::{Status, body::Body, codegen::BoxFuture, codegen::http, server::NamedService};
use tower::Service;

use super::screened::Screened;
use crate::{
    app::{App, ReplyHold},
    memory::{GRPC_PREFIX, ReceiveError, Received, Shares},
    refusal::Refusal,
};

/// Mark of a request that HTTP makes in this process: its bytes are in memory already, within the limit of a JSON body.
#[derive(Clone, Copy)]
pub(crate) struct InProcess;

/// A service whose calls have one message, but for streams of them.
#[derive(Clone)]
pub(super) struct Counted<S> {
    pub(super) app: App,
    pub(super) inner: S,
}

impl<S: NamedService> NamedService for Counted<S> {
    const NAME: &'static str = S::NAME;
}

impl<S> Service<http::Request<Body>> for Counted<S>
where
    S: Service<http::Request<Body>, Response = http::Response<Body>, Error = Infallible>
        + Clone
        + Send
        + 'static,
    S::Future: Send,
{
    type Response = http::Response<Body>;
    type Error = Infallible;
    type Future = BoxFuture<Self::Response, Infallible>;

    fn poll_ready(&mut self, _: &mut Context<'_>) -> Poll<Result<(), Infallible>> {
        Poll::Ready(Ok(()))
    }

    fn call(&mut self, request: http::Request<Body>) -> Self::Future {
        let Self { app, mut inner } = self.clone();
        Box::pin(async move {
            if request.extensions().get::<InProcess>().is_some() {
                return inner.call(request).await;
            }
            let (parts, body) = request.into_parts();
            let encoded = match encoded(parts.uri.path()) {
                Message::One(encoded) => encoded,
                Message::Several(encoded) => {
                    let limits = app.options().limits.rollout;
                    let body = Body::new(Screened::new(body, encoded, limits));
                    return inner.call(http::Request::from_parts(parts, body)).await;
                }
            };
            let Received { bytes, memory } = match receive(&app, body, encoded).await {
                Ok(received) => received,
                Err(status) => return Ok(status.into_http()),
            };
            let mut request = http::Request::from_parts(parts, Body::new(Full::new(bytes)));
            request.extensions_mut().insert(memory);
            let mut response = inner.call(request).await?;
            Ok(match response.extensions_mut().remove::<ReplyHold>() {
                Some(held) => response.map(|body| {
                    let (share, place) = held.apart();
                    let hold = move |bytes: Bytes| bendtwin_budget::held(bytes, share.clone());
                    Body::new(body.map_frame(move |frame| {
                        let _place = &place;
                        frame.map_data(&hold)
                    }))
                }),
                None => response,
            })
        })
    }
}

/// Messages of a call.
enum Message {
    One(Encoded),
    Several(Encoded),
}

/// The messages of a method.
fn encoded(path: &str) -> Message {
    match path.rsplit('/').next() {
        Some("RollOut" | "StreamRollOut") => Message::One(Encoded::RollOut),
        Some("Plan") => Message::One(Encoded::Plan),
        Some("AdvanceSession") => Message::One(Encoded::Advance),
        Some("OpenSession") => Message::One(Encoded::Open),
        Some("ResetSession") => Message::One(Encoded::Reset),
        Some("RegisterState") => Message::One(Encoded::Register),
        Some("CorrectSession") => Message::One(Encoded::Correct),
        Some("RenderSession") => Message::One(Encoded::Render),
        Some("StepSession") => Message::One(Encoded::Step),
        Some("ControlSession") => Message::Several(Encoded::Advance),
        _ => Message::One(Encoded::Other),
    }
}

async fn receive(app: &App, body: Body, encoded: Encoded) -> Result<Received, Status> {
    let limits = app.options().limits.rollout;
    let look = |beginning: &[u8]| rollout::check_encoded(encoded, beginning, &limits);
    let received = app.receive_message(body, limits.request_bytes, look).await;
    let received = received.map_err(|error| match error {
        ReceiveError::Memory(error) => Status::from(Refusal::from(error)),
        ReceiveError::Refused(error) => fault::status(&error.fault()),
        // The service never gets to read these.
        ReceiveError::TooLong => Status::out_of_range("the message is too long"),
        ReceiveError::Broken(error) => Status::cancelled(format!("the body broke off: {error}")),
    })?;
    if let Some((&[0, ..], message)) = received.bytes.split_at_checked(GRPC_PREFIX) {
        rollout::check_encoded(encoded, message, &limits).map_err(|e| fault::status(&e.fault()))?;
    }
    Ok(received)
}

/// The memory of a call's request.
pub(super) fn memory_of<T>(request: &tonic::Request<T>) -> Arc<Shares> {
    request.extensions().get::<Arc<Shares>>().cloned().unwrap_or_default()
}
