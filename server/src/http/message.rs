//! Bodies and replies that are messages of `bendtwin.v1`: as JSON, or binary.

use std::sync::Arc;

use axum::{
    extract::Request,
    http::header,
    response::{IntoResponse, Response},
};
use bendtwin_contract::rollout::{self, Encoded};
use bendtwin_proto::json::{Read, TensorFormat, Write};
use bytes::Bytes;
use prost::Message;
use serde::{Serialize, de::DeserializeOwned};

use super::{Result, extract, rollouts::document};
use crate::{
    app::{App, Error, ReplyHold},
    memory::{Kind, Shares},
    refusal::Refusal,
};

/// Texts beyond this size are read beside the tasks of the runtime [bytes].
const SMALL_TEXT: usize = 16 << 10;

const PROTOBUF: &str = "application/x-protobuf";

/// A body, the memory that it takes, and the form that the reply is to have.
pub(super) struct Body<M> {
    pub(super) message: M,
    pub(super) memory: Arc<Shares>,
    pub(super) form: Form,
}

/// Form of a reply.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Form {
    Protobuf,
    Json(TensorFormat),
}

impl<M> Body<M>
where
    M: Message + Default + 'static,
    Read<M>: DeserializeOwned + Send + 'static,
{
    /// Reads the body of a request. What is sent as protobuf is answered as protobuf.
    pub(super) async fn read(
        app: &App,
        request: Request,
        encoded: Encoded,
        tensors: TensorFormat,
    ) -> Result<Self> {
        extract::expect_type(request.headers(), &["application/json", PROTOBUF])?;
        let wants_protobuf = names_protobuf(&request, header::ACCEPT);
        let sends_protobuf = names_protobuf(&request, header::CONTENT_TYPE);
        let limits = app.options().limits.rollout;
        let (kind, most) = match sends_protobuf {
            true => (Kind::Protobuf, limits.request_bytes),
            false => (Kind::Json, limits.json_bytes),
        };
        let look = |beginning: &[u8]| match kind {
            Kind::Protobuf => rollout::check_encoded(encoded, beginning, &limits),
            Kind::Json | Kind::Document => Ok(()),
        };
        let received = extract::whole(app, request, kind, most, look).await?;
        let message = if sends_protobuf {
            rollout::check_encoded(encoded, &received.bytes, &limits).map_err(Error::Rollout)?;
            let fault = |e| Error::invalid("body", format!("is not the message expected: {e}"));
            M::decode(received.bytes).map_err(fault)?
        } else {
            read_json(received.bytes, &received.memory).await?
        };
        let is_protobuf = wants_protobuf || sends_protobuf;
        let form = if is_protobuf { Form::Protobuf } else { Form::Json(tensors) };
        Ok(Self { message, memory: received.memory, form })
    }
}

impl Form {
    /// True if tensors are written as nested lists.
    pub(super) fn is_lists(self) -> bool {
        self == Self::Json(TensorFormat::Lists)
    }

    /// The answer, which holds its memory until it has been sent.
    pub(super) fn answer<M>(self, message: M, held: ReplyHold) -> Result<Response>
    where
        M: Message + 'static,
        for<'m> Write<'m, M>: Serialize,
    {
        match self {
            Self::Json(tensors) => Ok(document::answer(message, held, tensors)?),
            Self::Protobuf => {
                let body = bendtwin_budget::held(message.encode_to_vec().into(), held.memory());
                Ok(([(header::CONTENT_TYPE, PROTOBUF)], body).into_response())
            }
        }
    }
}

/// A small message as JSON.
pub(super) fn document<M>(message: &M) -> Response
where
    for<'m> Write<'m, M>: Serialize,
{
    axum::Json(Write { message, tensors: TensorFormat::default() }).into_response()
}

/// Reads a request. `memory` is held until that has ended, also when nobody waits any more.
async fn read_json<M>(text: Bytes, memory: &Arc<Shares>) -> Result<M>
where
    M: Message + 'static,
    Read<M>: DeserializeOwned + Send + 'static,
{
    if text.len() <= SMALL_TEXT {
        return Ok(extract::json::<Read<M>>(&text)?.0);
    }
    let memory = Arc::clone(memory);
    let read = tokio::task::spawn_blocking(move || {
        let read = extract::json::<Read<M>>(&text)?;
        drop(text);
        memory.decoded(read.0.encoded_len());
        Ok::<_, Refusal>(read)
    });
    let read = read.await.map_err(|e| Error::Internal(format!("reading a body: {e}")))?;
    Ok(read?.0)
}

fn names_protobuf(request: &Request, name: header::HeaderName) -> bool {
    let value = request.headers().get(name).and_then(|v| v.to_str().ok());
    value.is_some_and(|v| v.trim().starts_with(PROTOBUF))
}
