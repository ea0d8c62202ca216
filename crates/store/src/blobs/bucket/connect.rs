//! The connection to a bucket: its options from the environment, and the meaning of its errors.

use std::{path::PathBuf, time::Duration};

use bendtwin_tls::{TlsError, client_config};
use object_store::{
    BackoffConfig, RetryConfig,
    aws::{AmazonS3Builder, AmazonS3ConfigKey},
    path::Path,
};
use tokio::sync::Semaphore;

use super::{Bucket, SENDERS, http::Connector};
use crate::{Error, Result, store::meter::Meter};

/// Time after which a request that failed is not tried again.
const RETRY_TIMEOUT: Duration = Duration::from_secs(10);
const MOST_RETRIES: usize = 6;
const FIRST_BACKOFF: Duration = Duration::from_millis(100);
const LONGEST_BACKOFF: Duration = Duration::from_secs(2);
/// Variable that names a file with the authorities of the endpoint, as for AWS's own programs.
const AUTHORITIES: &str = "AWS_CA_BUNDLE";

impl Bucket {
    /// A bucket, with credentials, region and endpoint from the environment (`AWS_*`), else
    /// credentials of the machine's role. Nothing is asked of it yet.
    ///
    /// # Errors
    /// If the environment does not name one, or a file of authorities that cannot be used.
    pub(crate) fn open(bucket: &str, prefix: Path, meter: Meter) -> Result<Self> {
        let backoff =
            BackoffConfig { init_backoff: FIRST_BACKOFF, max_backoff: LONGEST_BACKOFF, base: 2.0 };
        let retry =
            RetryConfig { backoff, max_retries: MOST_RETRIES, retry_timeout: RETRY_TIMEOUT };
        let authorities = std::env::var_os(AUTHORITIES).filter(|path| !path.is_empty());
        let mut tls = client_config(authorities.map(PathBuf::from).as_deref())?;
        tls.alpn_protocols = vec![b"http/1.1".to_vec()];
        let connector = Connector(tls.into());
        let builder = environment().with_http_connector(connector).with_retry(retry);
        let keys = [AmazonS3ConfigKey::S3Endpoint, AmazonS3ConfigKey::Endpoint];
        let endpoint = keys.iter().find_map(|key| builder.get_config_value(key));
        // Unencrypted only if the address says so explicitly.
        let is_plain = endpoint.is_some_and(|endpoint| endpoint.starts_with("http://"));
        let store = builder
            .with_allow_http(is_plain)
            .with_bucket_name(bucket)
            .with_disable_bulk_delete(true)
            .with_disable_tagging(true)
            .build()
            .map_err(|error| refused(error.to_string()))?;
        let name = match prefix.as_ref() {
            "" => format!("s3://{bucket}"),
            prefix => format!("s3://{bucket}/{prefix}"),
        };
        Ok(Self { store, prefix, name, senders: Semaphore::new(SENDERS), meter })
    }
}

/// Options of S3 in the environment.
#[cfg(not(test))]
fn environment() -> AmazonS3Builder {
    AmazonS3Builder::from_env()
}

/// The server of the tests.
#[cfg(test)]
fn environment() -> AmazonS3Builder {
    let endpoint = std::env::var("BENDTWIN_TEST_S3").unwrap_or("http://127.0.0.1:1".to_owned());
    // One that checks no signatures takes any.
    let key = std::env::var("BENDTWIN_TEST_S3_KEY").unwrap_or("test:test".to_owned());
    let (id, secret) = key.split_once(':').unwrap();
    AmazonS3Builder::new()
        .with_endpoint(endpoint)
        .with_access_key_id(id)
        .with_secret_access_key(secret)
}

/// The store's error for an error of a request. A missing object stays as such.
pub(super) fn failed(error: object_store::Error) -> Error {
    let text = error.to_string();
    if let Some(fault) = TlsError::find(&error, "the object storage") {
        return Error::ObjectsUntrusted { fault: fault.with_authority_in(AUTHORITIES) };
    }
    match &error {
        object_store::Error::NotFound { .. } if !text.contains("NoSuchBucket") => error.into(),
        object_store::Error::NotFound { .. } => refused("the bucket does not exist".to_owned()),
        object_store::Error::PermissionDenied { .. }
        | object_store::Error::Unauthenticated { .. } => of_keys(&error),
        _ if is_of_keys(&text) => of_keys(&error),
        _ if is_refusal(&text) => {
            tracing::warn!(%error, "the bucket refuses a request");
            refused("the region or the endpoint is wrong, or the request is not known there".into())
        }
        _ => {
            tracing::warn!(%error, "the bucket does not answer");
            Error::ObjectsUnavailable
        }
    }
}

/// The refusal of a request for its keys.
fn of_keys(error: &object_store::Error) -> Error {
    tracing::warn!(%error, "the bucket refuses a request");
    refused("the keys are wrong or do not allow it".to_owned())
}

/// True if a server answered that the keys are wrong or lack the permission. Not every request
/// turns that into a separate error.
fn is_of_keys(text: &str) -> bool {
    ["401", "403"].iter().any(|code| text.contains(&format!("status code: {code}")))
}

/// True if a server answered that it will not, which it would answer again.
fn is_refusal(text: &str) -> bool {
    let client_fault = text.contains("status code: 4")
        && !["408", "409", "429"].iter().any(|code| text.contains(&format!("status code: {code}")));
    client_fault || text.contains("redirect without LOCATION")
}

fn refused(fault: String) -> Error {
    Error::ObjectsRefused { fault }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn refusals_differ_from_silence() {
        assert!(is_of_keys("Server returned non-2xx status code: 403 Forbidden: wrong signature"));
        assert!(!is_of_keys("Server returned non-2xx status code: 400 Bad Request"));
        assert!(is_refusal("Server returned non-2xx status code: 400 Bad Request: wrong region"));
        assert!(!is_refusal("Server returned non-2xx status code: 503 Slow down"));
        assert!(!is_refusal("Server returned non-2xx status code: 429 Too many requests"));
        assert!(!is_refusal("error sending request"));
    }
}
