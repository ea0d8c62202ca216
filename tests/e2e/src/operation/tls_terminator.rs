//! A program in front of a server that speaks TLS to its clients, with a certificate of a private
//! authority.

use std::{path::Path, sync::Arc};

use bendtwin_tls::{PairPaths, Public};
use tokio::net::{TcpListener, TcpStream};
use tokio_rustls::TlsAcceptor;

use crate::harness::command::run_ok;

/// A proxy that terminates TLS, until it is dropped.
pub(crate) struct TlsTerminator {
    url: String,
    folder: tempfile::TempDir,
    accepting: tokio::task::JoinHandle<()>,
}

impl TlsTerminator {
    /// In front of `host:port`.
    pub(crate) async fn to(server: &str) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name).to_string_lossy().into_owned();
        let ca = path("ca");
        run_ok(&["ca", "init", &ca]);
        run_ok(&[
            "ca",
            "issue",
            &ca,
            "--role",
            "server",
            "--name",
            "server",
            "--host",
            "localhost",
        ]);
        let place = |name: &str| Path::new(&ca).join(name);
        let pair = PairPaths { certificate: place("server.pem"), key: place("server.key") };
        let acceptor = TlsAcceptor::from(Arc::clone(&Public::load(&pair).unwrap().server));
        let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
        let url = format!("https://localhost:{}", listener.local_addr().unwrap().port());
        let server = server.to_owned();
        let accepting = tokio::spawn(async move {
            while let Ok((client, _)) = listener.accept().await {
                let (acceptor, server) = (acceptor.clone(), server.clone());
                tokio::spawn(async move {
                    // One that does not trust the authority ends the handshake.
                    let Ok(mut client) = acceptor.accept(client).await else { return };
                    let mut server = TcpStream::connect(server).await.unwrap();
                    tokio::io::copy_bidirectional(&mut client, &mut server).await.ok();
                });
            }
        });
        Self { url, folder, accepting }
    }

    /// Address for clients.
    pub(crate) fn url(&self) -> &str {
        &self.url
    }

    /// The file with the certificate of its authority.
    pub(crate) fn authority(&self) -> String {
        self.folder.path().join("ca/ca.pem").to_string_lossy().into_owned()
    }
}

impl Drop for TlsTerminator {
    fn drop(&mut self) {
        self.accepting.abort();
    }
}
