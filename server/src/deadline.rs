//! Deadlines of calls, and the errors that end a response too late: the one place that knows both
//! transports' forms of them.

use std::{net::SocketAddr, time::Duration};

use axum::http::{HeaderMap, header};
use bendtwin_core::{Category, Fault};
use tokio::time::Instant;
use tonic::metadata::MetadataMap;

use crate::{context::Context, error, refusal::Refusal};

/// Time past its deadline in which a call may still answer by itself, which says more.
const GRACE: Duration = Duration::from_millis(250);

/// Facts about a request that its response needs until its end.
#[derive(Clone, Debug)]
pub(crate) struct Call {
    pub(crate) context: Context,
    pub(crate) is_grpc: bool,
    /// The time at which the server gives it up.
    pub(crate) deadline: Option<Instant>,
}

/// Reason for which a response is cut off.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Cut {
    Deadline,
    /// The client read nothing for so long.
    Unread(Duration),
}

impl Call {
    pub(crate) fn of(headers: &HeaderMap, peer: SocketAddr) -> Self {
        let content_type = headers.get(header::CONTENT_TYPE);
        let is_grpc = content_type.is_some_and(|v| v.as_bytes().starts_with(b"application/grpc"));
        let timeout = headers.get("grpc-timeout").filter(|_| is_grpc).and_then(|value| {
            let mut metadata = HeaderMap::new();
            metadata.insert("grpc-timeout", value.clone());
            bendtwin_proto::deadline::timeout(&MetadataMap::from_headers(metadata))
        });
        let deadline = timeout.and_then(|t| Instant::now().checked_add(t + GRACE));
        Self { context: Context::of(headers, Some(peer)), is_grpc, deadline }
    }

    /// Waits for the deadline, for ever without one.
    pub(crate) async fn passed(&self) {
        match self.deadline {
            Some(deadline) => tokio::time::sleep_until(deadline).await,
            None => std::future::pending().await,
        }
    }

    /// The trailers that give a gRPC client the reason why its response was cut off.
    pub(crate) fn trailers(&self, cut: Cut) -> HeaderMap {
        let status = cut.refusal().into_status(&self.context);
        let mut trailers = status.into_http::<axum::body::Body>().into_parts().0.headers;
        trailers.remove(header::CONTENT_TYPE);
        trailers
    }
}

impl Cut {
    pub(crate) fn refusal(self) -> Refusal {
        match self {
            Self::Deadline => error::Error::Deadline.into(),
            Self::Unread(silence) => Refusal::new(Fault {
                category: Category::ResourceExhausted,
                reason: "RESPONSE_UNREAD".to_owned(),
                message: format!(
                    "nothing of the response was read for {} s: read it as it comes, or ask for \
                     less at a time",
                    silence.as_secs_f64()
                ),
            }),
        }
    }
}
