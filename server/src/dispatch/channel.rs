//! Channels to the endpoints of workers.

use std::time::Duration;

use bendtwin_tls::Connector;
use tonic::transport::{Channel, Endpoint};

use crate::error::{Error, Result};

/// Replies of many megabytes should not wait for window updates.
const WINDOW: u32 = 16 << 20;

/// A channel to a worker, which connects with the first call. One of `https` takes a dialer with
/// the server's certificate.
pub(super) fn open(url: &str, dialer: &Connector) -> Result<Channel> {
    let endpoint = Endpoint::from_shared(url.to_owned()).ok().filter(|e| e.uri().host().is_some());
    let fault = match endpoint.as_ref().and_then(|e| e.uri().scheme_str()) {
        Some("http") => None,
        Some("https") if dialer.has_tls() => None,
        Some("https") => Some("is https, and this server has no certificate for its workers"),
        _ => Some("is not of the form http://host:port or https://host:port"),
    };
    let endpoint = match (endpoint, fault) {
        (Some(endpoint), None) => endpoint,
        (_, fault) => return Err(Error::invalid("endpoint", fault.unwrap_or("is no URL"))),
    };
    Ok(endpoint
        .initial_stream_window_size(WINDOW)
        .initial_connection_window_size(WINDOW)
        .http2_keep_alive_interval(Duration::from_secs(10))
        .keep_alive_timeout(Duration::from_secs(10))
        .connect_with_connector_lazy(dialer.clone()))
}
