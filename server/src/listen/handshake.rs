//! The handshake of TLS, within the time for the head of a request. A connection has its place
//! during it, which others can take.

use std::{io::ErrorKind, net::SocketAddr, time::Duration};

use bendtwin_tls::{Accepted, is_client_hello};
use tokio::net::TcpStream;
use tokio_util::sync::CancellationToken;

use super::places::Place;
use crate::tls::Handshakes;

/// A connection that can be served.
pub(super) enum NewConnection {
    Tls(Box<Accepted>),
    /// Begun without TLS.
    Plain(TcpStream),
}

/// Shakes hands with a peer that begins with TLS; none if that does not come to a good end.
pub(super) async fn open(
    stream: TcpStream,
    peer: SocketAddr,
    tls: &Handshakes,
    limit: Duration,
    place: &Place,
    stop: &CancellationToken,
) -> Option<NewConnection> {
    let opening = async {
        if !is_client_hello(&stream).await? {
            return Ok(NewConnection::Plain(stream));
        }
        let accepted = Accepted::shake_hands(tls.settings(), stream).await?;
        Ok::<_, std::io::Error>(NewConnection::Tls(Box::new(accepted)))
    };
    let opened = tokio::select! {
        opened = tokio::time::timeout(limit, opening) => opened,
        () = place.evicted.cancelled() => return None,
        () = stop.cancelled() => return None,
    };
    match opened {
        Ok(Ok(opened)) => Some(opened),
        // A probe, for example: it sent nothing, and hung up.
        Ok(Err(error)) if error.kind() == ErrorKind::UnexpectedEof => {
            place.ended("handshake");
            None
        }
        Ok(Err(error)) => {
            failed(place, peer, &error);
            None
        }
        Err(_) => {
            failed(place, peer, &"it takes too long");
            None
        }
    }
}

/// Counts a failure. Anyone may send anything to the clients' address, so only failures of workers
/// are logged.
fn failed(place: &Place, peer: SocketAddr, why: &dyn std::fmt::Display) {
    place.ended("handshake");
    match place.listener() {
        "public" => tracing::debug!(%peer, %why, "TLS handshake failed"),
        listener => tracing::warn!(listener, %peer, %why, "TLS handshake failed"),
    }
}
