//! The connection to a server.

pub(crate) mod channel;
pub(crate) mod http;
pub(crate) mod problem;
mod readiness;

use std::{
    borrow::Cow,
    path::{Path, PathBuf},
    sync::Arc,
    time::Duration,
};

use bendtwin_proto::v1::{
    capture_service_client::CaptureServiceClient,
    evaluation_service_client::EvaluationServiceClient, fit_service_client::FitServiceClient,
    key_service_client::KeyServiceClient, planning_service_client::PlanningServiceClient,
    project_service_client::ProjectServiceClient,
    registration_service_client::RegistrationServiceClient,
    retention_service_client::RetentionServiceClient, rollout_service_client::RolloutServiceClient,
    session_service_client::SessionServiceClient, share_service_client::ShareServiceClient,
    sign_in_service_client::SignInServiceClient, trash_service_client::TrashServiceClient,
    twin_service_client::TwinServiceClient, usage_service_client::UsageServiceClient,
    worker_service_client::WorkerServiceClient,
};
use bendtwin_tls::{ClientConfig, Connector, TlsError, client_config};
use tonic::transport::Endpoint;
use url::Url;

use crate::{
    Captures, Error, Evaluations, Fits, Keys, Plans, Projects, Registrations, Retention, Rollouts,
    Sessions, Shares, SignIns, Trash, Twins, Usage, Workers, token,
};
use channel::Credentials;
use http::Http;

pub(crate) use channel::Channel;
pub use readiness::{Readiness, ReadinessCheck};

/// Longest message that is accepted: the largest reply of a rollout [bytes].
const MAX_MESSAGE: usize = 1 << 30;
/// Longest time for connecting.
const CONNECT_TIMEOUT: Duration = Duration::from_secs(10);
/// The environment variable with the file of the authority of servers' certificates.
pub const CA_VARIABLE: &str = "BENDTWIN_CA";

/// A connection to a server. Clones share it; it reconnects by itself.
#[derive(Clone, Debug)]
pub struct Client {
    /// Without a slash at the end.
    url: String,
    channel: Channel,
    http: Http,
}

impl Client {
    /// Connects to a server, for example `http://127.0.0.1:7070` or `localhost:7070`, with the
    /// token that [`token::find`] has for it.
    ///
    /// # Errors
    /// If the address is neither a URL nor a host, or nothing answers there; or if the file of a
    /// token cannot be used.
    pub async fn connect(url: &str) -> Result<Self, Error> {
        let url = complete(url);
        Self::connect_with_token(&url, token::find(&url)?.as_deref()).await
    }

    /// Connects to a server with a token, or without one. For `https` the authority of its
    /// certificate is in the file that `BENDTWIN_CA` names, or else among those of the system.
    ///
    /// # Errors
    /// Those of [`Client::connect`]; or if the token cannot be sent in a header.
    pub async fn connect_with_token(url: &str, token: Option<&str>) -> Result<Self, Error> {
        let ca = std::env::var_os(CA_VARIABLE).filter(|path| !path.is_empty()).map(PathBuf::from);
        Self::connect_with(url, token, ca.as_deref()).await
    }

    /// Connects to a server with a token, or without one. For `https` the authority of its
    /// certificate is in that file (PEM), or else among those of the system.
    ///
    /// # Errors
    /// Those of [`Client::connect_with_token`]; or if the file cannot be used, or the certificate of the
    /// server is not accepted.
    pub async fn connect_with(
        url: &str,
        token: Option<&str>,
        ca: Option<&Path>,
    ) -> Result<Self, Error> {
        let (given, url) = (url, &*complete(url));
        let invalid = || {
            Error::invalid(format!(
                "`{given}` is no server address: give one like http://127.0.0.1:7070"
            ))
        };
        let parsed = Url::parse(url).map_err(|_| invalid())?;
        let is_https = match parsed.scheme() {
            "http" => false,
            "https" => true,
            _ => return Err(invalid()),
        };
        if !parsed.has_host() {
            return Err(invalid());
        }
        let credentials = Credentials::new(token)?;
        let tls = if is_https { Some(trusting(ca)?) } else { None };
        let endpoint = Endpoint::from_shared(url.to_owned())
            .map_err(|_| invalid())?
            // Rollouts send and receive megabytes: windows of 64 KiB would wait for the round trip.
            .initial_stream_window_size(8 << 20)
            .initial_connection_window_size(16 << 20);
        let channel = endpoint.connect_with_connector(connector(tls.as_ref(), b"h2")).await;
        let channel = Channel::new(channel.map_err(|e| unreachable(url, &e))?, credentials);
        let http = Http::new(connector(tls.as_ref(), b"http/1.1"), token)?;
        Ok(Self { url: url.to_owned(), channel, http })
    }

