//! Calls over HTTP/1.1, for content that streams: uploads, and the state of the server. Connections
//! are made as those of gRPC are.

use std::{io, time::Duration};

use bendtwin_tls::Connector;
use bytes::Bytes;
use futures::Stream;
use http_body_util::{BodyExt as _, Limited, StreamBody, combinators::UnsyncBoxBody};
use hyper::{
    HeaderMap, Method, StatusCode, Uri,
    body::{Frame, Incoming},
    header::{AUTHORIZATION, HeaderName, HeaderValue},
};
use hyper_util::{client::legacy, rt::TokioExecutor};
use serde::de::DeserializeOwned;

use super::unreachable;
use crate::Error;

/// Longest body of a response that is read whole [bytes].
const MAX_BODY: usize = 16 << 20;
/// Time for which an unused connection is kept.
const IDLE: Duration = Duration::from_secs(30);

type Body = UnsyncBoxBody<Bytes, io::Error>;

/// A client of one server, which shows a token with every request. Clones share connections.
#[derive(Clone, Debug)]
pub(crate) struct Http {
    client: legacy::Client<Connector, Body>,
    authorization: Option<HeaderValue>,
}

/// A request to be sent.
#[derive(Debug)]
pub(crate) struct Request<'a> {
    http: &'a Http,
    method: Method,
    url: String,
    headers: Result<HeaderMap, Error>,
    body: Body,
}

/// The head of a response, and the body behind it.
#[derive(Debug)]
pub(crate) struct Response {
    pub(crate) status: StatusCode,
    pub(crate) headers: HeaderMap,
    body: Incoming,
}

impl Http {
    pub(crate) fn new(connector: Connector, token: Option<&str>) -> Result<Self, Error> {
        let authorization = token.map(|token| {
            let mut value = HeaderValue::try_from(format!("Bearer {token}"))
                .map_err(|_| Error::invalid("the token has characters that no token has"))?;
            value.set_sensitive(true);
            Ok::<_, Error>(value)
        });
        let client =
            legacy::Client::builder(TokioExecutor::new()).pool_idle_timeout(IDLE).build(connector);
        Ok(Self { client, authorization: authorization.transpose()? })
    }

    pub(crate) fn request(&self, method: Method, url: &str) -> Request<'_> {
        let mut headers = HeaderMap::new();
        if let Some(value) = &self.authorization {
            headers.insert(AUTHORIZATION, value.clone());
        }
        let body = http_body_util::Empty::new().map_err(|never| match never {}).boxed_unsync();
        Request { http: self, method, url: url.to_owned(), headers: Ok(headers), body }
    }
}

impl Request<'_> {
    #[must_use]
    pub(crate) fn header(self, name: &'static str, value: impl ToString) -> Self {
        let headers = self.headers.and_then(|mut headers| {
            let value = HeaderValue::try_from(value.to_string());
            let value = value.map_err(|_| {
                Error::invalid(format!("{name} has characters that no header can carry"))
            })?;
            headers.insert(HeaderName::from_static(name), value);
            Ok(headers)
        });
        Self { headers, ..self }
    }

    #[must_use]
    pub(crate) fn body(
        self,
        chunks: impl Stream<Item = io::Result<Bytes>> + Send + 'static,
    ) -> Self {
        use futures::TryStreamExt as _;
        Self { body: StreamBody::new(chunks.map_ok(Frame::data)).boxed_unsync(), ..self }
    }

    /// Sends it and waits for the head of the response.
    ///
    /// # Errors
    /// If it cannot be sent, or nothing answers; the status is for the caller to judge.
    pub(crate) async fn send(self) -> Result<Response, Error> {
        let uri: Uri = self.url.parse().map_err(|_| {
            Error::invalid(format!("`{}` is no address that can be called", self.url))
        })?;
        let mut request = hyper::Request::new(self.body);
        *request.method_mut() = self.method;
        *request.uri_mut() = uri;
        *request.headers_mut() = self.headers?;
        let sent = self.http.client.request(request).await;
        let (parts, body) = sent.map_err(|e| unreachable(&self.url, &e))?.into_parts();
        Ok(Response { status: parts.status, headers: parts.headers, body })
    }
}

impl Response {
    /// The body, if it is not too long.
    pub(crate) async fn bytes(self) -> Result<Bytes, Error> {
        let body = Limited::new(self.body, MAX_BODY).collect().await;
        Ok(body.map_err(Error::malformed)?.to_bytes())
    }

    /// The body as JSON.
    pub(crate) async fn json<T: DeserializeOwned>(self) -> Result<T, Error> {
        serde_json::from_slice(&self.bytes().await?).map_err(Error::malformed)
    }
}
