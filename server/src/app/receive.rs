//! Receiving content over any transport: streamed to disk, bounded in size and by the quota of its
//! owner, abandoned after a silence. A broken upload leaves nothing behind.

use std::error::Error as StdError;

use bendtwin_contract::rollout;
use bendtwin_store::{Digest, Incoming, Staged};
use bytes::Bytes;
use futures::{StreamExt, stream::BoxStream};
use hyper::body::Body as HttpBody;

use super::{App, Error, Result};
use crate::{
    context::Context,
    memory::{Kind, ReceiveError, Received},
};

/// The body of an upload.
pub(crate) struct Body {
    /// Chunks of the body; an error describes how the transport broke.
    pub(crate) chunks: BoxStream<'static, Result<Bytes>>,
    /// Size of the body, if the transport declares it [bytes].
    pub(crate) size_bytes: Option<u64>,
}

/// The way in which content is received.
pub(super) enum Receiving {
    /// A result of a worker, of at most this number of bytes: it is stored beyond the quota of its
    /// owner, too.
    Result(u64),
    /// Content of the caller, for which there has to be room in the caller's quota.
    Upload {
        /// Number of jobs that it makes.
        jobs: u64,
        /// Most that is accepted [bytes].
        limit: u64,
        /// True if a resource was made under its request id before: then it is compared alone.
        is_repetition: bool,
    },
}

impl App {
    /// Receives a body of at most `limit` bytes that is kept in memory. `look` sees its beginning,
    /// as far as it has come, and may refuse it before the rest is sent.
    pub(crate) async fn receive_whole<B>(
        &self,
        body: B,
        kind: Kind,
        limit: u64,
        look: impl Fn(&[u8]) -> Result<(), rollout::Error>,
    ) -> Result<Received, ReceiveError>
    where
        B: HttpBody<Data = Bytes> + Unpin,
        B::Error: Into<Box<dyn StdError + Send + Sync>>,
    {
        self.memory.receive(body, kind, limit, look).await
    }

    /// Receives the message of a gRPC call, as [`Memory::receive_message`](crate::memory::Memory).
    pub(crate) async fn receive_message<B>(
        &self,
        body: B,
        limit: u64,
        look: impl Fn(&[u8]) -> Result<(), rollout::Error>,
    ) -> Result<Received, ReceiveError>
    where
        B: HttpBody<Data = Bytes> + Unpin,
        B::Error: Into<Box<dyn StdError + Send + Sync>>,
    {
        self.memory.receive_message(body, limit, look).await
    }

    /// Receives the body of an upload, unless it is too large or its owner has no room for it.
    pub(super) async fn receive(
        &self,
        body: Body,
        receiving: Receiving,
        expected: Option<Digest>,
    ) -> Result<Staged> {
        let Body { mut chunks, size_bytes } = body;
        let idle = self.options.limits.upload_idle();
        let mut upload = match receiving {
            Receiving::Result(limit) => self.store.blobs().upload(limit).await?,
            Receiving::Upload { jobs, limit, is_repetition } => {
                let creator = Context::current().caller.creator();
                let silence = idle;
                let incoming =
                    Incoming { creator, jobs, size_bytes, limit, silence, is_repetition };
                self.store.receive(incoming).await?
            }
        };
        loop {
            match tokio::time::timeout(idle, chunks.next()).await {
                Err(_) => return Err(Error::UploadIdle(idle)),
                Ok(None) => break,
                Ok(Some(chunk)) => {
                    upload.write(chunk?).await.inspect_err(|error| self.write_failed(error))?;
                }
            }
        }
        Ok(upload.finish(expected).await.inspect_err(|error| self.write_failed(error))?)
    }
}
