//! `/v1/twins/{id}/play` and `/v1/plays`: WebSockets on which a play is seen and moved, and what was
//! recorded. docs/formats/play.md has the messages.

mod socket;

use std::time::Duration;

use axum::{
    extract::{
        FromRequestParts, Request, State,
        ws::{WebSocketUpgrade, rejection::WebSocketUpgradeRejection},
    },
    http::{StatusCode, header, request::Parts},
    response::{IntoResponse, Response},
};
use bendtwin_play::{Document, Recording};

use super::{
    Result,
    extract::{self, Id},
};
use crate::{
    access::client_token::TOKEN_PROTOCOL,
    app::{App, Error},
    context::Context,
    memory::Kind,
    refusal::Refusal,
};

/// The protocol within the WebSocket.
const PROTOCOL: &str = "bendtwin.play.v1";
/// Longest first message, which may have a state, and longest message that waits to be written
/// [bytes].
const FIRST_BYTES: usize = 4 << 20;
/// Longest message of one that only watches [bytes].
const WATCHER_BYTES: usize = 4 << 10;
const READ_BUFFER: usize = 8 << 10;

/// A request that can become a WebSocket.
pub(super) struct Upgrade(WebSocketUpgrade);

impl<S: Send + Sync> FromRequestParts<S> for Upgrade {
    type Rejection = Refusal;
    async fn from_request_parts(parts: &mut Parts, state: &S) -> Result<Self, Refusal> {
        let upgrade = WebSocketUpgrade::from_request_parts(parts, state).await;
        upgrade.map(Self).map_err(no_socket)
    }
}

fn no_socket(rejection: WebSocketUpgradeRejection) -> Refusal {
    let message = format!("this path is for WebSockets over HTTP/1.1: {}", rejection.body_text());
    Refusal::http_only(StatusCode::UPGRADE_REQUIRED, "WEBSOCKET_REQUIRED", &message)
}

impl Upgrade {
    fn bounded(self, most: usize) -> WebSocketUpgrade {
        self.0
            .protocols([PROTOCOL, TOKEN_PROTOCOL])
            .read_buffer_size(READ_BUFFER)
            .write_buffer_size(0)
            .max_write_buffer_size(FIRST_BYTES)
            .max_message_size(most)
            .max_frame_size(most)
    }
}

/// Play with a twin
pub(super) async fn play(State(app): State<App>, Id(id): Id, upgrade: Upgrade) -> Result<Response> {
    let twin = app.twin_to_play(&id).await?;
    let context = Context::current();
    let socket = upgrade.bounded(FIRST_BYTES);
    Ok(socket.on_upgrade(move |socket| context.scope(socket::play(app, twin, socket))))
}

/// Watch a play
pub(super) async fn watch(
    State(app): State<App>,
    Id(id): Id,
    upgrade: Upgrade,
) -> Result<Response> {
    let view = app.watch_play(&id).await?;
    let context = Context::current();
    let socket = upgrade.bounded(WATCHER_BYTES);
    Ok(socket.on_upgrade(move |socket| context.scope(socket::watch(app, view, socket))))
}

/// Recording of a play
pub(super) async fn recording(State(app): State<App>, Id(id): Id) -> Result<Response> {
    let play = app.play(&id).await?;
    let recording = play.recording().map_err(Error::from)?;
    let held = app.reply_memory(recording.document_bytes()).await?;
    let (twin, frame_s) = (play.twin(), play.frame_s());
    let written = tokio::task::spawn_blocking(move || recording.write(twin, frame_s)).await;
    let text = written
        .map_err(|e| Error::Internal(format!("writing a recording: {e}")))?
        .map_err(|e| Error::Internal(format!("a recording that cannot be written: {e}")))?;
    let body = bendtwin_budget::held(text.into(), held);
    Ok(([(header::CONTENT_TYPE, "application/json")], body).into_response())
}

/// Put a recording
pub(super) async fn put_recording(
    State(app): State<App>,
    Id(id): Id,
    request: Request,
) -> Result<StatusCode> {
    let play = app.play(&id).await?;
    extract::expect_type(request.headers(), &["application/json"])?;
    let most = app.options().limits.rollout.json_bytes;
    let received = extract::whole(&app, request, Kind::Json, most, |_| Ok(())).await?;
    let twin = play.twin();
    let read = tokio::task::spawn_blocking(move || {
        let document = extract::json::<Document>(&received.bytes)?;
        Ok::<_, Refusal>(Recording::read(document, twin).map_err(Error::from)?)
    });
    let recording =
        read.await.map_err(|e| Error::Internal(format!("reading a recording: {e}")))??;
    play.set_recording(recording);
    Ok(StatusCode::NO_CONTENT)
}

/// Time in which the first message has to come, and in which a browser has to take what it is sent
/// or to say something.
const PATIENCE: Duration = Duration::from_secs(30);
