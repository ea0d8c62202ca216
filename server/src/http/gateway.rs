//! The routes of RPCs whose messages are plain: one handler takes a request to the message by the
//! table of the contract, has the gRPC service answer it in this process, and writes the reply as
//! JSON. Nothing here knows a resource.

use std::fmt::Display;

use axum::{
    Router,
    body::Body,
    extract::{FromRequestParts as _, Request, State},
    http::{self, HeaderMap, HeaderValue, StatusCode, header},
    response::{IntoResponse, Response},
    routing,
};
use bendtwin_proto::routes::{Given, Messages, RPCS, Route, Source, Written};
use bytes::{Buf as _, BufMut as _, Bytes, BytesMut};
use http_body_util::BodyExt as _;
use tonic::{Code, Status};
use tower::ServiceExt as _;

use super::{
    Result,
    extract::{self, Id},
    method_filter,
};
use crate::{
    app::{App, Error},
    context::Context,
    grpc::InProcess,
    memory::{GRPC_PREFIX, Kind},
    refusal::Refusal,
};

/// A route, and the RPC that answers it.
#[derive(Clone)]
struct RpcRoute {
    /// `/package.Service/Method`.
    rpc: &'static str,
    route: &'static Route,
    messages: &'static Messages,
    grpc: Router,
}

/// The routes, which these services answer.
pub(super) fn router(grpc: &Router) -> Router<App> {
    let mut router = Router::new();
    for rpc in RPCS {
        for route in rpc.routes {
            let Some(messages) = &route.messages else { continue };
            let rpc_route = RpcRoute { rpc: rpc.path, route, messages, grpc: grpc.clone() };
            let handler = move |State(app): State<App>, request: Request| {
                let rpc_route = rpc_route.clone();
                async move { rpc_route.answer(&app, request).await }
            };
            let handler = routing::on(method_filter(route.method), handler);
            router = router.route(route.path, handler);
        }
    }
    router
}

impl RpcRoute {
    async fn answer(self, app: &App, request: Request) -> Result<Response> {
        let message = self.read(app, request).await?;
        let reply = self.call(message).await?;
        let status = StatusCode::from_u16(self.route.status).map_err(|e| internal(&e))?;
        if status == StatusCode::NO_CONTENT {
            return Ok(status.into_response());
        }
        let Written { json, made } = (self.messages.write)(&reply).map_err(|e| internal(&*e))?;
        let mut headers = HeaderMap::new();
        headers.insert(header::CONTENT_TYPE, HeaderValue::from_static("application/json"));
        if self.route.secret {
            headers.insert(header::CACHE_CONTROL, HeaderValue::from_static("no-store"));
        }
        if let Some(name) = made {
            let address = format!("/v1/{name}");
            let address = HeaderValue::try_from(address).map_err(|e| internal(&e))?;
            headers.insert(header::LOCATION, address);
        }
        Ok((status, headers, json).into_response())
    }

    /// The message that a request asks for.
    async fn read(&self, app: &App, request: Request) -> Result<Vec<u8>> {
        let (mut parts, body) = request.into_parts();
        let id = match self.route.path.contains("{id}") {
            true => Id::from_request_parts(&mut parts, &()).await?.0,
            false => String::new(),
        };
        let request_id = match self.messages.has_request_id {
            true => extract::idempotency_key(&parts.headers)?,
            false => String::new(),
        };
        let source = self.messages.source;
        let read = |text: &[u8]| {
            let given = Given { source, text, id: &id, request_id: &request_id };
            (self.messages.read)(given).map_err(|e| e.to_string())
        };
        match source {
            Source::Nothing => read(&[]).map_err(|fault| Error::invalid("body", fault).into()),
            Source::Query => read(parts.uri.query().unwrap_or_default().as_bytes())
                .map_err(|fault| Error::invalid("query", fault).into()),
            Source::Body => {
                extract::expect_type(&parts.headers, &["application/json"])?;
                let limit = app.options().limits.json_bytes as u64;
                let request = Request::from_parts(parts, body);
                let received =
                    extract::whole(app, request, Kind::Document, limit, |_| Ok(())).await?;
                read(&received.bytes).map_err(|fault| {
                    let fault = format!("is not the JSON that is expected: {fault}");
                    Error::invalid("body", fault).into()
                })
            }
        }
    }

    /// The reply of the service.
    async fn call(&self, message: Vec<u8>) -> Result<Bytes> {
        let mut body = BytesMut::with_capacity(GRPC_PREFIX + message.len());
        body.put_u8(0);
        body.put_u32(u32::try_from(message.len()).map_err(|e| internal(&e))?);
        body.extend_from_slice(&message);
        let request = http::Request::post(self.rpc)
            .header(header::CONTENT_TYPE, "application/grpc")
            .header(header::TE, "trailers")
            .extension(InProcess)
            .body(Body::from(body.freeze()))
            .map_err(|e| internal(&e))?;
        let context = Context { is_in_process: true, ..Context::current() };
        let Ok(response) = context.scope(self.grpc.clone().oneshot(request)).await;
        let (head, body) = response.into_parts();
        let collected = body.collect().await.map_err(|e| internal(&e))?;
        let status = collected.trailers().and_then(Status::from_header_map);
        let status = status.or_else(|| Status::from_header_map(&head.headers));
        match status {
            Some(status) if status.code() != Code::Ok => Err(Refusal::of_status(&status)),
            None => Err(internal(&"a reply without a status").into()),
            Some(_) => {
                let mut reply = collected.to_bytes();
                reply.advance(GRPC_PREFIX.min(reply.len()));
                Ok(reply)
            }
        }
    }
}

fn internal(error: &(impl Display + ?Sized)) -> Error {
    Error::Internal(format!("answering over HTTP: {error}"))
}
