//! A browser's side of a play, for tests and benchmarks.

use std::time::Duration;

use futures::{SinkExt as _, StreamExt as _};
use serde_json::{Value, json};
use tokio::net::TcpStream;
use tokio_tungstenite::{
    MaybeTlsStream, WebSocketStream, connect_async, connect_async_with_config,
    tungstenite::{Error, Message},
};

use crate::waiting::within;

/// Longest wait for a message.
const SOON: Duration = Duration::from_secs(60);

/// A socket on a play.
pub struct Play {
    socket: WebSocketStream<MaybeTlsStream<TcpStream>>,
    /// The first message.
    pub ready: Value,
    /// The newest facts.
    pub facts: Value,
    /// Answers and notices until now.
    pub replies: Vec<Value>,
    /// True if states are acknowledged as they come.
    pub draws: bool,
}

/// A state as shown to a browser.
#[derive(Clone, Debug, PartialEq)]
pub struct ShownState {
    /// Bits: paused, recording, replaying, goal.
    pub flags: u8,
    /// Number of the state.
    pub number: u32,
    /// Number of the last input in it.
    pub input: u32,
    /// Largest strain.
    pub strain: f32,
    /// Poses, forces and holds of grippers.
    pub grippers: Vec<[f32; 11]>,
    /// Poses of colliders.
    pub colliders: Vec<[f32; 7]>,
    /// Nodes [m].
    pub nodes: Vec<[f32; 3]>,
    /// Largest error of a coordinate [m].
    pub scale: f32,
}

/// A message of the server.
#[derive(Clone, Debug)]
pub enum Event {
    /// A state.
    Shown(ShownState),
    /// Anything else.
    Message(Value),
    /// The end.
    Closed,
}

