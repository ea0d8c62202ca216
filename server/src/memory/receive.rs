//! Bodies that are held in memory. Their memory is taken before they are read: all of it where the
//! length is declared, else in steps.

use std::sync::Arc;

use axum::body::HttpBody;
use bendtwin_contract::rollout;
use bytes::{Buf as _, Bytes, BytesMut};
use http_body_util::BodyExt as _;

use super::{Memory, Received, Shares};
use crate::error::Error;

/// First step of a body of unknown length [bytes].
const FIRST_STEP: u64 = 64 << 10;
/// Bytes before a message of gRPC: whether it is compressed, and its length in 4 bytes.
pub(crate) const GRPC_PREFIX: usize = 5;
/// The beginning of a message, which is checked while the rest is arriving [bytes].
const BEGINNING: usize = 64 << 10;
/// Memory of a body and of what is decoded from it, in times its length: a text of JSON becomes
/// tensors of twice its length, whose buffers grow by doubling.
const JSON: u64 = 8;
/// Protobuf: the bytes, which tensors share, and the message to the worker, whose buffer may be
/// twice as long.
pub(super) const PROTOBUF: u64 = 3;
/// Ordinary documents.
const DOCUMENT: u64 = 1;

/// Form of a body.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    /// A rollout in JSON.
    Json,
    /// A rollout in protobuf.
    Protobuf,
    /// A JSON document of ordinary size.
    Document,
}

/// A body that was not received.
#[derive(Debug)]
pub(crate) enum ReceiveError {
    /// Longer than the limit.
    TooLong,
    /// Not enough memory.
    Memory(Error),
    /// Broken off.
    Broken(axum::Error),
    /// The beginning is refused.
    Refused(rollout::Error),
}

impl Kind {
    fn factor(self) -> u64 {
        match self {
            Self::Json => JSON,
            Self::Protobuf => PROTOBUF,
            Self::Document => DOCUMENT,
        }
    }
}

impl Memory {
    /// Receives a body of at most `limit` bytes. `look` sees its beginning, as far as it has come, and
    /// may refuse it before the rest is sent.
    pub(crate) async fn receive<B>(
        &self,
        body: B,
        kind: Kind,
        limit: u64,
        look: impl Fn(&[u8]) -> Result<(), rollout::Error>,
    ) -> Result<Received, ReceiveError>
    where
        B: HttpBody<Data = Bytes> + Unpin,
        B::Error: Into<axum::BoxError>,
    {
        let mut buffer = Buffer::new(self, kind, limit);
        if let Some(declared) = body.size_hint().exact() {
            buffer.reserve(declared, true).await?;
        }
        buffer.fill(body, |_| None, look).await?;
        Ok(buffer.received())
    }

    /// Receives the first message of a gRPC call, prefix included. One that is longer than `limit`,
    /// or compressed, is left to the service, which refuses it by its prefix. `look` sees the beginning
    /// of the message, as that of a body.
    pub(crate) async fn receive_message<B>(
        &self,
        body: B,
        limit: u64,
        look: impl Fn(&[u8]) -> Result<(), rollout::Error>,
    ) -> Result<Received, ReceiveError>
    where
        B: HttpBody<Data = Bytes> + Unpin,
        B::Error: Into<axum::BoxError>,
    {
        let most = limit.saturating_add(GRPC_PREFIX as u64);
        let mut buffer = Buffer::new(self, Kind::Protobuf, most);
        let whole = |bytes: &[u8]| {
            let mut prefix = bytes.get(..GRPC_PREFIX)?;
            let flag = prefix.get_u8();
            let length = u64::from(prefix.get_u32()) + GRPC_PREFIX as u64;
            Some(if flag == 0 && length <= most { length } else { GRPC_PREFIX as u64 })
        };
        let look = |bytes: &[u8]| match bytes.split_at_checked(GRPC_PREFIX) {
            Some((&[0, ..], message)) => look(message),
            _ => Ok(()),
        };
        buffer.fill(body, whole, look).await?;
        Ok(buffer.received())
    }
}

/// Bytes as they come, and the memory that they have.
struct Buffer<'m> {
    memory: &'m Memory,
    kind: Kind,
    limit: u64,
    shares: Shares,
    bytes: BytesMut,
    /// Length for which there is memory.
    room: u64,
}

impl<'m> Buffer<'m> {
    fn new(memory: &'m Memory, kind: Kind, limit: u64) -> Self {
        Self { memory, kind, limit, shares: Shares::default(), bytes: BytesMut::new(), room: 0 }
    }

    /// Reserves memory for a length: exactly that if it is the whole, else some more.
    async fn reserve(&mut self, length: u64, is_whole: bool) -> Result<(), ReceiveError> {
        if length > self.limit {
            return Err(ReceiveError::TooLong);
        }
        if length <= self.room {
            return Ok(());
        }
        let step = if is_whole { 0 } else { self.room.saturating_mul(2).max(FIRST_STEP) };
        let room = length.max(step).min(self.limit);
        let bytes = (room - self.room).saturating_mul(self.kind.factor());
        let advice = "the body: send a smaller one";
        let memory = self.memory;
        let share =
            memory.take(&memory.bodies, bytes, advice).await.map_err(ReceiveError::Memory)?;
        self.shares.add(share);
        self.bytes.reserve(usize::try_from(room).unwrap_or(usize::MAX) - self.bytes.len());
        self.room = room;
        Ok(())
    }

    /// Reads a body to its end, or to the length that `whole` finds in its beginning, unless `look`
    /// refuses that.
    async fn fill<B>(
        &mut self,
        mut body: B,
        whole: impl Fn(&[u8]) -> Option<u64>,
        look: impl Fn(&[u8]) -> Result<(), rollout::Error>,
    ) -> Result<(), ReceiveError>
    where
        B: HttpBody<Data = Bytes> + Unpin,
        B::Error: Into<axum::BoxError>,
    {
        while let Some(frame) = body.frame().await {
            let frame = frame.map_err(|e| ReceiveError::Broken(axum::Error::new(e)))?;
            let Ok(mut chunk) = frame.into_data() else { continue };
            let seen = self.bytes.len();
            while !chunk.is_empty() {
                // The length is known from the first bytes.
                let ahead = if self.bytes.len() < GRPC_PREFIX {
                    GRPC_PREFIX - self.bytes.len()
                } else {
                    chunk.len()
                };
                let part = chunk.split_to(ahead.min(chunk.len()));
                self.reserve((self.bytes.len() + part.len()) as u64, false).await?;
                self.bytes.extend_from_slice(&part);
                if let Some(length) = whole(&self.bytes) {
                    if self.bytes.len() as u64 >= length {
                        self.bytes.truncate(usize::try_from(length).unwrap_or(usize::MAX));
                        return Ok(());
                    }
                    self.reserve(length, true).await?;
                }
            }
            if seen < BEGINNING {
                let beginning = &self.bytes[..self.bytes.len().min(BEGINNING)];
                look(beginning).map_err(ReceiveError::Refused)?;
            }
        }
        Ok(())
    }

    fn received(self) -> Received {
        Received { bytes: self.bytes.freeze(), memory: Arc::new(self.shares) }
    }
}
