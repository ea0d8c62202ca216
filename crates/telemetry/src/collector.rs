//! The connection to a collector over TLS. The exporter's own would bring a second set of settings.

use std::{env, path::PathBuf, sync::Arc, time::Duration};

use bendtwin_tls::{Connector, client_config};
use tonic::transport::{Channel, Endpoint};

use crate::Error;

/// Variables that name the collector; the first that is set counts.
const ENDPOINTS: [&str; 2] = ["OTEL_EXPORTER_OTLP_TRACES_ENDPOINT", "OTEL_EXPORTER_OTLP_ENDPOINT"];
/// Variables that name a file with its authority, if that is not one of the system's.
const AUTHORITIES: [&str; 2] =
    ["OTEL_EXPORTER_OTLP_TRACES_CERTIFICATE", "OTEL_EXPORTER_OTLP_CERTIFICATE"];
/// Longest time for connecting, and for an answer.
const TIMEOUT: Duration = Duration::from_secs(10);

/// Address of the collector, if there is one.
pub(crate) fn endpoint() -> Option<String> {
    first(ENDPOINTS)
}

/// A channel that connects with the first spans.
///
/// # Errors
/// If the address or the file of the authority cannot be used.
pub(crate) fn with_tls(endpoint: String) -> Result<Channel, Error> {
    let mut settings = client_config(first(AUTHORITIES).map(PathBuf::from).as_deref())?;
    settings.alpn_protocols = vec![b"h2".to_vec()];
    let settings = Arc::new(settings);
    let connector = Connector::new(TIMEOUT).with_tls(move || settings.clone());
    let endpoint = Endpoint::from_shared(endpoint)?.timeout(TIMEOUT);
    Ok(endpoint.connect_with_connector_lazy(connector))
}

fn first(names: [&str; 2]) -> Option<String> {
    names.into_iter().find_map(|name| env::var(name).ok().filter(|value| !value.is_empty()))
}
