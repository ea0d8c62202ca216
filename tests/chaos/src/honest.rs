//! Calls as an honest client makes them: tried again until they are answered, under the same
//! request id, and given up only after minutes.

use std::time::{Duration, Instant};

use bendtwin_proto::fault::fault;
use rand::RngExt as _;
use reqwest::{RequestBuilder, StatusCode, header::HeaderMap};
use serde_json::Value;
use tokio::time::{sleep, timeout};
use tonic::{Code, Status};

use crate::run::Run;

/// Time for one attempt: longer than the longest pause of a process.
const ATTEMPT: Duration = Duration::from_secs(15);
/// Time after which the server has to be restarted by hand.
const PATIENCE: Duration = Duration::from_secs(60);
/// Time after which a call is given up.
const GIVE_UP: Duration = Duration::from_secs(180);

/// An answer that is not the wanted one.
#[derive(Debug)]
pub(crate) enum Refusal {
    /// A later answer may differ.
    Later(String),
    /// Permanent: the reason, and the whole answer.
    Final(String, String),
    /// The server failed, and says so.
    Defect(String),
}

/// Answer to a call.
pub(crate) type Answer<T> = Result<T, Refusal>;

impl Refusal {
    /// True if the call is refused for this reason.
    pub(crate) fn is(&self, wanted: &str) -> bool {
        matches!(self, Self::Final(reason, _) if reason == wanted)
    }
}

/// A status as its caller sees it.
impl From<Status> for Refusal {
    fn from(status: Status) -> Self {
        let fault = fault(&status);
        let text = format!("{}: {}", fault.reason, status.message());
        // A connection that breaks has a code, but no reason of the server's.
        let is_servers = !status.details().is_empty();
        match status.code() {
            Code::InvalidArgument
            | Code::NotFound
            | Code::AlreadyExists
            | Code::PermissionDenied
            | Code::Unauthenticated
            | Code::FailedPrecondition => Self::Final(fault.reason, text),
            Code::Internal | Code::DataLoss if is_servers => Self::Defect(text),
            _ => Self::Later(text),
        }
    }
}

/// Headers and body of a good answer over HTTP.
pub(crate) async fn send(request: RequestBuilder) -> Answer<(HeaderMap, bytes::Bytes)> {
    let later = |error: reqwest::Error| Refusal::Later(error.to_string());
    let reply = request.send().await.map_err(later)?;
    let (status, headers) = (reply.status(), reply.headers().clone());
    let body = reply.bytes().await.map_err(later)?;
    if status.is_success() {
        return Ok((headers, body));
    }
    let problem: Value = serde_json::from_slice(&body).unwrap_or_default();
    // The answer to a HEAD has no body.
    let reason = problem["reason"].as_str().map_or_else(|| status.to_string(), str::to_owned);
    let text = format!("{status} {reason}: {}", problem["detail"].as_str().unwrap_or_default());
    let is_passing = matches!(
        status,
        StatusCode::REQUEST_TIMEOUT
            | StatusCode::LOCKED
            | StatusCode::TOO_MANY_REQUESTS
            | StatusCode::INSUFFICIENT_STORAGE
            | StatusCode::SERVICE_UNAVAILABLE
            | StatusCode::GATEWAY_TIMEOUT
    );
    Err(match status {
        _ if is_passing => Refusal::Later(text),
        StatusCode::INTERNAL_SERVER_ERROR => Refusal::Defect(text),
        _ => Refusal::Final(reason, text),
    })
}

impl Run {
    /// Makes a call until it is answered. A final refusal is the caller's to judge; `None` after
    /// minutes without an answer, which breaks a promise.
    pub(crate) async fn insist<T>(
        &self,
        what: &str,
        mut attempt: impl AsyncFnMut() -> Answer<T>,
    ) -> Option<Answer<T>> {
        let began = Instant::now();
        let mut tries = 0;
        loop {
            tries += 1;
            let refusal = match timeout(ATTEMPT, attempt()).await {
                Ok(Ok(answer)) => {
                    self.tally
                        .took(format!("honest calls: longest wait for {what}"), began.elapsed());
                    return Some(Ok(answer));
                }
                Ok(Err(refusal)) => refusal,
                Err(_) => Refusal::Later(format!("no answer within {ATTEMPT:?}")),
            };
            match refusal {
                Refusal::Final(reason, text) => return Some(Err(Refusal::Final(reason, text))),
                // Tried again, too: once is a broken promise, for ever another one.
                Refusal::Defect(text) => {
                    let case = format_args!("{what}: {text}");
                    self.tally.broken("no honest call is answered with a defect", case);
                }
                Refusal::Later(text) => self.tally.log(format_args!("{what}, try {tries}: {text}")),
            }
            if began.elapsed() > PATIENCE {
                self.system.restart_by_hand(&format!("{what}: no answer for {PATIENCE:?}"));
            }
            if began.elapsed() > GIVE_UP {
                self.tally.broken(
                    "honest calls are answered",
                    format_args!("{what}: not within {GIVE_UP:?}"),
                );
                return None;
            }
            let wait = rand::rng().random_range(50..300);
            sleep(Duration::from_millis(wait)).await;
        }
    }

    /// The answer to a call that cannot be refused; what is refused breaks a promise.
    pub(crate) async fn expect<T>(
        &self,
        what: &str,
        attempt: impl AsyncFnMut() -> Answer<T>,
    ) -> Option<T> {
        match self.insist(what, attempt).await? {
            Ok(answer) => Some(answer),
            Err(refusal) => {
                self.tally
                    .broken("honest calls are not refused", format_args!("{what}: {refusal:?}"));
                None
            }
        }
    }
}
