//! Watching a job through lost connections and server restarts.

use std::{
    marker::PhantomData,
    pin::Pin,
    task::{Context, Poll},
    time::{Duration, Instant},
};

use futures::{Stream, StreamExt as _, future::BoxFuture, stream::BoxStream};
use tonic::{Status, Streaming};

use crate::{Capture, Error, Fit};

/// Longest time for which a server may be unreachable.
const RECONNECT_TIMEOUT: Duration = Duration::from_secs(60);
/// Time between two attempts to reach it.
const RETRY_INTERVAL: Duration = Duration::from_millis(500);

/// The states of a job, from now until it has ended: of a [`Fit`], or of a [`Capture`] that is
/// being read.
pub struct Watch<T = Fit>(BoxStream<'static, Result<T, Error>>);

impl<T> std::fmt::Debug for Watch<T> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("Watch")
    }
}

impl<T> Stream for Watch<T> {
    type Item = Result<T, Error>;

    fn poll_next(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<Option<Self::Item>> {
        self.0.poll_next_unpin(context)
    }
}

impl<T: Send + 'static> Watch<T> {
    /// Waits for the end; returns the last state.
    pub(crate) async fn last(mut self) -> Result<T, Error> {
        let mut last = None;
        while let Some(state) = self.next().await {
            last = Some(state?);
        }
        last.ok_or_else(|| Error::malformed("the server ended the watch without a state"))
    }
}

/// A resource with revisions and a final state.
pub(crate) trait Revisioned: Send + 'static {
    fn revision(&self) -> u64;
    fn has_ended(&self) -> bool;
}

impl Revisioned for Fit {
    fn revision(&self) -> u64 {
        self.job.revision
    }
    fn has_ended(&self) -> bool {
        self.job.state.has_ended()
    }
}

impl Revisioned for Capture {
    fn revision(&self) -> u64 {
        self.ingest.revision
    }
    fn has_ended(&self) -> bool {
        self.ingest.state.has_ended()
    }
}

/// Opens the stream of revisions after one.
type Open<W> = Box<dyn Fn(u64) -> BoxFuture<'static, Result<Streaming<W>, Status>> + Send>;

/// State of a watch.
struct WatchState<T, W> {
    open: Open<W>,
    after_revision: u64,
    stream: Option<Streaming<W>>,
    /// Start of the silence, if the server cannot be reached.
    silent_since: Option<Instant>,
    ended: bool,
    item: PhantomData<fn() -> T>,
}

/// A watch that opens its streams with `open`.
pub(crate) fn start<T, W>(
    open: impl Fn(u64) -> BoxFuture<'static, Result<Streaming<W>, Status>> + Send + 'static,
) -> Watch<T>
where
    T: Revisioned + TryFrom<W, Error = Error>,
    W: Send + 'static,
{
    let watch = WatchState {
        open: Box::new(open),
        after_revision: 0,
        stream: None,
        silent_since: None,
        ended: false,
        item: PhantomData,
    };
    Watch(
        futures::stream::unfold(watch, |mut watch| async move {
            let item = watch.next().await?;
            Some((item, watch))
        })
        .boxed(),
    )
}

impl<T: Revisioned + TryFrom<W, Error = Error>, W: Send + 'static> WatchState<T, W> {
    async fn next(&mut self) -> Option<Result<T, Error>> {
        while !self.ended {
            match self.next_message().await {
                Ok(Some(state)) => {
                    self.silent_since = None;
                    self.after_revision = state.revision();
                    self.ended = state.has_ended();
                    return Some(Ok(state));
                }
                // The server closed the stream before the job's end: it shuts down.
                Ok(None) => self.stream = None,
                Err(error) => {
                    self.stream = None;
                    let since = *self.silent_since.get_or_insert_with(Instant::now);
                    if !error.is_transient() || since.elapsed() > RECONNECT_TIMEOUT {
                        self.ended = true;
                        return Some(Err(error));
                    }
                }
            }
            tokio::time::sleep(RETRY_INTERVAL).await;
        }
        None
    }

    async fn next_message(&mut self) -> Result<Option<T>, Error> {
        let stream = match &mut self.stream {
            Some(stream) => stream,
            None => {
                let opened = (self.open)(self.after_revision).await?;
                self.stream.insert(opened)
            }
        };
        stream.message().await?.map(T::try_from).transpose()
    }
}