    /// The address of the server.
    pub fn url(&self) -> &str {
        &self.url
    }

    /// State of the server, which needs no token.
    ///
    /// # Errors
    /// If nothing answers, or what answers is no server of BendTwin.
    pub async fn readiness(&self) -> Result<Readiness, Error> {
        Readiness::of(&self.http, &self.url).await
    }

    /// Recordings.
    pub fn captures(&self) -> Captures {
        let service = CaptureServiceClient::new(self.channel.clone());
        Captures::new(service, self.http.clone(), self.url.clone())
    }

    /// Fit jobs.
    pub fn fits(&self) -> Fits {
        Fits::new(FitServiceClient::new(self.channel.clone()))
    }

    /// Fitted twins.
    pub fn twins(&self) -> Twins {
        let service = TwinServiceClient::new(self.channel.clone());
        Twins::new(service.max_decoding_message_size(MAX_MESSAGE))
    }

    /// What was deleted and can be restored.
    pub fn trash(&self) -> Trash {
        Trash::new(TrashServiceClient::new(self.channel.clone()))
    }

    /// Rules by which the server deletes.
    pub fn retention(&self) -> Retention {
        Retention::new(RetentionServiceClient::new(self.channel.clone()))
    }

    /// Keys of clients.
    pub fn keys(&self) -> Keys {
        Keys::new(KeyServiceClient::new(self.channel.clone()))
    }

    /// Links by which people without a token play with twins.
    pub fn shares(&self) -> Shares {
        Shares::new(ShareServiceClient::new(self.channel.clone()), self.url.clone())
    }

    /// Projects of owners.
    pub fn projects(&self) -> Projects {
        Projects::new(ProjectServiceClient::new(self.channel.clone()))
    }

    /// What is stored for the owners of keys, and their jobs.
    pub fn usage(&self) -> Usage {
        Usage::new(UsageServiceClient::new(self.channel.clone()))
    }

    /// Sign-ins of people.
    pub fn sign_ins(&self) -> SignIns {
        SignIns::new(SignInServiceClient::new(self.channel.clone()))
    }

    /// Worker processes that the server knows.
    pub fn workers(&self) -> Workers {
        Workers::new(WorkerServiceClient::new(self.channel.clone()))
    }

    /// Evaluations: twins beside recordings.
    pub fn evaluations(&self) -> Evaluations {
        Evaluations::new(EvaluationServiceClient::new(self.channel.clone()))
    }

    /// Registrations: states from what was seen.
    pub fn registrations(&self) -> Registrations {
        let service = RegistrationServiceClient::new(self.channel.clone());
        Registrations::new(service.max_decoding_message_size(MAX_MESSAGE))
    }

    /// Predictions.
    pub fn rollouts(&self) -> Rollouts {
        let service = RolloutServiceClient::new(self.channel.clone());
        Rollouts::new(service.max_decoding_message_size(MAX_MESSAGE))
    }

    /// Simulations that stay at a worker between calls.
    pub fn sessions(&self) -> Sessions {
        let service = SessionServiceClient::new(self.channel.clone());
        Sessions::new(service.max_decoding_message_size(MAX_MESSAGE))
    }

