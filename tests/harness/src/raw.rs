//! gRPC calls with arbitrary bytes.

use bytes::{Buf as _, BufMut as _, Bytes};
use tonic::{
    Code, Request, Status,
    client::Grpc,
    codec::{Codec, DecodeBuf, Decoder, EncodeBuf, Encoder},
    transport::Channel,
};

/// A codec that passes bytes through.
#[derive(Clone, Copy, Debug, Default)]
struct Raw;

impl Codec for Raw {
    type Encode = Bytes;
    type Decode = Bytes;
    type Encoder = Self;
    type Decoder = Self;
    fn encoder(&mut self) -> Self {
        Self
    }
    fn decoder(&mut self) -> Self {
        Self
    }
}

impl Encoder for Raw {
    type Item = Bytes;
    type Error = Status;
    fn encode(&mut self, item: Bytes, target: &mut EncodeBuf<'_>) -> Result<(), Status> {
        target.put(item);
        Ok(())
    }
}

impl Decoder for Raw {
    type Item = Bytes;
    type Error = Status;
    fn decode(&mut self, source: &mut DecodeBuf<'_>) -> Result<Option<Bytes>, Status> {
        Ok(Some(source.copy_to_bytes(source.remaining())))
    }
}

/// Calls `/{package}.{Service}/{Method}` with these messages and returns how the call ended.
pub async fn call(channel: &Channel, path: &str, messages: Vec<Bytes>) -> Code {
    let mut grpc = Grpc::new(channel.clone());
    if let Err(error) = grpc.ready().await {
        return Status::unknown(error.to_string()).code();
    }
    let path = path.parse().unwrap();
    let request = Request::new(futures::stream::iter(messages));
    // On the wire a unary call is a stream of one.
    let mut replies = match grpc.streaming(request, path, Raw).await {
        Ok(reply) => reply.into_inner(),
        Err(status) => return status.code(),
    };
    loop {
        match replies.message().await {
            Ok(Some(_)) => (),
            Ok(None) => return Code::Ok,
            Err(status) => return status.code(),
        }
    }
}
