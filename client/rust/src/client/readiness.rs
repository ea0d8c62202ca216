//! The state of a server, from `/readyz`.

use std::time::Duration;

use bendtwin_core::Category;
use hyper::{Method, StatusCode};
use serde::Deserialize;

use super::{http::Http, problem};
use crate::Error;

/// Longest time for the answer, in which the server may prove that its disk can be written.
const TIMEOUT: Duration = Duration::from_secs(10);

/// State of a server.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
pub struct Readiness {
    /// True if all checks are met.
    pub ready: bool,
    /// The conditions of being ready.
    pub checks: Vec<ReadinessCheck>,
    /// Name and version of its program.
    pub build: String,
}

/// A condition of readiness.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
pub struct ReadinessCheck {
    /// `running`, `writes`, `disk` or `workers`.
    pub name: String,
    /// True if it is met.
    pub ok: bool,
    /// The state found, and what to do if it is not met.
    pub message: String,
}

impl Readiness {
    pub(crate) async fn of(http: &Http, url: &str) -> Result<Self, Error> {
        let request = http.request(Method::GET, &format!("{url}/readyz")).send();
        let reply = tokio::time::timeout(TIMEOUT, request).await;
        let reply = reply.map_err(|_| Error::unreachable(url, "it does not answer in time"))??;
        // 503 has the same document as 200; any other status is an error.
        if !reply.status.is_success() && reply.status != StatusCode::SERVICE_UNAVAILABLE {
            return Err(problem::success(reply).await.err().unwrap_or_else(|| not_bendtwin(url)));
        }
        reply.json().await.map_err(|_| not_bendtwin(url))
    }
}

fn not_bendtwin(url: &str) -> Error {
    let message = format!("{url} answers, but not as a server of BendTwin does");
    Error::new(Category::FailedPrecondition, "NOT_BENDTWIN", message)
}
