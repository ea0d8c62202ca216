//! RPCs of the servers with what the options of the contract say of them: what each takes, whether
//! the audit has it, and its routes of HTTP.

use prost::Message;

use crate::{
    json::{self, Fields, Read, TensorFormat, Write},
    v1::Scope,
};

/// An RPC.
#[derive(Debug)]
pub struct Rpc {
    /// `/package.Service/Method`.
    pub path: &'static str,
    /// Condition of a call.
    pub scope: Scope,
    /// True if the audit has a line for each call.
    pub audited: bool,
    /// Its routes.
    pub routes: &'static [Route],
}

impl Rpc {
    /// The name of the method alone.
    pub fn method(&self) -> &'static str {
        self.path.rsplit('/').next().unwrap_or_default()
    }
}

/// A route of an RPC.
#[derive(Debug)]
pub struct Route {
    /// `GET`, `POST`, `PUT`, `PATCH` or `DELETE`.
    pub method: &'static str,
    /// The path, `/v1/fits/{id}`.
    pub path: &'static str,
    /// Status of success.
    pub status: u16,
    /// True if nobody may store the reply.
    pub secret: bool,
    /// The translation of request and reply. None where the server has a handler of its own: bytes,
    /// events, and messages with tensors.
    pub messages: Option<Messages>,
}

/// What is wrong with a message.
pub type BoxError = Box<dyn std::error::Error>;

/// The messages of an RPC as JSON.
#[derive(Debug)]
pub struct Messages {
    /// Origin of the request's fields.
    pub source: Source,
    /// True if the request has an id that makes it idempotent.
    pub has_request_id: bool,
    /// Reads a request, to its encoded message.
    pub read: fn(Given<'_>) -> Result<Vec<u8>, BoxError>,
    /// Writes a reply from its encoded message.
    pub write: fn(&[u8]) -> Result<Written, BoxError>,
}

/// A reply as JSON.
#[derive(Debug)]
pub struct Written {
    /// The document.
    pub json: Vec<u8>,
    /// Name of the resource that the call made, if the route states its address.
    pub made: Option<String>,
}

/// The part of an HTTP request that has the fields of the message.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Source {
    /// No part: the path and the headers have all fields.
    Nothing,
    /// The query.
    Query,
    /// The JSON body.
    Body,
}

/// The parts of an HTTP request that make a message.
#[derive(Clone, Copy, Debug)]
pub struct Given<'r> {
    /// The source.
    pub source: Source,
    /// Text of the query or of the body.
    pub text: &'r [u8],
    /// The id of the path.
    pub id: &'r str,
    /// The header that makes the request idempotent; empty if there is none.
    pub request_id: &'r str,
}

/// All RPCs of the servers, with those for workers.
pub const RPCS: &[Rpc] = include!("generated/routes.rs");

/// Routes that no RPC has, `METHOD /path`, and what they take.
pub const BY_HAND: &[(&str, Scope)] = include!("generated/routes_by_hand.rs");

fn read<M: Message + Default + Fields>(
    given: Given<'_>,
    bind: fn(&mut M, Given<'_>),
) -> Result<Vec<u8>, BoxError> {
    let mut message = match given.source {
        Source::Nothing => M::default(),
        Source::Query => json::from_query(std::str::from_utf8(given.text)?)?,
        Source::Body => serde_json::from_slice::<Read<M>>(given.text)?.0,
    };
    bind(&mut message, given);
    Ok(message.encode_to_vec())
}

/// `made` finds the name of the resource that the call made; None where the route states no address.
fn write<M: Message + Default + Fields>(
    reply: &[u8],
    made: Option<fn(&M) -> Option<&String>>,
) -> Result<Written, BoxError> {
    let message = &M::decode(reply)?;
    let made = match made {
        Some(made) => Some(made(message).cloned().ok_or("the reply has no name to state")?),
        None => None,
    };
    let json = serde_json::to_vec(&Write { message, tensors: TensorFormat::Lists })?;
    Ok(Written { json, made })
}

#[cfg(test)]
mod tests;