/// The reason for which a socket was refused, as its HTTP status.
pub async fn refused(url: &str, path: &str, headers: &[(&'static str, &str)]) -> u16 {
    match connect_async(request(url, path, headers)).await {
        Err(Error::Http(reply)) => reply.status().as_u16(),
        Err(error) => panic!("{error}"),
        Ok(_) => 101,
    }
}

fn request(
    url: &str,
    path: &str,
    headers: &[(&'static str, &str)],
) -> tokio_tungstenite::tungstenite::handshake::client::Request {
    use tokio_tungstenite::tungstenite::client::IntoClientRequest as _;
    let address = format!("ws{}{path}", url.strip_prefix("http").unwrap());
    let mut request = address.into_client_request().unwrap();
    for (name, value) in headers {
        request.headers_mut().insert(*name, value.parse().unwrap());
    }
    request
}

impl Play {
    /// Begins a play of a twin.
    pub async fn begin(url: &str, twin: &str, begin: Value) -> Self {
        let mut play = Self::connect(url, &format!("/v1/{twin}/play"), &[]).await;
        play.send(begin).await;
        play.expect_ready().await;
        play
    }

    /// Watches a play.
    pub async fn watch(url: &str, path: &str) -> Self {
        let mut play = Self::connect(url, path, &[]).await;
        play.expect_ready().await;
        play
    }

    /// Connects, and says nothing.
    pub async fn connect(url: &str, path: &str, headers: &[(&'static str, &str)]) -> Self {
        // As browsers do: small messages wait for nothing.
        let connected = connect_async_with_config(request(url, path, headers), None, true);
        let (socket, _) = connected.await.unwrap();
        let (ready, facts) = (Value::Null, Value::Null);
        Self { socket, ready, facts, replies: Vec::new(), draws: true }
    }

    /// Waits for the first message of the server.
    pub async fn expect_ready(&mut self) {
        match self.next().await {
            Event::Message(message) if message["type"] == "ready" => self.ready = message,
            other => panic!("{other:?}"),
        }
    }

    /// Sends a message.
    pub async fn send(&mut self, message: Value) {
        self.send_text(message.to_string()).await;
    }

    /// Sends a text; if the server has closed, nothing.
    pub async fn send_text(&mut self, text: String) {
        let _ = self.socket.send(Message::text(text)).await;
    }

    /// Sends bytes.
    pub async fn send_bytes(&mut self, bytes: Vec<u8>) {
        let _ = self.socket.send(Message::binary(bytes)).await;
    }

    /// Moves a gripper.
    pub async fn aim(&mut self, input: u32, gripper: usize, position: [f32; 3]) {
        let grippers = json!([{"index": gripper, "position": position}]);
        self.send(json!({"type": "move", "input": input, "grippers": grippers})).await;
    }

    /// The next message.
    pub async fn next(&mut self) -> Event {
        loop {
            let message = within("a message of a play", SOON, self.socket.next()).await;
            match message {
                Some(Ok(Message::Text(text))) => {
                    let message: Value = serde_json::from_str(&text).unwrap();
                    match message["type"].as_str().unwrap() {
                        "facts" => self.facts = message.clone(),
                        _ => self.replies.push(message.clone()),
                    }
                    return Event::Message(message);
                }
                Some(Ok(Message::Binary(bytes))) => {
                    let shown = decode(&bytes);
                    if self.draws {
                        self.send(json!({"type": "seen", "frame": shown.number})).await;
                    }
                    return Event::Shown(shown);
                }
                Some(Ok(Message::Close(_)) | Err(_)) | None => return Event::Closed,
                Some(Ok(_)) => {}
            }
        }
    }

    /// The next state of which something holds.
    pub async fn shown(&mut self, what: &str, holds: impl Fn(&ShownState) -> bool) -> ShownState {
        let found = async {
            loop {
                match self.next().await {
                    Event::Shown(shown) if holds(&shown) => return shown,
                    Event::Closed => panic!("closed before {what}: {:?}", self.replies.last()),
                    _ => {}
                }
            }
        };
        within(what, SOON, found).await
    }

    /// The next text of which something holds.
    pub async fn message(&mut self, what: &str, holds: impl Fn(&Value) -> bool) -> Value {
        let found = async {
            loop {
                match self.next().await {
                    Event::Message(message) if holds(&message) => return message,
                    Event::Closed => panic!("closed before {what}: {:?}", self.replies.last()),
                    _ => {}
                }
            }
        };
        within(what, SOON, found).await
    }

    /// Waits for the end.
    pub async fn closed(&mut self) {
        within("the end of a play", SOON, async {
            while !matches!(self.next().await, Event::Closed) {}
        })
        .await;
    }
}

fn float(bytes: &[u8]) -> f32 {
    f32::from_le_bytes(bytes.try_into().unwrap())
}

fn floats<const N: usize>(bytes: &[u8]) -> [f32; N] {
    std::array::from_fn(|i| float(&bytes[4 * i..4 * i + 4]))
}

/// Reads a state as docs/formats/play.md has it.
pub fn decode(bytes: &[u8]) -> ShownState {
    let word = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap());
    assert_eq!(bytes[0], 1, "the kind of message");
    let (grippers, colliders) = (usize::from(bytes[2]), usize::from(bytes[3]));
    let nodes = word(12) as usize;
    let (origin, scale) = (floats::<3>(&bytes[16..28]), float(&bytes[28..32]));
    let (first, rest) = bytes[36..].split_at(44 * grippers);
    let (second, points) = rest.split_at(28 * colliders);
    assert_eq!(points.len(), 6 * nodes);
    let node = |six: &[u8]| {
        let code = |i: usize| f32::from(i16::from_le_bytes([six[2 * i], six[2 * i + 1]]));
        std::array::from_fn(|i| origin[i] + scale * code(i))
    };
    ShownState {
        flags: bytes[1],
        number: word(4),
        input: word(8),
        strain: float(&bytes[32..36]),
        grippers: first.chunks_exact(44).map(floats).collect(),
        colliders: second.chunks_exact(28).map(floats).collect(),
        nodes: points.chunks_exact(6).map(node).collect(),
        scale,
    }
}
