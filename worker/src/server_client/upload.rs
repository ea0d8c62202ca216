//! Content as a stream of messages: metadata first, then chunks.

use bytes::Bytes;
use futures::{Stream, stream};

/// Bytes of one chunk: large enough to be cheap, well below any message limit.
const CHUNK: usize = 256 << 10;

/// The messages of an upload. Slices share the content's memory.
pub(super) fn parts<M: Send + 'static>(
    metadata: M,
    content: Bytes,
    chunk: impl Fn(Bytes) -> M + Send + 'static,
) -> impl Stream<Item = M> + Send + 'static {
    let chunks = (0..content.len()).step_by(CHUNK).map(move |start| {
        let end = (start + CHUNK).min(content.len());
        chunk(content.slice(start..end))
    });
    stream::iter(std::iter::once(metadata).chain(chunks))
}
