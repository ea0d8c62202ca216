//! An open connection begun by either side, with or without TLS.

use std::{
    io,
    pin::Pin,
    task::{Context, Poll},
};

use hyper_util::client::legacy::connect::{Connected, Connection};
use tokio::{
    io::{AsyncRead, AsyncWrite, ReadBuf},
    net::TcpStream,
};
use tokio_rustls::{client, server};
use tonic::transport::server::Connected as Served;

use crate::peer::Watch;

/// An open connection. One among peers fails once its other side is refused.
#[derive(Debug)]
pub struct Stream {
    kind: Kind,
    watch: Option<Watch>,
}

#[derive(Debug)]
enum Kind {
    /// Without TLS.
    Plain(TcpStream),
    /// With TLS.
    Begun(Box<client::TlsStream<TcpStream>>),
    /// With TLS, begun by the other side.
    Accepted(Box<server::TlsStream<TcpStream>>),
}

impl Stream {
    pub(crate) fn plain(stream: TcpStream) -> Self {
        Self { kind: Kind::Plain(stream), watch: None }
    }

    pub(crate) fn begun(stream: client::TlsStream<TcpStream>, watch: Option<Watch>) -> Self {
        Self { kind: Kind::Begun(Box::new(stream)), watch }
    }

    pub(crate) fn accepted(stream: server::TlsStream<TcpStream>, watch: Watch) -> Self {
        Self { kind: Kind::Accepted(Box::new(stream)), watch: Some(watch) }
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
    /// Both protocols of HTTP read as long as a connection is open, so that the watch is polled here
    /// alone.
    fn poll_read(
        self: Pin<&mut Self>,
        cx: &mut Context<'_>,
        into: &mut ReadBuf<'_>,
    ) -> Poll<io::Result<()>> {
        let this = self.get_mut();
        if let Some(watch) = &mut this.watch {
            watch.check(cx)?;
        }
        match &mut this.kind {
            Kind::Plain(stream) => Pin::new(stream).poll_read(cx, into),
            Kind::Begun(stream) => Pin::new(stream).poll_read(cx, into),
            Kind::Accepted(stream) => Pin::new(stream).poll_read(cx, into),
        }
    }
}

impl AsyncWrite for Stream {
    fn poll_write(
        self: Pin<&mut Self>,
        cx: &mut Context<'_>,
        bytes: &[u8],
    ) -> Poll<io::Result<usize>> {
        match &mut self.get_mut().kind {
            Kind::Plain(stream) => Pin::new(stream).poll_write(cx, bytes),
            Kind::Begun(stream) => Pin::new(stream).poll_write(cx, bytes),
            Kind::Accepted(stream) => Pin::new(stream).poll_write(cx, bytes),
        }
    }

    fn poll_flush(self: Pin<&mut Self>, cx: &mut Context<'_>) -> Poll<io::Result<()>> {
        match &mut self.get_mut().kind {
            Kind::Plain(stream) => Pin::new(stream).poll_flush(cx),
            Kind::Begun(stream) => Pin::new(stream).poll_flush(cx),
            Kind::Accepted(stream) => Pin::new(stream).poll_flush(cx),
        }
    }

    fn poll_shutdown(self: Pin<&mut Self>, cx: &mut Context<'_>) -> Poll<io::Result<()>> {
        match &mut self.get_mut().kind {
            Kind::Plain(stream) => Pin::new(stream).poll_shutdown(cx),
            Kind::Begun(stream) => Pin::new(stream).poll_shutdown(cx),
            Kind::Accepted(stream) => Pin::new(stream).poll_shutdown(cx),
        }
    }

    fn is_write_vectored(&self) -> bool {
        match &self.kind {
            Kind::Plain(stream) => stream.is_write_vectored(),
            Kind::Begun(stream) => stream.is_write_vectored(),
            Kind::Accepted(stream) => stream.is_write_vectored(),
        }
    }

    fn poll_write_vectored(
        self: Pin<&mut Self>,
        cx: &mut Context<'_>,
        parts: &[io::IoSlice<'_>],
    ) -> Poll<io::Result<usize>> {
        match &mut self.get_mut().kind {
            Kind::Plain(stream) => Pin::new(stream).poll_write_vectored(cx, parts),
            Kind::Begun(stream) => Pin::new(stream).poll_write_vectored(cx, parts),
            Kind::Accepted(stream) => Pin::new(stream).poll_write_vectored(cx, parts),
        }
    }
}
