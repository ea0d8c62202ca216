//! A reply as JSON. Numbers take many times the time and the room of their bytes, so all but small
//! replies are written beside the tasks of the runtime, in chunks, as fast as the client reads.

use std::io::{self, BufWriter, Write as _};

use axum::{
    body::Body,
    http::header,
    response::{IntoResponse, Response},
};
use bendtwin_proto::json::{TensorFormat, Write};
use bytes::Bytes;
use futures::StreamExt as _;
use prost::Message;
use serde::Serialize;
use tokio::sync::mpsc;
use tokio_stream::wrappers::ReceiverStream;

use crate::app::{self, Error};

/// Replies up to this size are written at once [bytes, as protobuf].
const SMALL: usize = 16 << 10;
/// Bytes of a chunk.
const CHUNK: usize = 64 << 10;
/// Chunks that wait for the client.
const WAITING_CHUNKS: usize = 2;

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
