//! A stream of messages, each of which is checked before it is decoded.

use std::{
    pin::Pin,
    task::{Context, Poll, ready},
};

use bendtwin_contract::rollout::{self, Encoded, Limits};
use bendtwin_core::Problem as _;
use bendtwin_proto::fault;
use bytes::{Buf as _, Bytes, BytesMut};
use hyper::body::{Body as HttpBody, Frame};
use tonic::{Status, body::Body};

use crate::memory::GRPC_PREFIX;

/// Longest message of a stream [bytes]: what a robot does in a moment is short.
const LONGEST: usize = 1 << 20;

/// The body of a stream of messages.
pub(super) struct Screened {
    body: Body,
    encoded: Encoded,
    limits: Limits,
    /// Bytes of a message that has not come whole.
    waiting: BytesMut,
}

impl Screened {
    pub(super) fn new(body: Body, encoded: Encoded, limits: Limits) -> Self {
        Self { body, encoded, limits, waiting: BytesMut::new() }
    }

    /// The next whole message with its prefix, if it has arrived.
    fn message(&mut self) -> Result<Option<Bytes>, Status> {
        let Some(mut prefix) = self.waiting.get(..GRPC_PREFIX) else { return Ok(None) };
        let is_compressed = prefix.get_u8() != 0;
        let length = prefix.get_u32() as usize;
        if length > LONGEST {
            return Err(Status::out_of_range(format!(
                "a message of {length} bytes: {LONGEST} are the most in a stream"
            )));
        }
        if self.waiting.len() < GRPC_PREFIX + length {
            return Ok(None);
        }
        let message = self.waiting.split_to(GRPC_PREFIX + length).freeze();
        if !is_compressed {
            rollout::check_encoded(self.encoded, &message[GRPC_PREFIX..], &self.limits)
                .map_err(|e| fault::status(&e.fault()))?;
        }
        Ok(Some(message))
    }
}

impl HttpBody for Screened {
    type Data = Bytes;
    type Error = Status;

    fn poll_frame(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
    ) -> Poll<Option<Result<Frame<Bytes>, Status>>> {
        loop {
            match self.message() {
                Err(status) => return Poll::Ready(Some(Err(status))),
                Ok(Some(message)) => return Poll::Ready(Some(Ok(Frame::data(message)))),
                Ok(None) => {}
            }
            let Some(frame) = ready!(Pin::new(&mut self.body).poll_frame(context)) else {
                // What is left is no message: the service says so.
                let rest = std::mem::take(&mut self.waiting);
                return Poll::Ready((!rest.is_empty()).then(|| Ok(Frame::data(rest.freeze()))));
            };
            match frame?.into_data() {
                Ok(data) => self.waiting.extend_from_slice(&data),
                Err(other) => return Poll::Ready(Some(Ok(other))),
            }
        }
    }
}
