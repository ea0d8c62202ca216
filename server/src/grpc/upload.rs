//! Uploads over gRPC: one message of metadata, then chunks.

use futures::StreamExt;
use tonic::Streaming;

use crate::app::{Body, Error, Result};

/// Content of one message of an upload.
pub(super) enum Part<M> {
    Metadata(M),
    Chunk(bytes::Bytes),
    Neither,
}

/// Takes the metadata off an upload; the rest is its body.
pub(super) async fn open<T, M>(
    mut stream: Streaming<T>,
    part: impl Fn(T) -> Part<M> + Send + Sync + 'static,
) -> Result<(M, Body)>
where
    T: Send + 'static,
    M: 'static,
{
    let broken = |status: tonic::Status| Error::UploadBroken(status.message().to_owned());
    let first = stream.message().await.map_err(broken)?;
    let Some(Part::Metadata(metadata)) = first.map(&part) else {
        return Err(Error::invalid("metadata", "must come in the first message of an upload"));
    };
    let chunks = stream.map(move |message| match message.map(&part) {
        Ok(Part::Chunk(chunk)) => Ok(chunk),
        Ok(_) => Err(Error::invalid("chunk", "must be in every message after the first")),
        Err(status) => Err(broken(status)),
    });
    Ok((metadata, Body { chunks: chunks.boxed(), size_bytes: None }))
}
