//! The gRPC side of rollouts: token, concurrency limit, deadline and
//! cancellation when the caller goes away.

mod call;
mod roll_out;

use std::{
    convert::Infallible,
    sync::{Arc, OnceLock, PoisonError, RwLock},
    task::{Context, Poll},
    time::{Duration, Instant},
};

use bendtwin_budget::Share;
use bendtwin_contract::rollout::{self, Limits};
use bendtwin_core::{CancelToken, Problem as _};
use bendtwin_proto::{
    deadline::timeout,
    fault,
    worker::v1::{
        ExecuteEvaluateTwinRequest, ExecuteEvaluateTwinResponse, ExecuteRegisterStateRequest,
        ExecuteRegisterStateResponse, ExecuteRollOutRequest, ManageSessionRequest,
        ManageSessionResponse, WatchRequest,
        worker_rollouts_server::{WorkerRollouts, WorkerRolloutsServer},
    },
};
use bendtwin_rollout::{Painter, Sessions};
use bytes::Bytes;
use futures::Stream;
use http_body_util::BodyExt as _;
use tokio::{
    io::{AsyncRead, AsyncWrite},
    sync::{OwnedSemaphorePermit, Semaphore},
};
use tokio_util::sync::CancellationToken;
use tonic::{
    Request, Response, Status,
    body::Body,
    codegen::{BoxFuture, Service, http},
    metadata::MetadataMap,
    server::NamedService,
    service::interceptor::InterceptedService,
    transport::{Server, server::Connected},
};
use tracing::{Instrument as _, Span};

pub(super) use self::call::Unary;
use self::roll_out::{Parts, RollOutCall};
use super::{
    Replays, WarmTwins,
    error::Error,
    status::{StatusStream, WorkerStatus},
};
use crate::{
    budget::{self, Memory},
    device::{Account, Device},
};

/// Answers rollouts.
#[derive(Clone)]
pub(crate) struct Rollouts(Arc<Inner>);

pub(super) struct Inner {
    pub(super) worker: String,
    pub(super) device: Device,
    pub(super) twins: WarmTwins,
    pub(super) replays: Replays,
    pub(super) sessions: Sessions,
    pub(super) memory: Memory,
    /// Draws pictures of sessions.
    pub(super) painter: Arc<Painter>,
    /// Bounds on requests, as the server set them last.
    limits: RwLock<Limits>,
    /// Cancelled once a server has set them: the worker is registered.
    registered: CancellationToken,
    pub(super) status: WorkerStatus,
    /// Rollouts answered concurrently.
    most: usize,
    slots: Arc<Semaphore>,
}

impl Rollouts {
    pub(crate) fn new(
        worker: String,
        device: Device,
        twins: WarmTwins,
        replays: Replays,
        memory: Memory,
        painter: Painter,
        most: usize,
    ) -> Self {
        let most = most.min(Semaphore::MAX_PERMITS);
        let slots = Arc::new(Semaphore::new(most));
        let limits = RwLock::default();
        let sessions = Sessions::default();
        Self(Arc::new(Inner {
            worker,
            device,
            twins,
            replays,
            sessions,
            memory,
            painter: Arc::new(painter),
            limits,
            registered: CancellationToken::new(),
            status: WorkerStatus::default(),
            most,
            slots,
        }))
    }

    /// Sets the bounds on requests to those of the server.
    pub(crate) fn set_limits(&self, limits: Limits) {
        *self.0.limits.write().unwrap_or_else(PoisonError::into_inner) = limits;
        self.0.registered.cancel();
    }

    /// A place among the calls under way.
    fn slot(&self) -> Result<OwnedSemaphorePermit, Status> {
        let limit = self.0.most;
        let slot = Arc::clone(&self.0.slots).try_acquire_owned();
        slot.map_err(|_| fault::status(&Error::Busy { limit }.fault()))
    }

    /// A call with one reply.
    fn unary<T>(&self, request: &mut Request<T>) -> Result<Unary, Status> {
        let held = request.extensions_mut().remove::<RequestHold>().unwrap_or_default();
        let account = account(request.metadata());
        Ok(Unary { held, account, slot: Arc::new(self.slot()?), cancel: CancelToken::default() })
    }

