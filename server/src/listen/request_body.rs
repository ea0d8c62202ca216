//! Bodies of requests under time limits: a client that declares a body has to send it. A body with
//! an unread rest is read for a while, because a client that is still sending would see a broken
//! connection in place of the response.

use std::{
    pin::Pin,
    sync::Arc,
    task::{Context, Poll},
    time::Duration,
};

use axum::body::Body;
use bytes::Bytes;
use http_body_util::BodyExt as _;
use hyper::body::{Body as HttpBody, Frame, Incoming, SizeHint};
use tokio::time::{Instant, Sleep};

use super::activity::{Exchange, Turn};

/// Least rate of a body over the time spent waiting for it [bytes/s]; the time limit of a silence
/// comes on top.
const LEAST_RATE: u64 = 1024;
/// Most that is read of a body that is not wanted [bytes], and the longest time for that.
const DRAIN_BYTES: u64 = 16 << 20;
const DRAIN_TIME: Duration = Duration::from_secs(5);

/// A body that did not arrive in time.
#[derive(Debug, thiserror::Error)]
#[error("the body came too slowly")]
pub(crate) struct TooSlow;

/// Finds [`TooSlow`] among the causes of an error.
pub(crate) fn is_too_slow(error: &(dyn std::error::Error + 'static)) -> bool {
    std::iter::successors(Some(error), |e| e.source()).any(|e| e.is::<TooSlow>())
}

/// A body being received.
struct RequestBody {
    /// `None` once the body has been given up.
    inner: Option<Incoming>,
    exchange: Arc<Exchange>,
    /// Longest silence.
    silence: Duration,
    timer: Option<Pin<Box<Sleep>>>,
    waiting_since: Option<Instant>,
    /// Time spent waiting before that.
    waited: Duration,
    received: u64,
    /// True if an unread rest is to be drained.
    drains: bool,
}

/// Puts the time limits around a body.
pub(super) fn timed(
    inner: Incoming,
    exchange: Arc<Exchange>,
    silence: Duration,
    drains: bool,
) -> Body {
    if inner.is_end_stream() {
        return Body::empty();
    }
    Body::new(RequestBody {
        inner: Some(inner),
        exchange,
        silence,
        timer: None,
        waiting_since: None,
        waited: Duration::ZERO,
        received: 0,
        drains,
    })
}

impl RequestBody {
    /// Waits on; true if the body is too late.
    fn is_late(&mut self, cx: &mut Context<'_>) -> bool {
        let now = Instant::now();
        if self.waiting_since.is_none() {
            self.waiting_since = Some(now);
            let earned = Duration::from_secs(self.received / LEAST_RATE);
            let left = (self.silence + earned).saturating_sub(self.waited).min(self.silence);
            match &mut self.timer {
                Some(timer) => timer.as_mut().reset(now + left),
                None => self.timer = Some(Box::pin(tokio::time::sleep_until(now + left))),
            }
        }
        self.timer.as_mut().is_some_and(|timer| timer.as_mut().poll(cx).is_ready())
    }
}

impl HttpBody for RequestBody {
    type Data = Bytes;
    type Error = axum::BoxError;

    fn poll_frame(
        mut self: Pin<&mut Self>,
        cx: &mut Context<'_>,
    ) -> Poll<Option<Result<Frame<Bytes>, axum::BoxError>>> {
        let this = &mut *self;
        let Some(inner) = &mut this.inner else { return Poll::Ready(None) };
        let Poll::Ready(frame) = Pin::new(inner).poll_frame(cx) else {
            this.exchange.set_turn(Turn::Body);
            if !this.is_late(cx) {
                return Poll::Pending;
            }
            this.inner = None;
            return Poll::Ready(Some(Err(TooSlow.into())));
        };
        this.exchange.set_turn(Turn::Server);
        if let Some(since) = this.waiting_since.take() {
            this.waited += since.elapsed();
        }
        match frame {
            Some(Ok(frame)) => {
                this.received += frame.data_ref().map_or(0, |data| data.len() as u64);
                Poll::Ready(Some(Ok(frame)))
            }
            Some(Err(error)) => {
                this.inner = None;
                Poll::Ready(Some(Err(error.into())))
            }
            None => {
                this.inner = None;
                Poll::Ready(None)
            }
        }
    }

    fn is_end_stream(&self) -> bool {
        self.inner.as_ref().is_none_or(HttpBody::is_end_stream)
    }

    fn size_hint(&self) -> SizeHint {
        self.inner.as_ref().map_or_else(SizeHint::default, HttpBody::size_hint)
    }
}

impl Drop for RequestBody {
    fn drop(&mut self) {
        let rest = self.inner.take().filter(|rest| self.drains && !rest.is_end_stream());
        if let (Some(rest), Ok(runtime)) = (rest, tokio::runtime::Handle::try_current()) {
            runtime.spawn(drain(rest, self.exchange.clone()));
        }
    }
}

/// Reads the rest of a body and forgets it.
async fn drain(mut rest: Incoming, exchange: Arc<Exchange>) {
    exchange.set_turn(Turn::Body);
    let read = async {
        let mut bytes = 0;
        while let Some(Ok(frame)) = rest.frame().await {
            bytes += frame.data_ref().map_or(0, |data| data.len() as u64);
            if bytes > DRAIN_BYTES {
                break;
            }
        }
    };
    // A client that has more to send meets a closed connection.
    let _ = tokio::time::timeout(DRAIN_TIME, read).await;
}
