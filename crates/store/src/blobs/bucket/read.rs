//! Reading an object: range by range, so that every request is short, a slow reader holds no
//! connection, and one that fails is repeated alone.

use std::{ops::Range, sync::Arc};

use bytes::Bytes;
use futures::{StreamExt as _, TryStreamExt as _, stream};
use object_store::{ObjectStoreExt as _, path::Path};

use super::{Bucket, found};
use crate::{
    Error, Result,
    blobs::{CHUNK, place::ObjectReader},
};

/// Bytes of one request.
const RANGE: u64 = 4 << 20;
/// Requests ahead of the reader.
const AHEAD: usize = 2;

impl Bucket {
    /// Opens an object, or a range of it; none if it is not there.
    pub(in crate::blobs) async fn read(
        self: &Arc<Self>,
        path: &Path,
        range: Option<Range<u64>>,
    ) -> Result<Option<ObjectReader>> {
        let Some(size_bytes) = self.size(path).await? else { return Ok(None) };
        let Range { start, end } = range.unwrap_or(0..size_bytes);
        if start >= size_bytes && start < end {
            let outside = std::io::Error::new(std::io::ErrorKind::InvalidInput, "outside");
            return Err(outside.into());
        }
        let end = end.min(size_bytes);
        let ranges = (start..end).step_by(RANGE as usize);
        let (bucket, path) = (self.clone(), path.clone());
        let pieces = stream::iter(ranges).map(move |from| {
            let (bucket, path) = (bucket.clone(), path.clone());
            async move { bucket.range(&path, from..end.min(from + RANGE)).await }
        });
        let chunks = pieces.buffered(AHEAD).map_ok(|piece| stream::iter(split(piece)).map(Ok));
        Ok(Some(ObjectReader { size_bytes, chunks: chunks.try_flatten().boxed() }))
    }

    /// Bytes of an object.
    pub(crate) async fn range(&self, path: &Path, range: Range<u64>) -> Result<Bytes> {
        let wanted = range.end - range.start;
        let path = self.full(path);
        let got = self.ask("read", self.store.get_range(&path, range)).await;
        match found(got)? {
            Some(bytes) if bytes.len() as u64 == wanted => Ok(bytes),
            // It is another than a moment ago.
            _ => Err(Error::ObjectsUnavailable),
        }
    }
}

fn split(mut piece: Bytes) -> Vec<Bytes> {
    let mut chunks = Vec::with_capacity(piece.len() / CHUNK + 1);
    while piece.len() > CHUNK {
        chunks.push(piece.split_to(CHUNK));
    }
    chunks.push(piece);
    chunks
}