    pub(super) fn inner(&self) -> &Inner {
        &self.0
    }

    /// Rollouts that are under way.
    pub(crate) fn in_flight(&self) -> usize {
        self.0.most.saturating_sub(self.0.slots.available_permits())
    }
}

impl Inner {
    pub(super) fn limits(&self) -> Limits {
        *self.limits.read().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Serves rollouts until `shutdown`; those under way then are finished.
pub(crate) async fn serve<C>(
    rollouts: Rollouts,
    token: &str,
    incoming: impl Stream<Item = std::io::Result<C>>,
    shutdown: CancellationToken,
) -> Result<(), tonic::transport::Error>
where
    C: AsyncRead + AsyncWrite + Connected + Unpin + Send + 'static,
{
    let expected = blake3::hash(format!("Bearer {token}").as_bytes());
    // Digests are compared in constant time.
    let check = move |request: Request<()>| {
        let given = request.metadata().get("authorization");
        if given.is_some_and(|g| blake3::hash(g.as_bytes()) == expected) {
            Ok(request)
        } else {
            Err(Status::unauthenticated("the worker token is missing or wrong"))
        }
    };
    rollouts.0.status.end_with(shutdown.clone());
    let registered = rollouts.0.registered.clone();
    let service = Bounded(rollouts);
    let (health, health_service) = tonic_health::server::health_reporter();
    health.set_not_serving::<WorkerRolloutsServer<Rollouts>>().await;
    tokio::spawn(async move {
        registered.cancelled().await;
        health.set_serving::<WorkerRolloutsServer<Rollouts>>().await;
    });
    Server::builder()
        .http2_keepalive_interval(Some(Duration::from_secs(10)))
        .add_service(health_service)
        .add_service(InterceptedService::new(service, check))
        .serve_with_incoming_shutdown(incoming, shutdown.cancelled_owned())
        .await
}

/// The service, which decodes requests up to the size that the server set last.
#[derive(Clone)]
struct Bounded(Rollouts);

impl Service<http::Request<Body>> for Bounded {
    type Response = http::Response<Body>;
    type Error = Infallible;
    type Future = BoxFuture<Self::Response, Infallible>;

    fn poll_ready(&mut self, _: &mut Context<'_>) -> Poll<Result<(), Infallible>> {
        Poll::Ready(Ok(()))
    }

    fn call(&mut self, mut request: http::Request<Body>) -> Self::Future {
        let rollouts = self.0.clone();
        let span = span(&request);
        let answering = async move {
            let most = rollouts.0.limits().sent_request_bytes();
            let length = declared_length(&request).unwrap_or(most).min(most);
            let bytes = rollout::request_bytes(length as u64);
            let share = match budget::take(&rollouts.0.memory.requests, bytes, "the request").await
            {
                Ok(share) => share,
                Err(error) => return Ok(fault::status(&error.fault()).into_http()),
            };
            let held = RequestHold { _request: Some(Arc::new(share)), rollout: Arc::default() };
            request.extensions_mut().insert(held.clone());
            let mut service = WorkerRolloutsServer::new(rollouts).max_decoding_message_size(length);
            let response = service.call(request).await?;
            Ok(response.map(|body| {
                let hold = move |bytes: Bytes| bendtwin_budget::held(bytes, held.clone());
                Body::new(body.map_frame(move |frame| frame.map_data(&hold)))
            }))
        };
        Box::pin(answering.instrument(span))
    }
}

/// The span of a call, a child of that of the request which the server answers with it.
fn span(request: &http::Request<Body>) -> Span {
    let method = request.uri().path().rsplit('/').next().unwrap_or_default();
    let span = tracing::info_span!("call", method);
    let parent = request.headers().get(bendtwin_telemetry::HEADER).and_then(|v| v.to_str().ok());
    bendtwin_telemetry::continue_from(&span, parent.unwrap_or_default());
    span
}

/// Length of the message, as the server says.
fn declared_length(request: &http::Request<Body>) -> Option<usize> {
    request.headers().get(rollout::REQUEST_BYTES)?.to_str().ok()?.parse().ok()
}

/// The account of a call; none from a server that names no accounts.
fn account(metadata: &MetadataMap) -> Option<Account> {
    metadata.get(rollout::ACCOUNT)?.to_str().ok().map(Account::new)
}

/// Memory of a call, held until its work has ended and its reply has been sent.
#[derive(Clone, Default)]
struct RequestHold {
    _request: Option<Arc<Share>>,
    /// Set once it is known how much the rollout takes.
    rollout: Arc<OnceLock<Share>>,
}

impl NamedService for Bounded {
    const NAME: &'static str = WorkerRolloutsServer::<Rollouts>::NAME;
}

#[tonic::async_trait]
impl WorkerRollouts for Rollouts {
    type RollOutStream = Parts;
    type WatchStream = StatusStream;

    async fn watch(
        &self,
        request: Request<WatchRequest>,
    ) -> Result<Response<StatusStream>, Status> {
        Ok(Response::new(self.statuses(request.get_ref().interval_s)))
    }

    async fn roll_out(
        &self,
        mut request: Request<ExecuteRollOutRequest>,
    ) -> Result<Response<Parts>, Status> {
        let arrived = Instant::now();
        let held = request.extensions_mut().remove::<RequestHold>().unwrap_or_default();
        let slot = self.slot()?;
        let deadline = timeout(request.metadata()).map(|t| arrived + t);
        let account = account(request.metadata());
        let inner = Arc::clone(&self.0);
        let (call, parts) = RollOutCall::new(inner, slot, arrived, held, account.as_ref());
        tokio::spawn(call.serve(request.into_inner(), deadline).in_current_span());
        Ok(Response::new(parts))
    }

    async fn manage_session(
        &self,
        mut request: Request<ManageSessionRequest>,
    ) -> Result<Response<ManageSessionResponse>, Status> {
        let call = self.unary(&mut request)?;
        let request = request.into_inner();
        let request_id = request.request_id.clone();
        let managed = self.0.manage(request, &call).await;
        let (reply, share) = managed.map_err(|e| refused("session", &request_id, &e))?;
        // It is held until the reply has been sent; nothing else sets it.
        let _ = share.map(|share| call.held.rollout.set(share));
        Ok(Response::new(reply))
    }

    async fn register_state(
        &self,
        mut request: Request<ExecuteRegisterStateRequest>,
    ) -> Result<Response<ExecuteRegisterStateResponse>, Status> {
        let call = self.unary(&mut request)?;
        let request = request.into_inner();
        let request_id = request.request_id.clone();
        let registered = self.0.register(request, &call).await;
        let registered = registered.map_err(|e| refused("registration", &request_id, &e))?;
        Ok(Response::new(ExecuteRegisterStateResponse { registered: Some(registered) }))
    }

    async fn evaluate_twin(
        &self,
        mut request: Request<ExecuteEvaluateTwinRequest>,
    ) -> Result<Response<ExecuteEvaluateTwinResponse>, Status> {
        let call = self.unary(&mut request)?;
        let request = request.into_inner();
        let request_id = request.request_id.clone();
        let evaluated = self.0.evaluate(request, &call).await;
        let evaluation = evaluated.map_err(|e| refused("evaluation", &request_id, &e))?;
        Ok(Response::new(ExecuteEvaluateTwinResponse { evaluation: Some(evaluation) }))
    }
}

fn refused(what: &str, request_id: &str, error: &Error) -> Status {
    let fault = error.fault();
    tracing::info!(request_id, reason = fault.reason, "{what} refused: {fault}");
    fault::status(&fault)
}

/// Runs work beside the tasks of the runtime, which holds the memory of its call even when the
/// caller is gone.
async fn blocking<T: Send + 'static>(
    held: &RequestHold,
    work: impl FnOnce() -> Result<T, Error> + Send + 'static,
) -> Result<T, Error> {
    let held = held.clone();
    let work = tokio::task::spawn_blocking(move || {
        let _held = held;
        work()
    });
    work.await.map_err(|_| Error::Panicked)?
}
