//! The one place where errors become those of a transport: a category becomes an HTTP status or a
//! gRPC code, a fault becomes a problem document (RFC 9457) or a `Status` with `ErrorInfo`,
//! `RequestInfo` and `RetryInfo`.

use std::time::Duration;

use axum::{
    http::{HeaderValue, StatusCode, header},
    response::{IntoResponse, Response},
};
use bendtwin_core::{Category, Fault, Problem};
use bendtwin_proto::fault::{ERROR_DOMAIN, category_name, code, fault, shortened, status_with};
use serde::{Deserialize, Serialize};
use tonic::Status;
use tonic_types::{ErrorDetails, StatusExt as _};

use crate::{
    context::{self, Context},
    error,
};

/// Longest message of a problem document [bytes].
const MOST_DETAIL: usize = 16 << 10;

/// The HTTP status of a category. The gRPC code is
/// [`bendtwin_proto::fault::code`]; a test holds the two together.
pub fn http_status(category: Category) -> StatusCode {
    match category {
        Category::InvalidArgument => StatusCode::BAD_REQUEST,
        Category::Unauthenticated => StatusCode::UNAUTHORIZED,
        Category::PermissionDenied => StatusCode::FORBIDDEN,
        Category::NotFound => StatusCode::NOT_FOUND,
        // Not 412: that is for conditional requests (If-Match).
        Category::AlreadyExists | Category::Aborted | Category::FailedPrecondition => {
            StatusCode::CONFLICT
        }
        Category::ResourceExhausted => StatusCode::TOO_MANY_REQUESTS,
        // The client went away, so the response is not read.
        Category::Cancelled => StatusCode::from_u16(499).unwrap_or(StatusCode::BAD_REQUEST),
        Category::DataLoss | Category::Internal => StatusCode::INTERNAL_SERVER_ERROR,
        Category::Unavailable => StatusCode::SERVICE_UNAVAILABLE,
        Category::DeadlineExceeded => StatusCode::GATEWAY_TIMEOUT,
    }
}

/// Statuses that tus 1.0.0 prescribes, by reason.
fn tus_status(reason: &str) -> Option<StatusCode> {
    match reason {
        "UPLOAD_GONE" => Some(StatusCode::GONE),
        "UPLOAD_LOCKED" | "UPLOAD_TAKEN_OVER" => Some(StatusCode::LOCKED),
        "CONTENT_TOO_LARGE" => Some(StatusCode::PAYLOAD_TOO_LARGE),
        "CHECKSUM_MISMATCH" => StatusCode::from_u16(460).ok(),
        _ => None,
    }
}

/// A refused request, ready for either transport.
#[derive(Clone, Debug)]
pub(crate) struct Refusal {
    fault: Fault,
    retry_after: Option<Duration>,
    /// Differs from the category's only for statuses that gRPC lacks: 405, 413, 415, and those of
    /// tus.
    status: StatusCode,
}

/// An RFC 9457 problem document.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct ProblemDocument {
    /// `urn:bendtwin:error:{reason}`.
    #[serde(rename = "type")]
    pub(crate) kind: String,
    /// The category, as gRPC names it.
    pub(crate) title: String,
    /// The HTTP status.
    pub(crate) status: u16,
    /// The event, and the action to take.
    pub(crate) detail: String,
    /// A stable word for programs.
    pub(crate) reason: String,
    /// Id to quote when reporting the problem.
    pub(crate) request_id: String,
}

impl Refusal {
    pub(crate) fn new(fault: Fault) -> Self {
        Self { status: http_status(fault.category), fault, retry_after: None }
    }

    /// The refusal that a gRPC status carries.
    pub(crate) fn of_status(status: &Status) -> Self {
        let retry_after = status.get_details_retry_info().and_then(|info| info.retry_delay);
        Self::new(fault(status)).retry_after(retry_after)
    }

    /// With a status that only HTTP has.
    pub(crate) fn http_only(status: StatusCode, reason: &str, message: &str) -> Self {
        let fault = Fault {
            category: Category::InvalidArgument,
            reason: reason.to_owned(),
            message: message.to_owned(),
        };
        Self { fault, retry_after: None, status }
    }

    /// With the statuses of tus.
    pub(crate) fn with_tus_status(self) -> Self {
        Self { status: tus_status(&self.fault.reason).unwrap_or(self.status), ..self }
    }

    pub(crate) fn retry_after(self, delay: Option<Duration>) -> Self {
        Self { retry_after: delay, ..self }
    }

    /// The stable word of its reason.
    pub(crate) fn reason(&self) -> &str {
        &self.fault.reason
    }

    /// The document of HTTP, for the request of that context.
    pub(crate) fn document(&self, context: &Context) -> ProblemDocument {
        let fault = context::redact(self.fault.clone(), &context.request_id);
        ProblemDocument {
            kind: format!("urn:bendtwin:error:{}", fault.reason),
            title: category_name(fault.category).to_owned(),
            status: self.status.as_u16(),
            detail: shortened(&fault.message, MOST_DETAIL).into_owned(),
            reason: fault.reason,
            request_id: context.request_id.clone(),
        }
    }

    /// The document as a value.
    pub(crate) fn json(&self, context: &Context) -> serde_json::Value {
        // Nothing in a document fails to be written.
        serde_json::to_value(self.document(context)).unwrap_or_default()
    }

    /// The gRPC form, for the request of that context.
    pub(crate) fn into_status(self, context: &Context) -> Status {
        let fault = context::redact(self.fault, &context.request_id);
        let mut details = ErrorDetails::with_error_info(&fault.reason, ERROR_DOMAIN, []);
        details.set_request_info(&context.request_id, "");
        if self.retry_after.is_some() {
            details.set_retry_info(self.retry_after);
        }
        match context.is_in_process {
            true => Status::with_error_details(code(fault.category), fault.message, details),
            false => status_with(&fault, details),
        }
    }
}

/// Every error of the application, at the last step.
impl From<error::Error> for Refusal {
    fn from(error: error::Error) -> Self {
        let retry_after = error.retry_after();
        Self::new(error.fault()).retry_after(retry_after)
    }
}

impl From<bendtwin_store::Error> for Refusal {
    fn from(error: bendtwin_store::Error) -> Self {
        error::Error::from(error).into()
    }
}

impl From<Refusal> for Status {
    fn from(refusal: Refusal) -> Self {
        refusal.into_status(&Context::current())
    }
}

impl IntoResponse for Refusal {
    fn into_response(self) -> Response {
        let document = self.document(&Context::current());
        let mut response = (self.status, axum::Json(document)).into_response();
        let headers = response.headers_mut();
        headers.insert(header::CONTENT_TYPE, HeaderValue::from_static("application/problem+json"));
        if let Some(delay) = self.retry_after {
            // Whole seconds, rounded up: never earlier than asked.
            let seconds = delay.as_secs() + u64::from(delay.subsec_nanos() > 0);
            headers.insert(header::RETRY_AFTER, HeaderValue::from(seconds));
        }
        response
    }
}

#[cfg(test)]
mod tests;
