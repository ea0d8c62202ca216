//! Requests to the identity provider. Each has bounds on its time and on the length of the answer;
//! redirects are not followed.

use std::{path::Path, sync::Arc, time::Duration};

use axum::http::{HeaderValue, Method, Request, StatusCode, header, request::Builder};
use bendtwin_tls::{Connector, FileError, TlsError, client_config};
use bytes::Bytes;
use http_body_util::{BodyExt as _, Full, Limited};
use hyper_util::{
    client::legacy::Client,
    rt::{TokioExecutor, TokioTimer},
};
use url::Url;

use super::error::{Error, plain};

const CONNECT_TIMEOUT: Duration = Duration::from_secs(5);
/// Time limit of a request, up to the end of its answer.
const TIMEOUT: Duration = Duration::from_secs(10);
/// Longest answer [bytes].
const LONGEST: usize = 256 << 10;
/// Time for which a connection is kept for the next request.
const KEPT: Duration = Duration::from_secs(20);

/// The client of the provider.
#[derive(Debug)]
pub(super) struct Http {
    client: Client<Connector, Full<Bytes>>,
}

/// An answer.
#[derive(Debug)]
pub(super) struct Answer {
    pub(super) status: StatusCode,
    pub(super) body: Bytes,
}

impl Http {
    /// A client that trusts the authorities of a file, or those of the system; one without TLS for a
    /// provider on this machine.
    pub(super) fn new(ca: Option<&Path>, has_tls: bool) -> Result<Self, FileError> {
        let mut connector = Connector::new(CONNECT_TIMEOUT);
        if has_tls {
            let mut settings = client_config(ca)?;
            settings.alpn_protocols = vec![b"http/1.1".to_vec()];
            let settings = Arc::new(settings);
            connector = connector.with_tls(move || settings.clone());
        }
        let client = Client::builder(TokioExecutor::new())
            .pool_idle_timeout(KEPT)
            .pool_timer(TokioTimer::new())
            .build(connector);
        Ok(Self { client })
    }

    /// Reads a document, perhaps with credentials.
    pub(super) async fn get(
        &self,
        url: &str,
        credentials: Option<HeaderValue>,
    ) -> Result<Answer, Error> {
        self.send(request(Method::GET, url, credentials), Bytes::new(), url).await
    }

    /// Posts a form, perhaps with credentials.
    pub(super) async fn post(
        &self,
        url: &str,
        form: String,
        credentials: Option<HeaderValue>,
    ) -> Result<Answer, Error> {
        let form_type = "application/x-www-form-urlencoded";
        let request = request(Method::POST, url, credentials);
        self.send(request.header(header::CONTENT_TYPE, form_type), form.into(), url).await
    }

    async fn send(&self, request: Builder, body: Bytes, url: &str) -> Result<Answer, Error> {
        let request = request
            .body(Full::new(body))
            .map_err(|e| Error::Unusable { what: "an address", fault: e.to_string() })?;
        let exchange = async {
            let sent = self.client.request(request).await;
            let (head, body) = sent.map_err(|e| away(url, &e))?.into_parts();
            let body = Limited::new(body, LONGEST).collect().await.map_err(|error| {
                match error.downcast_ref::<http_body_util::LengthLimitError>() {
                    Some(_) => Error::Unusable {
                        what: "an answer",
                        fault: format!("it is longer than {LONGEST} bytes"),
                    },
                    None => away(url, &*error),
                }
            })?;
            Ok(Answer { status: head.status, body: body.to_bytes() })
        };
        match tokio::time::timeout(TIMEOUT, exchange).await {
            Ok(answer) => answer,
            Err(_) => Err(Error::Away(format!("it took longer than {} s", TIMEOUT.as_secs()))),
        }
    }
}

fn request(method: Method, url: &str, credentials: Option<HeaderValue>) -> Builder {
    let request =
        Request::builder().method(method).uri(url).header(header::ACCEPT, "application/json");
    match credentials {
        Some(credentials) => request.header(header::AUTHORIZATION, credentials),
        None => request,
    }
}

fn away(url: &str, error: &(dyn std::error::Error + 'static)) -> Error {
    let host = Url::parse(url).ok().and_then(|url| url.host_str().map(str::to_owned));
    if let Some(found) = TlsError::find(error, host.as_deref().unwrap_or(url)) {
        return Error::Away(plain(&found.with_authority_in("option sign_in.ca").to_string()));
    }
    let cause = std::iter::successors(Some(error), |e| e.source()).last().unwrap_or(error);
    Error::Away(plain(&cause.to_string()))
}

#[cfg(test)]
mod tests {
    use std::io;

    use rustls::{CertificateError, Error as Fault};

    use super::*;

    #[test]
    fn an_authority_that_is_missing_is_an_option() {
        let fault = Fault::InvalidCertificate(CertificateError::UnknownIssuer);
        let error = io::Error::other(fault);
        let text = away("https://id.example/realms/lab/token?a=b", &error).to_string();
        assert!(
            text.contains("of id.example is") && text.contains("(option sign_in.ca)"),
            "{text}"
        );
        assert!(!text.contains("--ca"), "{text}");
    }
}
