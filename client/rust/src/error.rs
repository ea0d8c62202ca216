//! Errors of calls.

use std::time::Duration;

use bendtwin_core::{Category, Fault, Problem};
use bendtwin_proto::fault;
use bendtwin_tls::TlsError;
use tonic::Status;
use tonic_types::StatusExt as _;

/// A failed call: the server's error, or the reason for which it could not be reached.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{fault}")]
pub struct Error {
    fault: Fault,
    request_id: Option<String>,
    retry_after: Option<Duration>,
}

impl Error {
    /// The kind of error.
    pub fn category(&self) -> Category {
        self.fault.category
    }

    /// The reason: a stable UPPER_SNAKE_CASE word for programs.
    pub fn reason(&self) -> &str {
        &self.fault.reason
    }

    /// Description for people: the event, and the action to take.
    pub fn message(&self) -> &str {
        &self.fault.message
    }

    /// The server's id of the call, to be quoted when reporting a problem.
    pub fn request_id(&self) -> Option<&str> {
        self.request_id.as_deref()
    }

    /// The delay after which the server proposes another attempt.
    pub fn retry_after(&self) -> Option<Duration> {
        self.retry_after
    }

    /// Category, reason and message together.
    pub fn fault(&self) -> &Fault {
        &self.fault
    }

    /// True if the same call may succeed a moment later.
    pub fn is_transient(&self) -> bool {
        matches!(self.category(), Category::Unavailable)
    }

    pub(crate) fn new(category: Category, reason: &str, message: impl Into<String>) -> Self {
        let fault = Fault { category, reason: reason.to_owned(), message: message.into() };
        Self { fault, request_id: None, retry_after: None }
    }

    /// The error of another part of the program.
    pub(crate) fn of(error: &impl Problem) -> Self {
        Self::new(error.category(), error.reason(), error.to_string())
    }

    pub(crate) fn with_request_id(self, request_id: Option<String>) -> Self {
        Self { request_id: request_id.filter(|id| !id.is_empty()), ..self }
    }

    /// An argument that the client refuses.
    pub(crate) fn invalid(message: impl Into<String>) -> Self {
        Self::new(Category::InvalidArgument, "INVALID_ARGUMENT", message)
    }

    /// A reply that breaks the contract.
    pub(crate) fn malformed(what: impl std::fmt::Display) -> Self {
        let message = format!("the server's reply cannot be read: {what}; do the versions match?");
        Self::new(Category::Internal, "MALFORMED_REPLY", message)
    }

    /// A server that cannot be reached.
    pub(crate) fn unreachable(url: &str, why: impl std::fmt::Display) -> Self {
        let message = format!(
            "no BendTwin server answers at {url} ({why}): start one with `bendtwin server`, or name another address"
        );
        Self::new(Category::Unavailable, "SERVER_UNREACHABLE", message)
    }

    /// Something that speaks HTTP/1 where gRPC was expected, if that is what an error says.
    pub(crate) fn of_http1(
        server: &str,
        error: &(dyn std::error::Error + 'static),
    ) -> Option<Self> {
        // The beginning of a response of HTTP/1, read as a frame of HTTP/2, has an impossible length.
        let is_http1 = |e: &(dyn std::error::Error + 'static)| {
            e.to_string().contains("frame with invalid size")
        };
        let mut causes = std::iter::successors(Some(error), |e| e.source());
        if !causes.any(is_http1) {
            return None;
        }
        let message = format!(
            "{server} answers with HTTP/1, and gRPC takes HTTP/2: let the proxy in front of it pass \
             HTTP/2 on (nginx: `http2 on` and `grpc_pass`), or name the address of the server itself"
        );
        let error = Self::new(Category::FailedPrecondition, "PROXY_WITHOUT_GRPC", message);
        Some(error)
    }

    /// All bytes are on the server, which does not make a capture of them.
    pub(crate) fn not_stored(url: &str) -> Self {
        let message = format!(
            "the server at {url} takes no more bytes of the upload and makes no capture of it: try again later"
        );
        Self::new(Category::Unavailable, "UPLOAD_STUCK", message)
    }

    /// Uploads that the server created are not found.
    pub(crate) fn upload_gone(url: &str) -> Self {
        let message = format!(
            "the server at {url} creates the upload and then does not find it: let the proxy in front of it pass on \
             {url}/v1/uploads and all below, with HEAD and PATCH"
        );
        Self::new(Category::NotFound, "UPLOAD_LOST", message)
    }

    /// A local file that cannot be read or written.
    pub(crate) fn file(path: &std::path::Path, error: &std::io::Error) -> Self {
        let category = match error.kind() {
            std::io::ErrorKind::NotFound => Category::NotFound,
            std::io::ErrorKind::PermissionDenied => Category::PermissionDenied,
            _ => Category::Internal,
        };
        Self::new(category, "FILE_UNUSABLE", format!("{}: {error}", path.display()))
    }
}

impl From<Status> for Error {
    fn from(status: Status) -> Self {
        let request_id = status.get_details_request_info().map(|info| info.request_id);
        let retry_after = status.get_details_retry_info().and_then(|info| info.retry_delay);
        let mut fault = fault::fault(&status);
        if status.get_details_error_info().is_none() {
            // Not from the server's own code: the connection, most likely.
            if let Some(found) = TlsError::find(&status, "the server") {
                return Self::of(&found);
            }
            if let Some(found) = Self::of_http1("the server", &status) {
                return found;
            }
            let transport = std::error::Error::source(&status).is_some();
            if transport {
                fault.category = Category::Unavailable;
                fault.reason = "CONNECTION_LOST".to_owned();
                fault.message = format!("the connection to the server broke: {}", fault.message);
            }
        }
        Self { fault, request_id: None, retry_after }.with_request_id(request_id)
    }
}
