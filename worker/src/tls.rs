//! TLS of a worker on another host: its certificate, and the connections that the server begins.

use std::{io, sync::Arc, time::Duration};

use bendtwin_tls::{
    Accepted, Certificate, Mutual, MutualPaths, Reloaded, Stream, tell, tell_lists,
};
use tokio::{
    net::{TcpListener, TcpStream},
    sync::{Semaphore, mpsc},
};
use tokio_stream::wrappers::ReceiverStream;
use tonic::codegen::http::Uri;

use crate::Error;

/// Longest time of a handshake.
const TIMEOUT: Duration = Duration::from_secs(10);
/// Most handshakes at a time: only servers connect, and these few times.
const MOST: usize = 64;

/// The settings of these files, made again when they change.
pub(crate) fn load(paths: &MutualPaths) -> Result<Reloaded<Mutual>, Error> {
    let paths = paths.clone();
    let loaded = Reloaded::new(paths.all(), move || {
        let loaded = Mutual::load(&paths)?;
        tell("worker", loaded.certificate.as_ref());
        tell_lists("worker", &loaded.lists);
        Ok(loaded)
    });
    Ok(loaded?)
}

/// Checks that the server will accept the certificate at this endpoint: else it would take jobs, and
/// no rollout would reach it.
pub(crate) fn check_endpoint(
    endpoint: &str,
    certificate: Option<&Certificate>,
) -> Result<(), Error> {
    let uri = endpoint.parse::<Uri>().ok();
    let host = uri.as_ref().and_then(Uri::host).unwrap_or_default();
    let host = host.trim_start_matches('[').trim_end_matches(']');
    let hosts = certificate.map(|found| &*found.hosts).unwrap_or_default();
    if hosts.iter().any(|name| name.starts_with("*.") || name.eq_ignore_ascii_case(host)) {
        return Ok(());
    }
    let hosts = hosts.join(", ");
    Err(Error::Options(format!(
        "the server is to reach this worker at {endpoint}, and its certificate is for {hosts}: have \
         one issued with --host {host}, or name another address with --worker-listen or --advertise"
    )))
}

/// Connections of those who show a certificate of the authority.
pub(crate) fn incoming(
    listener: TcpListener,
    settings: Reloaded<Mutual>,
) -> ReceiverStream<io::Result<Stream>> {
    let (sender, receiver) = mpsc::channel(MOST);
    let places = Arc::new(Semaphore::new(MOST));
    tokio::spawn(async move {
        loop {
            let accepted = tokio::select! {
                () = sender.closed() => return,
                accepted = listener.accept() => accepted,
            };
            let Ok((stream, peer)) = accepted else {
                // Out of file descriptors, for example: others may close theirs.
                tokio::time::sleep(Duration::from_millis(50)).await;
                continue;
            };
            let Ok(place) = places.clone().try_acquire_owned() else { continue };
            let (settings, sender) = (settings.clone(), sender.clone());
            tokio::spawn(async move {
                let shaken = tokio::time::timeout(TIMEOUT, shake_hands(settings, stream)).await;
                drop(place);
                match shaken.unwrap_or_else(|_| Err(io::ErrorKind::TimedOut.into())) {
                    Ok(stream) => drop(sender.send(Ok(stream)).await),
                    Err(error) => tracing::warn!(%peer, %error, "TLS handshake failed"),
                }
            });
        }
    });
    ReceiverStream::new(receiver)
}

async fn shake_hands(settings: Reloaded<Mutual>, stream: TcpStream) -> io::Result<Stream> {
    stream.set_nodelay(true)?;
    let accepted = Accepted::shake_hands(settings.get().server.clone(), stream).await?;
    Ok(accepted.among_peers(settings))
}
