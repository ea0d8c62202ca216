//! Connections that a client begins, with TLS where the address says so.

use std::{
    io,
    pin::Pin,
    sync::Arc,
    task::{Context, Poll},
    time::Duration,
};

use hyper::Uri;
use hyper_util::{
    client::legacy::connect::{Connected, Connection},
    rt::TokioIo,
};
use rustls::{ClientConfig, pki_types::ServerName};
use tokio::{
    io::{AsyncRead, AsyncWrite, ReadBuf},
    net::TcpStream,
};
use tokio_rustls::{TlsConnector, client::TlsStream, server};
use tonic::transport::server::Connected as Served;
use tower::Service;

use crate::TlsError;

/// Opens connections to the hosts of URLs. It asks for the settings of TLS each time, since they
/// may have been reloaded.
#[derive(Clone)]
pub struct Connector {
    settings: Option<Arc<dyn Fn() -> Arc<ClientConfig> + Send + Sync>>,
    timeout: Duration,
}

/// An open connection.
#[derive(Debug)]
pub enum Stream {
    /// Without TLS.
    Plain(TcpStream),
    /// With TLS.
    Tls(Box<TlsStream<TcpStream>>),
    /// With TLS, begun by the other side.
    Accepted(Box<server::TlsStream<TcpStream>>),
}

impl Connector {
    /// A connector that has `timeout` for the connection and the handshake. Without settings it
    /// fails for `https`.
    pub fn new(timeout: Duration) -> Self {
        Self { settings: None, timeout }
    }

    /// With settings for `https`.
    #[must_use]
    pub fn with_tls(
        self,
        settings: impl Fn() -> Arc<ClientConfig> + Send + Sync + 'static,
    ) -> Self {
        Self { settings: Some(Arc::new(settings)), ..self }
    }

    /// True if it has settings for `https`.
    pub fn has_tls(&self) -> bool {
        self.settings.is_some()
    }

    async fn connect(self, uri: Uri) -> io::Result<Stream> {
        let is_https = uri.scheme_str() == Some("https");
        let authority = uri.authority().map(ToString::to_string).unwrap_or_default();
        let host = uri.host().unwrap_or_default();
        let host = host.trim_start_matches('[').trim_end_matches(']');
        let port = uri.port_u16().unwrap_or(if is_https { 443 } else { 80 });
        let connecting = async {
            let stream = TcpStream::connect((host, port)).await?;
            stream.set_nodelay(true)?;
            if !is_https {
                return Ok(Stream::Plain(stream));
            }
            let settings = self.settings.as_ref().map(|settings| settings());
            let settings =
                settings.ok_or_else(|| failed(TlsError::without_settings(&authority)))?;
            let name = ServerName::try_from(host.to_owned());
            let name = name.map_err(|_| failed(TlsError::no_name(host)))?;
            let shaken = TlsConnector::from(settings).connect(name, stream).await;
            let stream = shaken.map_err(|error| with_advice(error, &authority))?;
            Ok(Stream::Tls(Box::new(stream)))
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

impl Connection for Stream {
    fn connected(&self) -> Connected {
        Connected::new()
    }
}

impl Served for Stream {
    type ConnectInfo = ();

    fn connect_info(&self) {}
}

impl AsyncRead for Stream {
    fn poll_read(
        self: Pin<&mut Self>,
        cx: &mut Context<'_>,
        into: &mut ReadBuf<'_>,
    ) -> Poll<io::Result<()>> {
        match self.get_mut() {
            Self::Plain(stream) => Pin::new(stream).poll_read(cx, into),
            Self::Tls(stream) => Pin::new(stream).poll_read(cx, into),
            Self::Accepted(stream) => Pin::new(stream).poll_read(cx, into),
        }
    }
}

impl AsyncWrite for Stream {
    fn poll_write(
        self: Pin<&mut Self>,
        cx: &mut Context<'_>,
        bytes: &[u8],
    ) -> Poll<io::Result<usize>> {
        match self.get_mut() {
            Self::Plain(stream) => Pin::new(stream).poll_write(cx, bytes),
            Self::Tls(stream) => Pin::new(stream).poll_write(cx, bytes),
            Self::Accepted(stream) => Pin::new(stream).poll_write(cx, bytes),
        }
    }

    fn poll_flush(self: Pin<&mut Self>, cx: &mut Context<'_>) -> Poll<io::Result<()>> {
        match self.get_mut() {
            Self::Plain(stream) => Pin::new(stream).poll_flush(cx),
            Self::Tls(stream) => Pin::new(stream).poll_flush(cx),
            Self::Accepted(stream) => Pin::new(stream).poll_flush(cx),
        }
    }

    fn poll_shutdown(self: Pin<&mut Self>, cx: &mut Context<'_>) -> Poll<io::Result<()>> {
        match self.get_mut() {
            Self::Plain(stream) => Pin::new(stream).poll_shutdown(cx),
            Self::Tls(stream) => Pin::new(stream).poll_shutdown(cx),
            Self::Accepted(stream) => Pin::new(stream).poll_shutdown(cx),
        }
    }

    fn is_write_vectored(&self) -> bool {
        match self {
            Self::Plain(stream) => stream.is_write_vectored(),
            Self::Tls(stream) => stream.is_write_vectored(),
            Self::Accepted(stream) => stream.is_write_vectored(),
        }
    }

    fn poll_write_vectored(
        self: Pin<&mut Self>,
        cx: &mut Context<'_>,
        parts: &[io::IoSlice<'_>],
    ) -> Poll<io::Result<usize>> {
        match self.get_mut() {
            Self::Plain(stream) => Pin::new(stream).poll_write_vectored(cx, parts),
            Self::Tls(stream) => Pin::new(stream).poll_write_vectored(cx, parts),
            Self::Accepted(stream) => Pin::new(stream).poll_write_vectored(cx, parts),
        }
    }
}
