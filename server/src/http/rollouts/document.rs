//! A reply as JSON, whole or as server-sent events. Numbers take many times the time and the room of
//! their bytes, so all but small replies are written beside the tasks of the runtime, in chunks, as
//! fast as the client reads.

use std::{
    io::{self, BufWriter, Write as _},
    time::Duration,
};

use axum::{
    body::Body,
    http::header,
    response::{IntoResponse, Response},
};
use bendtwin_proto::{
    json::{TensorFormat, Write},
    v1::RollOutResponse,
};
use bytes::Bytes;
use futures::StreamExt as _;
use prost::Message;
use serde::Serialize;
use tokio::sync::mpsc;
use tokio_stream::wrappers::ReceiverStream;

use crate::{
    app::{self, Error, Parts, ReplyHold},
    context::Context,
    refusal::Refusal,
};

/// Replies up to this size are written in place [bytes, as protobuf].
const SMALL: usize = 16 << 10;
/// Bytes of a chunk.
const CHUNK: usize = 64 << 10;
/// Chunks that wait for the client.
const WAITING_CHUNKS: usize = 2;

/// Time after which a comment says that the stream lives.
const KEEP_ALIVE: Duration = Duration::from_secs(15);

const EVENTS: [(header::HeaderName, &str); 2] =
    [(header::CONTENT_TYPE, "text/event-stream"), (header::CACHE_CONTROL, "no-cache")];
const TYPE: [(header::HeaderName, &str); 1] = [(header::CONTENT_TYPE, "application/json")];

/// The answer. What the reply holds, its memory and its place in the worker's line, is given back
/// when the client has read it or has gone.
pub(in crate::http) fn answer<M, H>(
    response: M,
    held: H,
    tensors: TensorFormat,
) -> app::Result<Response>
where
    M: Message + 'static,
    H: Send + Sync + 'static,
    for<'m> Write<'m, M>: Serialize,
{
    if response.encoded_len() <= SMALL {
        let json = serde_json::to_vec(&Write { message: &response, tensors })
            .map_err(|e| Error::Internal(format!("a reply that cannot be written as JSON: {e}")))?;
        return Ok((TYPE, json).into_response());
    }
    let (sender, chunks) = mpsc::channel(WAITING_CHUNKS);
    tokio::task::spawn_blocking(move || {
        let mut writer = BufWriter::with_capacity(CHUNK, Chunks(sender));
        let written = serde_json::to_writer(&mut writer, &Write { message: &response, tensors });
        let written = written.map_err(io::Error::from).and_then(|()| writer.flush());
        if let Err(error) = written
            && error.kind() != io::ErrorKind::BrokenPipe
        {
            tracing::error!(%error, "a reply that cannot be written as JSON");
            // The client must not take what has come for the whole.
            let Chunks(sender) = writer.get_mut();
            let _ = sender.blocking_send(Err(error));
        }
    });
    let chunks = ReceiverStream::new(chunks).map(move |chunk| {
        let _held = &held;
        chunk
    });
    Ok((TYPE, Body::from_stream(chunks)).into_response())
}

/// The parts of a reply as events, written as they come; what the client does not read is not
/// computed. What the reply holds is given back when the client has read it or has gone.
pub(in crate::http) fn events(parts: Parts, held: ReplyHold, tensors: TensorFormat) -> Response {
    let (sender, chunks) = mpsc::channel(WAITING_CHUNKS);
    let context = Context::current();
    tokio::spawn(send(parts, tensors, context, sender));
    let chunks = ReceiverStream::new(chunks).map(move |chunk| {
        let _held = &held;
        chunk
    });
    (EVENTS, Body::from_stream(chunks)).into_response()
}

/// Sends parts until the last, a failure, or the client's end.
async fn send(
    mut parts: Parts,
    tensors: TensorFormat,
    context: Context,
    sender: mpsc::Sender<io::Result<Bytes>>,
) {
    loop {
        let next = tokio::select! {
            next = tokio::time::timeout(KEEP_ALIVE, parts.next()) => next,
            () = sender.closed() => return,
        };
        let sent = match next {
            Err(_) => sender.send(Ok(Bytes::from_static(b":\n\n"))).await.is_ok(),
            Ok(None) => return,
            Ok(Some(Ok(part))) => {
                let sender = sender.clone();
                let write = move || write_part(&part, tensors, sender);
                tokio::task::spawn_blocking(write).await.is_ok_and(|written| written.is_ok())
            }
            Ok(Some(Err(error))) => {
                let document = Refusal::from(error).document(&context);
                let text = serde_json::to_string(&document).unwrap_or_default();
                let event = format!("event: error\ndata: {text}\n\n");
                let _ = sender.send(Ok(event.into())).await;
                return;
            }
        };
        if !sent {
            return;
        }
    }
}

/// Writes an event; compact JSON is a single line.
fn write_part(
    part: &RollOutResponse,
    tensors: TensorFormat,
    sender: mpsc::Sender<io::Result<Bytes>>,
) -> io::Result<()> {
    let mut writer = BufWriter::with_capacity(CHUNK, Chunks(sender));
    writer.write_all(b"event: part\ndata: ")?;
    serde_json::to_writer(&mut writer, &Write { message: part, tensors })?;
    writer.write_all(b"\n\n")?;
    writer.flush()
}

/// Writes to the body.
struct Chunks(mpsc::Sender<io::Result<Bytes>>);

impl io::Write for Chunks {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let chunk = &bytes[..bytes.len().min(CHUNK)];
        let sent = self.0.blocking_send(Ok(Bytes::copy_from_slice(chunk)));
        sent.map_err(|_| io::Error::from(io::ErrorKind::BrokenPipe))?;
        Ok(chunk.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}
