//! The state of a server, as `/readyz` tells it to everyone.

use std::time::Duration;

use bendtwin_core::Category;
use serde::Deserialize;

use crate::{Error, client};

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

/// One condition.
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
    pub(crate) async fn of(http: &reqwest::Client, url: &str) -> Result<Self, Error> {
        let request = http.get(format!("{url}/readyz")).timeout(TIMEOUT);
        let reply = request.send().await;
        let reply = reply.map_err(|e| Error::unreachable(url, client::innermost_cause(&e)))?;
        // 503 has the same document as 200.
        reply.json().await.map_err(|_| {
            let message = format!("{url} answers, but not as a server of BendTwin does");
            Error::new(Category::FailedPrecondition, "NOT_BENDTWIN", message)
        })
    }
}
