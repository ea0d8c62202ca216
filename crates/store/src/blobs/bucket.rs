//! Content in a bucket of S3, or of a server that speaks its protocol.
//!
//! Every request is retried for some seconds and then given up ([`Error::ObjectsUnavailable`]), so
//! an unreachable bucket delays callers by at most [`PATIENCE`]. Nothing here relies on conditional
//! requests, which not every such server has: objects are named by their digest, so that two
//! writers of one name write the same.

mod connect;
mod http;
mod multipart;
mod read;
mod send;

use std::{future::Future, time::Duration};

use futures::{FutureExt as _, StreamExt as _, TryStreamExt as _, stream::BoxStream};
use object_store::{
    ObjectMeta, ObjectStore as _, ObjectStoreExt as _, PutPayload, aws::AmazonS3, path::Path,
};
use tokio::sync::Semaphore;

use super::PUBLISHED;
use crate::{Error, Result, store::meter::Meter};

pub(crate) use multipart::Multipart;

/// Bytes of a part of an upload. A power of two, so that its hash is a subtree of BLAKE3.
pub(crate) const PART: usize = if cfg!(test) { 256 << 10 } else { 8 << 20 };
/// Longest wait for an answer, all attempts together.
const PATIENCE: Duration = Duration::from_secs(45);
/// Patience for the proof that the bucket answers, and for a deletion.
const SHORT_PATIENCE: Duration = Duration::from_secs(10);
/// Objects sent concurrently from local files; each has parts in memory.
const SENDERS: usize = 4;
/// Name of the object with the identity.
const IDENTITY: &str = "identity";

/// A bucket, or the part of it below a path.
#[derive(Debug)]
pub(crate) struct Bucket {
    store: AmazonS3,
    prefix: Path,
    name: String,
    senders: Semaphore,
    meter: Meter,
}

impl Bucket {
    /// Name in messages.
    pub(crate) fn name(&self) -> &str {
        &self.name
    }

    /// The name of an object in the bucket.
    fn full(&self, path: &Path) -> Path {
        if self.prefix.as_ref().is_empty() {
            return path.clone();
        }
        self.prefix.parts().chain(path.parts()).collect()
    }

    /// The answer to a request, within a bounded time; `operation` is its word in metrics.
    async fn ask<T>(
        &self,
        operation: &'static str,
        request: impl Future<Output = object_store::Result<T>>,
    ) -> Result<T> {
        self.ask_within(PATIENCE, operation, request).await
    }

    async fn ask_within<T>(
        &self,
        patience: Duration,
        operation: &'static str,
        request: impl Future<Output = object_store::Result<T>>,
    ) -> Result<T> {
        let answer = async {
            match tokio::time::timeout(patience, request).await {
                Err(_) => Err(Error::ObjectsUnavailable),
                Ok(answer) => answer.map_err(connect::failed),
            }
        };
        self.meter.measure(operation, answer).await
    }

    /// Writes a small object.
    pub(crate) async fn put(&self, path: &Path, content: impl Into<PutPayload>) -> Result<()> {
        self.ask("write", self.store.put(&self.full(path), content.into())).await.map(drop)
    }

    /// A small object; none if it is not there.
    pub(crate) async fn get(&self, path: &Path) -> Result<Option<bytes::Bytes>> {
        let path = self.full(path);
        let got = async { self.store.get(&path).await?.bytes().await };
        found(self.ask("read", got).await)
    }

    /// Size of an object [bytes]; none if it is not there.
    pub(crate) async fn size(&self, path: &Path) -> Result<Option<u64>> {
        let meta = found(self.ask("read", self.store.head(&self.full(path))).await)?;
        Ok(meta.map(|meta| meta.size))
    }

    /// Removes an object, if it exists.
    pub(crate) async fn delete(&self, path: &Path) -> Result<()> {
        let path = self.full(path);
        found(self.ask_within(SHORT_PATIENCE, "delete", self.store.delete(&path)).await).map(drop)
    }

    /// Removes all objects below a path.
    pub(crate) async fn delete_below(&self, path: &Path) -> Result<()> {
        let below: Vec<ObjectMeta> = self.list(path).try_collect().await?;
        for object in below {
            found(self.ask("delete", self.store.delete(&object.location)).await)?;
        }
        Ok(())
    }

    /// All objects below a path, with their names in the bucket.
    pub(crate) fn list(&self, path: &Path) -> BoxStream<'_, Result<ObjectMeta>> {
        let pages = self.store.list(Some(&self.full(path)));
        futures::stream::unfold(pages, move |mut pages| async move {
            let next = self.ask("list", pages.next().map(Option::transpose)).await.transpose()?;
            // One that ends in silence is not asked again.
            let is_over = matches!(next, Err(Error::ObjectsUnavailable));
            let rest = if is_over { futures::stream::empty().boxed() } else { pages };
            Some((next, rest))
        })
        .boxed()
    }

    /// All published blobs.
    pub(crate) fn published(&self) -> BoxStream<'_, Result<ObjectMeta>> {
        self.list(&Path::from(PUBLISHED))
    }

    pub(crate) async fn any(&self) -> Result<bool> {
        Ok(self.published().try_next().await?.is_some())
    }

    pub(crate) async fn identity(&self) -> Result<Option<String>> {
        let found = self.get(&Path::from(IDENTITY)).await?;
        Ok(found.map(|identity| String::from_utf8_lossy(&identity).trim().to_owned()))
    }

    pub(crate) async fn set_identity(&self, identity: &str) -> Result<()> {
        self.put(&Path::from(IDENTITY), format!("{identity}\n")).await
    }

    /// Writes a small object, in a time that fits into a report of readiness.
    pub(crate) async fn probe(&self) -> Result<()> {
        let path = self.full(&Path::from("probe"));
        let put = self.store.put(&path, PutPayload::from_static(b"probe"));
        self.ask_within(SHORT_PATIENCE, "write", put).await.map(drop)
    }
}

/// `None` in place of the error that an object does not exist.
fn found<T>(answer: Result<T>) -> Result<Option<T>> {
    match answer {
        Err(Error::Objects(object_store::Error::NotFound { .. })) => Ok(None),
        answer => answer.map(Some),
    }
}
