//! The side of a connection that others began.

use std::{io, sync::Arc};

use rustls::ServerConfig;
use tokio::net::TcpStream;
use tokio_rustls::{TlsAcceptor, server::TlsStream};

use crate::{
    Certificate, Mutual, Reloaded, Stream,
    peer::{Peer, Watch},
};

/// A connection whose handshake has ended well.
#[derive(Debug)]
pub struct Accepted {
    /// The connection.
    pub stream: TlsStream<TcpStream>,
    /// Certificate of the peer, if it showed one.
    pub peer: Option<Certificate>,
}

impl Accepted {
    /// Shakes hands. There is no time limit: the caller has one.
    ///
    /// # Errors
    /// If the connection breaks, or either side refuses the other.
    pub async fn shake_hands(config: Arc<ServerConfig>, stream: TcpStream) -> io::Result<Self> {
        let stream = TlsAcceptor::from(config).accept(stream).await?;
        let peer = stream.get_ref().1.peer_certificates();
        let peer = peer.and_then(|chain| chain.first()).and_then(Certificate::of);
        Ok(Self { stream, peer })
    }

    /// Certificates that the peer showed.
    pub fn shown(&self) -> Peer {
        Peer::of(self.stream.get_ref().1, None)
    }

    /// The connection among peers: it fails once these settings refuse the other side.
    pub fn among_peers(self, settings: Reloaded<Mutual>) -> Stream {
        let name = self.peer.as_ref().map_or("the other side", Certificate::name).to_owned();
        let watch = Watch::new(settings, self.shown(), name);
        Stream::accepted(self.stream, watch)
    }
}

/// True if what a client sends begins as TLS does. Waits for its first byte, which is not taken.
///
/// # Errors
/// If the connection breaks or ends before.
pub async fn is_client_hello(stream: &TcpStream) -> io::Result<bool> {
    let mut first = [0];
    if stream.peek(&mut first).await? == 0 {
        return Err(io::ErrorKind::UnexpectedEof.into());
    }
    // The content type of a handshake.
    Ok(first == [22])
}
