//! The sockets: HTTP/1 and HTTP/2 on one port, over TLS where there is a certificate. `axum::serve` is not
//! used because it leaves TCP_NODELAY off (44 ms on small replies), cannot set
//! windows, and waits for slow clients without end.

mod activity;
mod connection;
mod handshake;
mod places;
mod request_body;
mod response_body;

use std::{net::SocketAddr, time::Duration};

use tokio::net::{TcpListener, TcpStream};
use tokio_util::{sync::CancellationToken, task::TaskTracker};

use crate::{http::root_service::RootService, metrics::Metrics, options::Options, tls::Handshakes};

use handshake::NewConnection;
use places::Place;

pub(crate) use connection::Timeouts;
pub(crate) use request_body::is_too_slow;

/// File descriptors that are not for connections: the store, workers, the listeners themselves.
const OTHER_DESCRIPTORS: u64 = 256;
/// File descriptors of one connection: itself, and a file that it reads or writes.
const DESCRIPTORS_EACH: u64 = 2;

/// Bounds of a listener.
#[derive(Clone, Debug)]
pub(crate) struct Bounds {
    /// Name in metrics.
    name: &'static str,
    connections: usize,
    per_peer: usize,
    timeouts: Timeouts,
}

impl Bounds {
    /// The bounds of the public listener. They keep within the descriptors that the process may
    /// open, and leave an eighth of these to the workers' listener.
    pub(crate) fn public(options: &Options) -> Self {
        let wanted = options.limits.connections;
        let connections = wanted.min(descriptors().saturating_mul(7) / 8).max(1);
        if connections < wanted {
            tracing::warn!(
                connections,
                wanted,
                "fewer connections: the limit of open files is low"
            );
        }
        let per_peer = options.limits.connections_per_peer.min(connections);
        Self { name: "public", connections, per_peer, timeouts: options.timeouts() }
    }

    /// The bounds of a listener of workers, of which there may be two.
    pub(crate) fn workers(options: &Options, name: &'static str) -> Self {
        let listeners = if options.worker_tls.is_some() { 2 } else { 1 };
        let connections = options.limits.connections.min(descriptors() / 8 / listeners).max(16);
        Self { name, connections, per_peer: connections, timeouts: options.timeouts() }
    }
}

/// Connections for which there are file descriptors.
fn descriptors() -> usize {
    let limit = rlimit::Resource::NOFILE.get_soft().unwrap_or(1024);
    usize::try_from(limit.saturating_sub(OTHER_DESCRIPTORS) / DESCRIPTORS_EACH)
        .unwrap_or(usize::MAX)
}

/// Accepts connections until `stop`; then lets requests under way finish, until `cut`, and returns
/// when all have ended.
pub(crate) async fn serve(
    listener: TcpListener,
    root_service: RootService,
    bounds: Bounds,
    tls: Option<Handshakes>,
    metrics: Metrics,
    stop: CancellationToken,
    cut: CancellationToken,
) {
    let connections = TaskTracker::new();
    let Bounds { name, connections: total, per_peer, timeouts } = bounds;
    let places = places::Places::new(name, total, per_peer, metrics);
    loop {
        let accepted = tokio::select! {
            () = stop.cancelled() => break,
            accepted = listener.accept() => accepted,
        };
        match accepted {
            Ok((stream, peer)) => {
                // Closed immediately if there is no place: in the system's backlog it would wait
                // without end.
                let Some(place) = places.take(peer.ip()) else { continue };
                let (service, stop, cut) = (root_service.clone(), stop.clone(), cut.clone());
                let tls = tls.clone();
                connections.spawn(async move {
                    tokio::select! {
                        () = serve_one(stream, peer, service, tls, timeouts, &place, stop) => {}
                        () = cut.cancelled() => {}
                    }
                    drop(place);
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

/// Serves a connection, after its handshake if the listener has TLS.
async fn serve_one(
    stream: TcpStream,
    peer: SocketAddr,
    service: RootService,
    tls: Option<Handshakes>,
    timeouts: Timeouts,
    place: &Place,
    stop: CancellationToken,
) {
    if let Err(error) = stream.set_nodelay(true) {
        tracing::debug!(%error, %peer, "no TCP_NODELAY");
    }
    let Some(tls) = tls else {
        return connection::serve(stream, peer, service, timeouts, place, stop).await;
    };
    match handshake::open(stream, peer, &tls, timeouts.head, place, &stop).await {
        None => {}
        Some(NewConnection::Tls(accepted)) => {
            let refused = tls.refused(&accepted);
            let worker = accepted.peer.as_ref().map(|shown| shown.name().to_owned());
            let service = service.with_certificate(accepted.peer);
            tokio::select! {
                () = connection::serve(accepted.stream, peer, service, timeouts, place, stop) => {}
                why = refused => {
                    place.ended("certificate");
                    tracing::warn!(%peer, worker, why, "connection ended for its certificate");
                }
            }
        }
        // Served without TLS, so that the sender can read the refusal.
        Some(NewConnection::Plain(stream)) => {
            let service = service.refusing_without_tls();
            connection::serve(stream, peer, service, timeouts, place, stop).await;
        }
    }
}
