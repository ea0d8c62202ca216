//! The WebSockets of a play. A reader that is slow is sent the newest state once it has drawn those
//! that are on their way, so that none waits in any buffer.

use std::{sync::Arc, time::Duration};

use axum::extract::ws::{CloseFrame, Message as Frame, WebSocket, close_code};
use bendtwin_core::ids::TwinId;
use bendtwin_play::{self as plays, Begin, Error as PlayError, Message, Player, View};
use tokio::{
    sync::watch,
    time::{Instant, MissedTickBehavior},
};

use super::PATIENCE;
use crate::{
    app::{App, Error},
    context::Context,
    refusal::Refusal,
};

/// States on their way that the browser has not drawn.
const ON_THEIR_WAY: usize = 8;
/// Longest message after the first one [bytes].
const MESSAGE_BYTES: usize = 64 << 10;
/// Messages accepted in a second, and in a burst.
const RATE: f64 = 200.0;
const BURST: f64 = 400.0;
/// Time for the browser to take the last message.
const LAST_WORDS: Duration = Duration::from_secs(2);
const PING_INTERVAL: Duration = Duration::from_secs(10);

/// End of a socket: nothing more can be said.
struct Gone;

/// An event of a socket.
enum Event {
    Reply(Arc<str>),
    Ended,
    /// `None` if the browser has gone.
    Heard(Option<Frame>),
    Facts,
    State,
    Ping,
    /// The key of the browser is not valid any more.
    Refused(Error),
}

/// A browser that plays.
pub(super) async fn play(app: App, twin: TwinId, mut socket: WebSocket) {
    let begun = match tokio::time::timeout(PATIENCE, first(&mut socket)).await {
        Err(_) => Err(Error::invalid("message", "has not come: send {\"type\": \"begin\"} first")),
        Ok(None) => return,
        Ok(Some(begin)) => begin,
    };
    let player = match begun {
        Ok(begin) => {
            // One that goes away while a session is opened leaves it to its idle time.
            app.begin_play(twin, begin, problem).await
        }
        Err(error) => Err(error),
    };
    match player {
        Ok(player) => {
            let view = player.view();
            Channel::new(app, socket, view).run(Some(player)).await;
        }
        Err(error) => {
            let text = plays::ended(Some(problem(error, &Context::current())));
            let _ = send(&mut socket, Frame::Text(text.into())).await;
            farewell(&mut socket, close_code::POLICY, "refused").await;
        }
    }
}

/// A browser that watches.
pub(super) async fn watch(app: App, view: View, socket: WebSocket) {
    Channel::new(app, socket, view).run(None).await;
}

/// The first message of one that plays; none if it has gone.
async fn first(socket: &mut WebSocket) -> Option<Result<Begin, Error>> {
    loop {
        return match socket.recv().await? {
            Ok(Frame::Text(text)) => {
                let fault = |e| Error::invalid("message", format!("is no beginning: {e}"));
                Some(serde_json::from_str(&text).map_err(fault))
            }
            Ok(Frame::Ping(_) | Frame::Pong(_)) => continue,
            Ok(Frame::Binary(_)) => Some(Err(Error::invalid("message", "is not a text"))),
            Ok(Frame::Close(_)) | Err(_) => None,
        };
    }
}

/// A side of a play's socket.
struct Channel {
    app: App,
    socket: WebSocket,
    view: View,
    /// Numbers of states that were sent and not drawn.
    on_their_way: Vec<u32>,
    heard: Instant,
    allowance: f64,
    counted: Instant,
}

impl Channel {
    fn new(app: App, socket: WebSocket, view: View) -> Self {
        let now = Instant::now();
        let on_their_way = Vec::with_capacity(ON_THEIR_WAY);
        Self { app, socket, view, on_their_way, heard: now, allowance: BURST, counted: now }
    }

    /// Passes messages on until either side ends.
    async fn run(mut self, mut player: Option<Player>) {
        let _ = self.pass(&mut player).await;
    }

    async fn pass(&mut self, player: &mut Option<Player>) -> Result<(), Gone> {
        let ready = self.view.ready().to_owned();
        send(&mut self.socket, Frame::Text(ready.into())).await?;
        self.view.states.mark_changed();
        self.view.facts.mark_changed();
        let mut stopping = Box::pin(self.app.stopped());
        let app = self.app.clone();
        let mut refused = std::pin::pin!(app.key_ended());
        let mut ping = tokio::time::interval(PING_INTERVAL);
        ping.set_missed_tick_behavior(MissedTickBehavior::Delay);
        loop {
            let has_room = self.on_their_way.len() < ON_THEIR_WAY;
            let event = tokio::select! {
                biased;
                reply = reply(player) => Event::Reply(reply),
                () = ended(&mut self.view.farewell) => Event::Ended,
                error = &mut refused => Event::Refused(error),
                () = &mut stopping, if player.is_none() => Event::Ended,
                frame = self.socket.recv() => Event::Heard(frame.and_then(Result::ok)),
                Ok(()) = self.view.facts.changed() => Event::Facts,
                Ok(()) = self.view.states.changed(), if has_room => Event::State,
                _ = ping.tick() => Event::Ping,
            };
            if !self.take(event, player.as_ref()).await? {
                return Ok(());
            }
        }
    }

