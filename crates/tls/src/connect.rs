//! Connections that a client begins, with TLS where the address says so.

use std::{
    io,
    net::SocketAddr,
    pin::Pin,
    sync::Arc,
    task::{Context, Poll},
    time::Duration,
};

use hyper::Uri;
use hyper_util::rt::TokioIo;
use rustls::{ClientConfig, pki_types::ServerName};
use tokio::net::TcpStream;
use tokio_rustls::TlsConnector;
use tower::Service;

use crate::{
    Mutual, Reloaded, Stream, TlsError,
    peer::{Peer, Watch},
};

/// Opens connections to the hosts of URLs. It asks for the settings of TLS each time, since they
/// may have been reloaded.
#[derive(Clone)]
pub struct Connector {
    settings: Option<Settings>,
    timeout: Duration,
    /// Address of every connection, in place of the host of a URL.
    address: Option<SocketAddr>,
}

/// Settings of TLS for each connection.
#[derive(Clone)]
enum Settings {
    Of(Arc<dyn Fn() -> Arc<ClientConfig> + Send + Sync>),
    /// Connections of a peer, which end when the other side is refused later.
    Peer(Reloaded<Mutual>),
}

impl Connector {
    /// A connector that has `timeout` for the connection and the handshake. Without settings it
    /// fails for `https`.
    pub fn new(timeout: Duration) -> Self {
        Self { settings: None, timeout, address: None }
    }

    /// With this address for every connection: the host of a URL is only the name that the other side
    /// has to show.
    #[must_use]
    pub fn at(self, address: SocketAddr) -> Self {
        Self { address: Some(address), ..self }
    }

    /// With settings for `https`.
    #[must_use]
    pub fn with_tls(
        self,
        settings: impl Fn() -> Arc<ClientConfig> + Send + Sync + 'static,
    ) -> Self {
        Self { settings: Some(Settings::Of(Arc::new(settings))), ..self }
    }

    /// With the settings of a peer for `https`.
    #[must_use]
    pub fn with_peer(self, settings: Reloaded<Mutual>) -> Self {
        Self { settings: Some(Settings::Peer(settings)), ..self }
    }

    /// True if it has settings for `https`.
    pub fn has_tls(&self) -> bool {
        self.settings.is_some()
    }

    /// A connection to the host of a URL.
    ///
    /// # Errors
    /// If nothing answers there in time, or the other side is not accepted.
    pub async fn connect(self, uri: Uri) -> io::Result<Stream> {
        let is_https = uri.scheme_str() == Some("https");
        let authority = uri.authority().map(ToString::to_string).unwrap_or_default();
        let host = uri.host().unwrap_or_default();
        let host = host.trim_start_matches('[').trim_end_matches(']');
        let port = uri.port_u16().unwrap_or(if is_https { 443 } else { 80 });
        let connecting = async {
            let stream = match self.address {
                Some(address) => TcpStream::connect(address).await?,
                None => TcpStream::connect((host, port)).await?,
            };
            stream.set_nodelay(true)?;
            if !is_https {
                return Ok(Stream::plain(stream));
            }
            let (settings, peers) = match self.settings {
                Some(Settings::Of(settings)) => (settings(), None),
                Some(Settings::Peer(peers)) => (peers.get().client.clone(), Some(peers)),
                None => return Err(failed(TlsError::without_settings(&authority))),
            };
            let name = ServerName::try_from(host.to_owned());
            let name = name.map_err(|_| failed(TlsError::no_name(host)))?;
            let shaken = TlsConnector::from(settings).connect(name.clone(), stream).await;
            let stream = shaken.map_err(|error| with_advice(error, &authority))?;
            let watch = peers.map(|peers| {
                let peer = Peer::of(stream.get_ref().1, Some(name));
                Watch::new(peers, peer, authority.clone())
            });
            Ok(Stream::begun(stream, watch))
        };
        match tokio::time::timeout(self.timeout, connecting).await {
            Ok(connected) => connected,
            Err(_) => Err(io::Error::new(io::ErrorKind::TimedOut, "it does not answer in time")),
        }
    }
}

fn failed(error: TlsError) -> io::Error {
    io::Error::other(error)
}

fn with_advice(error: io::Error, host: &str) -> io::Error {
    let ended = [io::ErrorKind::UnexpectedEof, io::ErrorKind::ConnectionReset];
    match TlsError::find(&error, host) {
        Some(found) => failed(found),
        None if ended.contains(&error.kind()) => failed(TlsError::ended(host)),
        None => error,
    }
}

impl std::fmt::Debug for Connector {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Connector").field("timeout", &self.timeout).finish_non_exhaustive()
    }
}

impl Service<Uri> for Connector {
    type Response = TokioIo<Stream>;
    type Error = io::Error;
    type Future = Pin<Box<dyn Future<Output = io::Result<TokioIo<Stream>>> + Send>>;

    fn poll_ready(&mut self, _: &mut Context<'_>) -> Poll<io::Result<()>> {
        Poll::Ready(Ok(()))
    }

    fn call(&mut self, uri: Uri) -> Self::Future {
        let connecting = self.clone().connect(uri);
        Box::pin(async { connecting.await.map(TokioIo::new) })
    }
}
