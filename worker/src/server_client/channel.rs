//! The channel to the server.

use std::time::Duration;

use bendtwin_tls::{Connector, Mutual, Reloaded};
use tonic::transport::{Channel, Endpoint};

use crate::Error;

/// Longest time for connecting, TLS included.
const CONNECT_TIMEOUT: Duration = Duration::from_secs(5);

/// A channel to a server, which connects with the first call.
pub(super) fn open(server: &str, tls: Option<&Reloaded<Mutual>>) -> Result<Channel, Error> {
    let endpoint = Endpoint::from_shared(server.to_owned())
        .map_err(|_| Error::Address { url: server.to_owned() })?;
    let connector = Connector::new(CONNECT_TIMEOUT);
    let connector = match tls.cloned() {
        Some(tls) => connector.with_peer(tls),
        None => connector,
    };
    Ok(endpoint
        .http2_keep_alive_interval(Duration::from_secs(10))
        .keep_alive_timeout(Duration::from_secs(10))
        .keep_alive_while_idle(true)
        .connect_with_connector_lazy(connector))
}
