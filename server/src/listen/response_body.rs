//! Bodies of responses, each pumped by a separate task. A body is asked for its next part only when
//! the connection can take it, so a client that reads nothing would hold the producer of the body,
//! a slot at a worker for example, for ever. The task drops the producer when the deadline of the
//! call passes or when nothing was read for too long.

use std::{
    pin::Pin,
    sync::{Arc, Mutex, PoisonError},
    task::{Context, Poll, ready},
    time::Duration,
};

use axum::{BoxError, body::Body};
use bytes::Bytes;
use http_body_util::BodyExt as _;
use hyper::body::{Body as HttpBody, Frame, SizeHint};
use tokio::sync::mpsc;

use super::activity::{Exchange, Turn};
use crate::deadline::{Call, Cut};

/// Bytes that pass at a time: a reader shows progress with every slice.
const SLICE: usize = 64 << 10;
/// Slices made before they can be sent.
const AHEAD: usize = 4;

/// A response being sent. The exchange ends with it.
struct ResponseBody {
    source: Source,
    #[expect(dead_code, reason = "held, not read")]
    exchange: Arc<Exchange>,
}

enum Source {
    /// Short and whole.
    Whole(Body),
    Pumped(Box<Pumped>),
}

struct Pumped {
    slices: mpsc::Receiver<Result<Frame<Bytes>, BoxError>>,
    call: Call,
    cut: Arc<Mutex<Option<Cut>>>,
    /// Bytes to come, where that is known.
    left: Option<u64>,
}

/// Puts the time limits around a response.
pub(super) fn pumped(body: Body, call: Call, exchange: Arc<Exchange>, unread: Duration) -> Body {
    let size = body.size_hint();
    let is_short = size.upper().is_some_and(|most| most <= SLICE as u64);
    if is_short || body.is_end_stream() {
        return Body::new(ResponseBody { source: Source::Whole(body), exchange });
    }
    let (sender, slices) = mpsc::channel(AHEAD);
    let cut = Arc::default();
    let pump = Pump {
        body,
        sender,
        call: call.clone(),
        unread,
        exchange: exchange.clone(),
        cut: Arc::clone(&cut),
    };
    tokio::spawn(pump.run());
    let source = Source::Pumped(Box::new(Pumped { slices, call, cut, left: size.exact() }));
    Body::new(ResponseBody { source, exchange })
}

/// The task behind a response.
struct Pump {
    body: Body,
    sender: mpsc::Sender<Result<Frame<Bytes>, BoxError>>,
    call: Call,
    unread: Duration,
    exchange: Arc<Exchange>,
    cut: Arc<Mutex<Option<Cut>>>,
}

impl Pump {
    async fn run(mut self) {
        if let Err(cut) = self.pass().await {
            tracing::info!(request_id = self.call.context.request_id, ?cut, "response cut off");
            *self.cut.lock().unwrap_or_else(PoisonError::into_inner) = Some(cut);
            self.exchange.set_turn(Turn::Cut);
        }
    }

    /// Passes the body on to its end, or until the client goes away.
    async fn pass(&mut self) -> Result<(), Cut> {
        loop {
            let frame = tokio::select! {
                () = self.sender.closed() => return Ok(()),
                () = self.call.passed() => return Err(Cut::Deadline),
                frame = self.body.frame() => frame,
            };
            match frame {
                None => return Ok(()),
                Some(Err(error)) => {
                    self.send(Err(error.into())).await?;
                    return Ok(());
                }
                Some(Ok(frame)) => match frame.into_data() {
                    Ok(mut data) => loop {
                        let slice = data.split_to(data.len().min(SLICE));
                        if !self.send(Ok(Frame::data(slice))).await? {
                            return Ok(());
                        }
                        if data.is_empty() {
                            break;
                        }
                    },
                    Err(trailers) => {
                        self.send(Ok(trailers)).await?;
                    }
                },
            }
        }
    }

    /// False if the client has gone away.
    async fn send(&mut self, frame: Result<Frame<Bytes>, BoxError>) -> Result<bool, Cut> {
        tokio::select! {
            sent = self.sender.send(frame) => Ok(sent.is_ok()),
            () = self.call.passed() => Err(Cut::Deadline),
            () = tokio::time::sleep(self.unread) => Err(Cut::Unread(self.unread)),
        }
    }
}

impl HttpBody for ResponseBody {
    type Data = Bytes;
    type Error = BoxError;

    fn poll_frame(
        mut self: Pin<&mut Self>,
        cx: &mut Context<'_>,
    ) -> Poll<Option<Result<Frame<Bytes>, BoxError>>> {
        match &mut self.source {
            Source::Whole(body) => {
                let frame = ready!(Pin::new(body).poll_frame(cx));
                Poll::Ready(frame.map(|frame| frame.map_err(Into::into)))
            }
            Source::Pumped(pumped) => pumped.poll_frame(cx),
        }
    }

    fn is_end_stream(&self) -> bool {
        match &self.source {
            Source::Whole(body) => body.is_end_stream(),
            Source::Pumped(pumped) => pumped.left == Some(0),
        }
    }

    fn size_hint(&self) -> SizeHint {
        match &self.source {
            Source::Whole(body) => body.size_hint(),
            Source::Pumped(pumped) => pumped.left.map_or_else(SizeHint::new, SizeHint::with_exact),
        }
    }
}

impl Pumped {
    fn poll_frame(&mut self, cx: &mut Context<'_>) -> Poll<Option<Result<Frame<Bytes>, BoxError>>> {
        if let Some(frame) = ready!(self.slices.poll_recv(cx)) {
            if let (Ok(frame), Some(left)) = (&frame, &mut self.left) {
                *left = left.saturating_sub(frame.data_ref().map_or(0, |data| data.len() as u64));
            }
            return Poll::Ready(Some(frame));
        }
        let cut = self.cut.lock().unwrap_or_else(PoisonError::into_inner).take();
        Poll::Ready(cut.map(|cut| {
            if self.call.is_grpc {
                return Ok(Frame::trailers(self.call.trailers(cut)));
            }
            Err(std::io::Error::other(format!("cut off: {cut:?}")).into())
        }))
    }
}
