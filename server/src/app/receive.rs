//! Receiving content over any transport: streamed to disk, bounded in size, abandoned after a
//! silence. A broken upload leaves nothing behind.

use std::error::Error as StdError;

use bendtwin_contract::rollout;
use bendtwin_store::{Digest, Staged};
use bytes::Bytes;
use futures::{StreamExt, stream::BoxStream};
use hyper::body::Body as HttpBody;

use super::{App, Error, Result};
use crate::memory::{Kind, ReceiveError, Received};

/// The chunks of an upload; an error describes how the transport broke.
pub(crate) type Body = BoxStream<'static, Result<Bytes>>;

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

    /// Receives a body of at most `limit` bytes. `tap` sees every chunk.
    pub(super) async fn receive(
        &self,
        mut body: Body,
        limit: u64,
        expected: Option<Digest>,
        mut tap: impl FnMut(&Bytes),
    ) -> Result<Staged> {
        let idle = self.options.limits.upload_idle();
        let mut upload = self.store.blobs().upload(limit).await?;
        loop {
            match tokio::time::timeout(idle, body.next()).await {
                Err(_) => return Err(Error::UploadIdle(idle)),
                Ok(None) => break,
                Ok(Some(chunk)) => {
                    let chunk = chunk?;
                    tap(&chunk);
                    upload.write(chunk).await.inspect_err(|error| self.write_failed(error))?;
                }
            }
        }
        Ok(upload.finish(expected).await.inspect_err(|error| self.write_failed(error))?)
    }
}
