//! The socket: HTTP/1 and HTTP/2 on one port, without TLS. `axum::serve` is not
//! used because it leaves TCP_NODELAY off (44 ms on small replies), cannot set
//! windows, and waits for slow headers without end.

use std::{net::SocketAddr, sync::Arc, time::Duration};

use hyper_util::{
    rt::{TokioExecutor, TokioIo, TokioTimer},
    server::conn::auto::Builder,
    service::TowerToHyperService,
};
use tokio::{
    net::{TcpListener, TcpStream},
    sync::Semaphore,
};
use tokio_util::{sync::CancellationToken, task::TaskTracker};

use crate::{context::Peer, http::root_service::RootService};

/// Stream and connection windows: a rollout of megabytes should not wait for updates.
const WINDOW: u32 = 4 << 20;
const MAX_STREAMS: u32 = 1024;
/// Longest time for the headers of a request.
const HEADERS_TIMEOUT: Duration = Duration::from_secs(30);
/// Time after which an idle HTTP/2 connection is pinged.
const PING_INTERVAL: Duration = Duration::from_secs(20);
/// Most open connections; further ones wait in the system's backlog.
const MAX_CONNECTIONS: usize = 4096;

/// Accepts connections until `stop`; then lets the requests under way finish, until `cut`, and
/// returns when none is left.
pub(crate) async fn serve(
    listener: TcpListener,
    root_service: RootService,
    stop: CancellationToken,
    cut: CancellationToken,
) {
    // A router takes bodies of any type, so it turns hyper's into axum's.
    let service = axum::Router::new()
        .fallback_service(tower::service_fn(move |request| root_service.clone().answer(request)));
    let connections = TaskTracker::new();
    let permits = Arc::new(Semaphore::new(MAX_CONNECTIONS));
    loop {
        let permit = tokio::select! {
            () = stop.cancelled() => break,
            permit = permits.clone().acquire_owned() => permit,
        };
        let accepted = tokio::select! {
            () = stop.cancelled() => break,
            accepted = listener.accept() => accepted,
        };
        match accepted {
            Ok((stream, peer)) => {
                let (service, stop, cut) = (service.clone(), stop.clone(), cut.clone());
                connections.spawn(async move {
                    tokio::select! {
                        () = connection(stream, peer, service, stop) => {}
                        () = cut.cancelled() => {}
                    }
                    drop(permit);
                });
            }
            Err(error) => {
                // Out of file descriptors, for example: other connections may close theirs.
                tracing::warn!(%error, "cannot accept");
                tokio::time::sleep(Duration::from_millis(50)).await;
            }
        }
    }
    drop(listener);
    connections.close();
    connections.wait().await;
}

async fn connection(
    stream: TcpStream,
    peer: SocketAddr,
    service: axum::Router,
    stop: CancellationToken,
) {
    if let Err(error) = stream.set_nodelay(true) {
        tracing::debug!(%error, %peer, "no TCP_NODELAY");
    }
    // Until the protocol is known nothing else watches the time: a silent connection would keep
    // its permit forever.
    match tokio::time::timeout(HEADERS_TIMEOUT, stream.peek(&mut [0])).await {
        Ok(Ok(1..)) => {}
        _ => return,
    }
    let mut builder = Builder::new(TokioExecutor::new());
    builder.http1().timer(TokioTimer::new()).header_read_timeout(HEADERS_TIMEOUT);
    builder
        .http2()
        .timer(TokioTimer::new())
        .initial_stream_window_size(WINDOW)
        .initial_connection_window_size(4 * WINDOW)
        .max_concurrent_streams(MAX_STREAMS)
        .keep_alive_interval(PING_INTERVAL)
        .keep_alive_timeout(PING_INTERVAL);
    // Clients have shares of the workers.
    let service = service.layer(axum::Extension(Peer(peer)));
    let serving = builder.serve_connection(TokioIo::new(stream), TowerToHyperService::new(service));
    let mut serving = std::pin::pin!(serving);
    let ended = tokio::select! {
        ended = serving.as_mut() => ended,
        () = stop.cancelled() => {
            serving.as_mut().graceful_shutdown();
            serving.await
        }
    };
    if let Err(error) = ended {
        tracing::debug!(error, %peer, "connection broke off");
    }
}
