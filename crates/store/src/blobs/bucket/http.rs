//! The HTTP client for a bucket: that of hyper, with the TLS that everything else here has. Without it
//! object_store brings a second client with a second TLS.

use std::{error::Error as StdError, future::Future, pin::Pin, sync::Arc, time::Duration};

use bendtwin_tls::ClientConfig;
use http_body_util::BodyExt as _;
use hyper_util::{
    client::legacy::{Client, Error},
    rt::TokioExecutor,
};
use object_store::{
    ClientConfigKey, ClientOptions,
    client::{
        HttpClient, HttpConnector, HttpError, HttpErrorKind, HttpRequest, HttpRequestBody,
        HttpResponse, HttpResponseBody, HttpService,
    },
};

const CONNECT_TIMEOUT: Duration = Duration::from_secs(5);
/// Time limit of one attempt, up to the first byte of its answer.
const ATTEMPT_TIMEOUT: Duration = Duration::from_secs(30);
/// Time for which a connection is kept for the next request.
const KEPT: Duration = Duration::from_secs(20);

/// Factory of clients with these settings of TLS.
#[derive(Debug)]
pub(super) struct Connector(pub(super) Arc<ClientConfig>);

#[derive(Debug)]
struct Http {
    client: Client<bendtwin_tls::Connector, HttpRequestBody>,
    /// True if requests without TLS are sent.
    plain: bool,
}

impl HttpConnector for Connector {
    fn connect(&self, options: &ClientOptions) -> object_store::Result<HttpClient> {
        let plain =
            options.get_config_value(&ClientConfigKey::AllowHttp).as_deref() == Some("true");
        let settings = self.0.clone();
        let connector =
            bendtwin_tls::Connector::new(CONNECT_TIMEOUT).with_tls(move || settings.clone());
        let client = Client::builder(TokioExecutor::new())
            .pool_idle_timeout(KEPT)
            .pool_timer(hyper_util::rt::TokioTimer::new())
            .build(connector);
        Ok(HttpClient::new(Http { client, plain }))
    }
}

impl HttpService for Http {
    fn call<'a, 'b>(
        &'a self,
        request: HttpRequest,
    ) -> Pin<Box<dyn Future<Output = Result<HttpResponse, HttpError>> + Send + 'b>>
    where
        'a: 'b,
        Self: 'b,
    {
        Box::pin(async move {
            if !self.plain && request.uri().scheme_str() != Some("https") {
                let refused = std::io::Error::other("it is to be asked over TLS alone");
                return Err(HttpError::new(HttpErrorKind::Unknown, refused));
            }
            let answer = tokio::time::timeout(ATTEMPT_TIMEOUT, self.client.request(request)).await;
            let answer = answer.map_err(|late| HttpError::new(HttpErrorKind::Timeout, late))?;
            let (parts, body) = answer.map_err(failed)?.into_parts();
            let body = body.map_err(|error| HttpError::new(kind(&error), error));
            Ok(HttpResponse::from_parts(parts, HttpResponseBody::new(body)))
        })
    }
}

fn failed(error: Error) -> HttpError {
    let kind = if error.is_connect() { HttpErrorKind::Connect } else { kind(&error) };
    HttpError::new(kind, error)
}

/// The kind of an error, by which it is tried again or not.
fn kind(error: &(dyn StdError + 'static)) -> HttpErrorKind {
    let mut source = Some(error);
    while let Some(error) = source {
        if let Some(error) = error.downcast_ref::<hyper::Error>()
            && (error.is_closed() || error.is_incomplete_message() || error.is_canceled())
        {
            return HttpErrorKind::Request;
        }
        if error.is::<std::io::Error>() {
            return HttpErrorKind::Interrupted;
        }
        source = error.source();
    }
    HttpErrorKind::Unknown
}
