//! The health of a worker as another process of its machine sees it: for the health checks of
//! containers. The worker's port is asked, with the worker's own certificate.

use std::{net::SocketAddr, time::Duration};

use bendtwin_proto::worker::v1::worker_rollouts_server::SERVICE_NAME;
use bendtwin_tls::{Connector, Mutual, MutualPaths};
use tonic::{Code, Status, transport::Endpoint};
use tonic_health::pb::{
    HealthCheckRequest, health_check_response::ServingStatus, health_client::HealthClient,
};

use crate::Error;

/// Health of a worker.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Health {
    /// The worker is registered and answers rollouts.
    Serving,
    /// The worker answers, and no server has registered it yet.
    NotRegistered,
    /// The worker does not answer, for this reason.
    Silent(String),
}

/// Asks the worker at an address, which answers within `timeout` if it is healthy.
///
/// # Errors
/// If the files of the worker's certificate cannot be used.
pub async fn health(
    address: SocketAddr,
    tls: Option<&MutualPaths>,
    timeout: Duration,
) -> Result<Health, Error> {
    let connector = Connector::new(timeout).at(address);
    let (url, connector) = match tls.map(Mutual::load).transpose()? {
        None => (format!("http://{address}"), connector),
        Some(own) => {
            // The certificate is for its names, not for the address of the loopback interface.
            let hosts = own.certificate.as_ref().map(|shown| &*shown.hosts).unwrap_or_default();
            let host = hosts.first().map(|host| host.replacen('*', "worker", 1));
            let host = host.unwrap_or_else(|| address.ip().to_string());
            let host = if host.contains(':') { format!("[{host}]") } else { host };
            let client = own.client;
            let url = format!("https://{host}:{}", address.port());
            (url, connector.with_tls(move || client.clone()))
        }
    };
    let endpoint = Endpoint::from_shared(url.clone()).map_err(|_| Error::Address { url })?;
    let mut client = HealthClient::new(endpoint.connect_with_connector_lazy(connector));
    let request = HealthCheckRequest { service: SERVICE_NAME.to_owned() };
    let answer = tokio::time::timeout(timeout, client.check(request)).await;
    let answer = answer.unwrap_or_else(|_| Err(Status::deadline_exceeded("no answer in time")));
    Ok(match answer {
        Ok(answer) if answer.get_ref().status() == ServingStatus::Serving => Health::Serving,
        Ok(_) => Health::NotRegistered,
        Err(status) if status.code() == Code::NotFound => {
            Health::Silent("what answers there is not a worker".to_owned())
        }
        Err(status) => Health::Silent(reason(&status)),
    })
}

/// The innermost cause: that of the transport is in the sources of a status.
fn reason(status: &Status) -> String {
    let mut cause: &dyn std::error::Error = status;
    while let Some(source) = cause.source() {
        cause = source;
    }
    if std::ptr::addr_eq(cause, status) { status.message().to_owned() } else { cause.to_string() }
}
