//! A connection of either protocol, under time limits.

use std::{convert::Infallible, net::SocketAddr, sync::Arc, time::Duration};

use axum::{
    body::Body,
    http::{Request, Response, Version, header},
};
use hyper::body::Incoming;
use hyper_util::{
    rt::{TokioExecutor, TokioIo, TokioTimer},
    server::conn::auto::Builder,
    service::TowerToHyperService,
};
use tokio::io::{AsyncRead, AsyncWrite};
use tokio_util::sync::CancellationToken;

use super::{activity::Activity, places::Place, request_body, response_body};
use crate::{deadline::Call, http::root_service::RootService};

/// Stream and connection windows: a rollout of megabytes should not wait for updates.
const WINDOW: u32 = 4 << 20;
const MAX_STREAMS: u32 = 1024;
/// Time after which an idle HTTP/2 connection is pinged.
const PING_INTERVAL: Duration = Duration::from_secs(20);
/// Time for which a connection that has had requests may be without one. One of HTTP/1 has the time
/// for the head of a request.
const IDLE: Duration = Duration::from_secs(300);
/// Time for the farewell of a connection without requests.
const FAREWELL: Duration = Duration::from_millis(500);

/// Time limits of a connection.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Timeouts {
    /// Time for the head of a request, on a connection without another one.
    pub(crate) head: Duration,
    /// Longest silence within the body of a request.
    pub(crate) body: Duration,
    /// Longest time in which nothing of a response is read.
    pub(crate) unread: Duration,
    /// Age from which a connection takes no further requests.
    pub(crate) age: Duration,
}

impl Timeouts {
    /// The age of one connection: not all that began together end together.
    fn some_age(&self) -> Duration {
        // The random bits of a fresh UUID spare this crate a generator.
        let share = f64::from(uuid::Uuid::new_v4().as_fields().0) / f64::from(u32::MAX);
        self.age.mul_f64(0.9 + 0.2 * share)
    }
}

/// Serves a connection until its end, or until `stop` and the end of the requests under way.
pub(super) async fn serve(
    stream: impl AsyncRead + AsyncWrite + Unpin + Send + 'static,
    peer: SocketAddr,
    root_service: RootService,
    timeouts: Timeouts,
    place: &Place,
    stop: CancellationToken,
) {
    let activity = place.activity.clone();
    let mut builder = Builder::new(TokioExecutor::new());
    builder.http1().timer(TokioTimer::new()).header_read_timeout(timeouts.head);
    builder
        .http2()
        .timer(TokioTimer::new())
        .initial_stream_window_size(WINDOW)
        .initial_connection_window_size(4 * WINDOW)
        .max_concurrent_streams(MAX_STREAMS)
        .keep_alive_interval(PING_INTERVAL)
        .keep_alive_timeout(PING_INTERVAL);
    let service = tower::service_fn({
        let activity = activity.clone();
        move |request| answer(request, peer, root_service.clone(), activity.clone(), timeouts)
    });
    let serving = builder
        .serve_connection_with_upgrades(TokioIo::new(stream), TowerToHyperService::new(service));
    let mut serving = std::pin::pin!(serving);
    let ended = tokio::select! {
        ended = serving.as_mut() => ended,
        () = place.evicted.cancelled() => return,
        () = activity.idle_for(timeouts.head, IDLE) => {
            place.ended("idle");
            serving.as_mut().graceful_shutdown();
            tokio::select! {
                ended = serving => ended,
                () = activity.idle_for(FAREWELL, FAREWELL) => return,
            }
        }
        // The client connects again, perhaps to another server behind the same address.
        () = tokio::time::sleep(timeouts.some_age()) => {
            place.ended("age");
            serving.as_mut().graceful_shutdown();
            tokio::select! {
                ended = serving => ended,
                () = place.evicted.cancelled() => return,
                () = activity.idle_for(FAREWELL, FAREWELL) => return,
            }
        }
        () = stop.cancelled() => {
            serving.as_mut().graceful_shutdown();
            tokio::select! {
                ended = serving => ended,
                () = activity.idle_for(Duration::ZERO, FAREWELL) => return,
            }
        }
    };
    if let Err(error) = ended {
        tracing::debug!(error, %peer, "connection broke off");
    }
}

async fn answer(
    request: Request<Incoming>,
    peer: SocketAddr,
    root_service: RootService,
    activity: Arc<Activity>,
    timeouts: Timeouts,
) -> Result<Response<Body>, Infallible> {
    let exchange = activity.exchange();
    let call = Call::of(request.headers(), peer);
    // A client that waits for leave to send its body will not send it now. HTTP/2 ends one stream
    // without the others.
    let drains =
        request.version() < Version::HTTP_2 && !request.headers().contains_key(header::EXPECT);
    let request =
        request.map(|body| request_body::timed(body, exchange.clone(), timeouts.body, drains));
    let response = root_service.answer(request, &call).await?;
    // What is left of the body is not waited for.
    Ok(response.map(|body| response_body::pumped(body, call, exchange, timeouts.unread)))
}
