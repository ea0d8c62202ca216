//! The other side of an open connection among peers. Its certificate was accepted when the
//! connection began; settings that are loaded later may refuse it, and the connection ends then.

use std::{
    fmt, io,
    pin::Pin,
    task::{Context, Poll},
};

use rustls::{
    CommonState,
    client::danger::ServerCertVerifier as _,
    pki_types::{CertificateDer, ServerName, UnixTime},
};

use crate::{Mutual, Reloaded, TlsError};

/// Certificates that the other side of a connection showed.
#[derive(Clone, Debug)]
pub struct Peer {
    /// Certificates, the peer's first.
    chain: Vec<CertificateDer<'static>>,
    /// The name under which it was called; none if it called.
    name: Option<ServerName<'static>>,
}

impl Peer {
    pub(crate) fn of(connection: &CommonState, name: Option<ServerName<'static>>) -> Self {
        let chain = connection.peer_certificates().unwrap_or_default();
        Self { chain: chain.iter().map(|shown| shown.clone().into_owned()).collect(), name }
    }
}

impl Mutual {
    /// Checks the certificate of a peer as a handshake does.
    ///
    /// # Errors
    /// If these settings refuse it.
    pub fn check(&self, peer: &Peer) -> Result<(), rustls::Error> {
        let Some((own, others)) = peer.chain.split_first() else {
            return Err(rustls::Error::NoCertificatesPresented);
        };
        let now = UnixTime::now();
        match &peer.name {
            Some(name) => self.servers.verify_server_cert(own, others, name, &[], now).map(drop),
            None => self.clients.verify_client_cert(own, others, now).map(drop),
        }
    }
}

impl Reloaded<Mutual> {
    /// Waits until the settings in force refuse a peer, including those that were loaded since the
    /// handshake.
    pub async fn refused(self, peer: Peer) -> rustls::Error {
        let mut settings = self.changes();
        loop {
            let current = settings.borrow_and_update().clone();
            if let Err(refusal) = current.check(&peer) {
                return refusal;
            }
            // The sender lives as long as `self` does.
            if settings.changed().await.is_err() {
                std::future::pending::<()>().await;
            }
        }
    }
}

/// The wait for a refusal, inside of an open connection.
pub(crate) struct Watch {
    refused: Pin<Box<dyn Future<Output = rustls::Error> + Send + Sync>>,
    host: String,
    found: Option<TlsError>,
}

impl Watch {
    pub(crate) fn new(settings: Reloaded<Mutual>, peer: Peer, host: String) -> Self {
        Self { refused: Box::pin(settings.refused(peer)), host, found: None }
    }

    /// Fails once the other side is refused, and wakes the task then.
    pub(crate) fn check(&mut self, cx: &mut Context<'_>) -> io::Result<()> {
        if self.found.is_none()
            && let Poll::Ready(refusal) = self.refused.as_mut().poll(cx)
        {
            self.found = Some(TlsError::of_fault(&refusal, &self.host));
        }
        match &self.found {
            Some(found) => Err(io::Error::other(found.clone())),
            None => Ok(()),
        }
    }
}

impl fmt::Debug for Watch {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Watch").field("host", &self.host).finish_non_exhaustive()
    }
}

#[cfg(test)]
mod tests;