    /// Does what an event asks for. False at the end.
    async fn take(&mut self, event: Event, player: Option<&Player>) -> Result<bool, Gone> {
        match event {
            Event::Reply(reply) => self.text(&reply).await?,
            Event::Ended => {
                let text = self.view.farewell.borrow().clone();
                self.leave(text).await?;
                return Ok(false);
            }
            Event::Heard(None) => return Ok(false),
            Event::Heard(Some(frame)) => return self.heard(frame, player).await,
            Event::Facts => {
                let facts = Arc::clone(&self.view.facts.borrow_and_update());
                if !facts.is_empty() {
                    self.text(&facts).await?;
                }
            }
            Event::State => {
                let state = self.view.states.borrow_and_update().clone();
                if let Some(number) = state.get(4..8).and_then(|n| n.try_into().ok()) {
                    self.on_their_way.push(u32::from_le_bytes(number));
                    send(&mut self.socket, Frame::Binary(state)).await?;
                }
            }
            Event::Refused(error) => {
                let text = plays::ended(Some(problem(error, &Context::current())));
                self.leave(Some(text.into())).await?;
                return Ok(false);
            }
            Event::Ping => {
                if self.heard.elapsed() > PATIENCE {
                    return Ok(false);
                }
                send(&mut self.socket, Frame::Ping(axum::body::Bytes::new())).await?;
            }
        }
        Ok(true)
    }

    /// Takes in a message. False if the browser has gone, or is not heard any more.
    async fn heard(&mut self, frame: Frame, player: Option<&Player>) -> Result<bool, Gone> {
        self.heard = Instant::now();
        let taken = match frame {
            Frame::Close(_) => return Ok(false),
            _ if !self.may_speak() => Err(PlayError::TooFast),
            Frame::Ping(_) | Frame::Pong(_) => return Ok(true),
            Frame::Binary(_) => Err(PlayError::invalid("message", "is not a text")),
            Frame::Text(text) if text.len() > MESSAGE_BYTES => {
                let fault = format!("is longer than {MESSAGE_BYTES} bytes");
                Err(PlayError::invalid("message", fault))
            }
            Frame::Text(text) => match plays::read(&text) {
                Ok(Message::Seen { frame }) => {
                    self.on_their_way.retain(|number| *number > frame);
                    return Ok(true);
                }
                Ok(message) => match player {
                    Some(player) => player.inbox.push(message),
                    None => Err(PlayError::invalid("message", "moves something: this is to watch")),
                },
                Err(error) => Err(error),
            },
        };
        match taken {
            Ok(()) => Ok(true),
            Err(error @ PlayError::TooFast) => {
                let text = plays::ended(Some(problem(error.into(), &Context::current())));
                self.leave(Some(text.into())).await?;
                Ok(false)
            }
            Err(error) => {
                self.text(&plays::refused(problem(error.into(), &Context::current()))).await?;
                Ok(true)
            }
        }
    }

    /// Counts a message. False if there are too many.
    fn may_speak(&mut self) -> bool {
        let now = Instant::now();
        let earned = RATE * now.duration_since(self.counted).as_secs_f64();
        (self.allowance, self.counted) = ((self.allowance + earned).min(BURST) - 1.0, now);
        self.allowance >= 0.0
    }

    async fn text(&mut self, text: &str) -> Result<(), Gone> {
        send(&mut self.socket, Frame::Text(text.into())).await
    }

    async fn leave(&mut self, text: Option<Arc<str>>) -> Result<(), Gone> {
        if let Some(text) = text {
            self.text(&text).await?;
        }
        farewell(&mut self.socket, close_code::AWAY, "the play has ended").await;
        Ok(())
    }
}

/// The next answer to one that plays. After the last one its farewell comes, by another way.
async fn reply(player: &mut Option<Player>) -> Arc<str> {
    if let Some(player) = player
        && let Some(reply) = player.replies.recv().await
    {
        return reply;
    }
    std::future::pending().await
}

/// Waits for the end of a play.
async fn ended(farewell: &mut watch::Receiver<Option<Arc<str>>>) {
    // A play that is dropped without a farewell has ended as well.
    let _ = farewell.wait_for(Option::is_some).await;
}

/// Sends, unless nobody reads.
async fn send(socket: &mut WebSocket, frame: Frame) -> Result<(), Gone> {
    match tokio::time::timeout(PATIENCE, socket.send(frame)).await {
        Ok(Ok(())) => Ok(()),
        _ => Err(Gone),
    }
}

async fn farewell(socket: &mut WebSocket, code: u16, reason: &'static str) {
    let frame = CloseFrame { code, reason: reason.into() };
    let _ = send(socket, Frame::Close(Some(frame))).await;
    // What was not read would make the system cut the connection before the farewell has arrived.
    let rest = async { while let Some(Ok(_)) = socket.recv().await {} };
    let _ = tokio::time::timeout(LAST_WORDS, rest).await;
}

/// The document that shows an error to the client.
fn problem(error: Error, context: &Context) -> serde_json::Value {
    Refusal::from(error).json(context)
}
