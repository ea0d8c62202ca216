//! The connections to the servers. One of them is used until it is gone; which one is first is left
//! to chance, so that many workers spread over the servers.

use std::sync::{
    Arc,
    atomic::{AtomicUsize, Ordering},
};

use bendtwin_contract::worker_key;
use bendtwin_proto::worker::v1::worker_link_client::WorkerLinkClient;
use bendtwin_tls::{Mutual, Reloaded};
use tonic::{
    Code, Request, Response, Status,
    metadata::AsciiMetadataValue,
    service::{Interceptor, interceptor::InterceptedService},
    transport::Channel,
};

use super::{CallError, channel};
use crate::Error;

/// Longest reply that is accepted [bytes]; chunks are far smaller.
const MAX_MESSAGE: usize = 32 << 20;

/// The connection to one server.
pub(super) type Link = WorkerLinkClient<InterceptedService<Channel, Credentials>>;

/// The connections to all servers. Clones share them.
#[derive(Clone)]
pub(super) struct Links {
    links: Arc<[Link]>,
    /// Index of the one in use.
    current: Arc<AtomicUsize>,
}

/// Interceptor that adds the worker token and the worker's key to every call.
#[derive(Clone)]
pub(super) struct Credentials {
    token: AsciiMetadataValue,
    key: AsciiMetadataValue,
}

impl Interceptor for Credentials {
    fn call(&mut self, mut request: Request<()>) -> Result<Request<()>, Status> {
        request.metadata_mut().insert("authorization", self.token.clone());
        request.metadata_mut().insert(worker_key::METADATA, self.key.clone());
        Ok(request)
    }
}

impl Links {
    pub(super) fn new(
        servers: &[String],
        token: &str,
        key: &str,
        tls: Option<&Reloaded<Mutual>>,
    ) -> Result<Self, Error> {
        let secret = |text: String| {
            let mut value = AsciiMetadataValue::try_from(text).map_err(|_| {
                let fault = "the worker token has characters that a header cannot carry";
                Error::Options(fault.to_owned())
            })?;
            value.set_sensitive(true);
            Ok::<_, Error>(value)
        };
        let credentials =
            Credentials { token: secret(format!("Bearer {token}"))?, key: secret(key.to_owned())? };
        let link = |server: &String| {
            let link = WorkerLinkClient::with_interceptor(
                channel::open(server, tls)?,
                credentials.clone(),
            );
            Ok(link.max_decoding_message_size(MAX_MESSAGE))
        };
        let links = servers.iter().map(link).collect::<Result<Arc<[Link]>, Error>>()?;
        // The random bits of a fresh UUID spare this crate a generator.
        let first = uuid::Uuid::new_v4().as_fields().0 as usize % links.len().max(1);
        Ok(Self { links, current: Arc::new(AtomicUsize::new(first)) })
    }

    /// Calls the server in use; if it is gone, the next one, once each.
    pub(super) async fn call<T, F>(&self, call: impl Fn(Link) -> F) -> Result<T, CallError>
    where
        F: Future<Output = Result<Response<T>, Status>>,
    {
        let mut refused = None;
        for _ in 0..self.links.len() {
            let (at, link) = self.current();
            match call(link).await {
                Ok(answer) => return Ok(answer.into_inner()),
                Err(status) if self.is_gone(at, &status) => refused = Some(status),
                Err(status) => return Err(status.into()),
            }
        }
        Err(refused.unwrap_or_else(|| Status::unavailable("there is no server")).into())
    }

    /// Calls the server in use. If it is gone, the next call goes to the next one.
    pub(super) async fn call_once<T, F>(&self, call: impl FnOnce(Link) -> F) -> Result<T, CallError>
    where
        F: Future<Output = Result<Response<T>, Status>>,
    {
        let (at, link) = self.current();
        let answer = call(link).await;
        if let Err(status) = &answer {
            self.is_gone(at, status);
        }
        Ok(answer?.into_inner())
    }

    fn current(&self) -> (usize, Link) {
        let at = self.current.load(Ordering::SeqCst) % self.links.len();
        (at, self.links[at].clone())
    }

    /// True if the server is gone, or is about to be; then another one is used from now on, unless
    /// another call has seen to that.
    fn is_gone(&self, at: usize, status: &Status) -> bool {
        let gone = matches!(
            status.code(),
            Code::Unavailable | Code::DeadlineExceeded | Code::Cancelled | Code::Unknown
        );
        if gone && self.links.len() > 1 {
            let next = (at + 1) % self.links.len();
            let turned =
                self.current.compare_exchange(at, next, Ordering::SeqCst, Ordering::SeqCst);
            if turned.is_ok() {
                tracing::warn!("the server does not answer, calling the next one: {status}");
            }
        }
        gone
    }
}