    /// Plans made at the server.
    pub fn plans(&self) -> Plans {
        let service = PlanningServiceClient::new(self.channel.clone());
        Plans::new(service.max_decoding_message_size(MAX_MESSAGE))
    }
}

/// The address as a URL: `localhost:7070` is `http://localhost:7070`.
pub(crate) fn complete(address: &str) -> Cow<'_, str> {
    let address = address.trim_end_matches('/');
    if address.contains("://") { address.into() } else { format!("http://{address}").into() }
}

/// Settings that trust the authorities of a file, or those of the system.
fn trusting(ca: Option<&Path>) -> Result<ClientConfig, Error> {
    client_config(ca).map_err(|e| Error::of(&e))
}

/// A connector, for one protocol if it has TLS.
fn connector(tls: Option<&ClientConfig>, protocol: &[u8]) -> Connector {
    let connector = Connector::new(CONNECT_TIMEOUT);
    let Some(tls) = tls else { return connector };
    let mut settings = tls.clone();
    settings.alpn_protocols = vec![protocol.to_vec()];
    let settings = Arc::new(settings);
    connector.with_tls(move || settings.clone())
}

/// The error of a server that was not reached, or not by TLS.
pub(crate) fn unreachable(url: &str, error: &(dyn std::error::Error + 'static)) -> Error {
    match TlsError::find(error, url) {
        Some(found) => Error::of(&found),
        None => Error::of_http1(url, error)
            .unwrap_or_else(|| Error::unreachable(url, innermost_cause(error))),
    }
}

/// The innermost cause, which says more than `transport error`.
pub(crate) fn innermost_cause<'a>(
    error: &'a (dyn std::error::Error + 'static),
) -> &'a (dyn std::error::Error + 'static) {
    std::iter::successors(Some(error), |e| e.source()).last().unwrap_or(error)
}

#[cfg(test)]
mod tests {
    use tokio::io::{AsyncReadExt as _, AsyncWriteExt as _};

    use super::*;

    #[test]
    fn an_address_without_a_scheme_is_one_of_http() {
        for (given, url) in [
            ("localhost:7070", "http://localhost:7070"),
            ("10.0.0.7:80/", "http://10.0.0.7:80"),
            ("[::1]:7070", "http://[::1]:7070"),
            ("http://127.0.0.1:7070/", "http://127.0.0.1:7070"),
        ] {
            assert_eq!(complete(given), url);
        }
    }

    /// A proxy that passes HTTP/1 alone.
    #[tokio::test]
    async fn an_answer_of_http1_is_explained() {
        let listener = tokio::net::TcpListener::bind("127.0.0.1:0").await.unwrap();
        let url = format!("http://{}", listener.local_addr().unwrap());
        tokio::spawn(async move {
            while let Ok((mut stream, _)) = listener.accept().await {
                let mut bytes = [0; 1024];
                // The beginning of the request, which does not matter.
                let _ = stream.read(&mut bytes).await.is_ok_and(|length| length > 0);
                let answer =
                    b"HTTP/1.1 400 Bad Request\r\nconnection: close\r\n\r\n<html>no</html>";
                stream.write_all(answer).await.ok();
                // The end of the connection would be another error.
                while stream.read(&mut bytes).await.is_ok_and(|length| length > 0) {}
            }
        });
        let error = match Client::connect_with_token(&url, None).await {
            Ok(client) => client.workers().all().await.unwrap_err(),
            Err(error) => error,
        };
        assert_eq!(error.reason(), "PROXY_WITHOUT_GRPC", "{error}");
        assert!(error.message().contains("grpc_pass"), "{error}");
    }

    #[tokio::test]
    async fn an_invalid_address_is_quoted_in_the_error() {
        for given in ["ftp://twin.example", "a b", ""] {
            let error = Client::connect_with_token(given, None).await.unwrap_err();
            assert!(
                error.to_string().contains(&format!("`{given}` is no server address")),
                "{error}"
            );
        }
    }
}
