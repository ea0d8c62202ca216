//! The context of a request: its id and its trace. The middleware sets it once; errors and jobs
//! take it over.

use bendtwin_core::{Category, Fault};

tokio::task_local! {
    static CURRENT: Context;
}

/// The context of the request under way.
#[derive(Clone, Debug, Default)]
pub(crate) struct Context {
    /// Taken from `x-request-id`, or made here.
    pub(crate) request_id: String,
    /// W3C `traceparent`, if the client sent a sound one.
    pub(crate) trace_parent: Option<String>,
}

impl Context {
    /// The context of the request that this task answers; empty outside of requests.
    pub(crate) fn current() -> Self {
        CURRENT.try_with(Clone::clone).unwrap_or_default()
    }

    /// Runs the future with this context.
    pub(crate) fn scope<F: Future>(self, future: F) -> impl Future<Output = F::Output> {
        CURRENT.scope(self, future)
    }

    /// Reads the headers of a request.
    pub(crate) fn of(headers: &axum::http::HeaderMap) -> Self {
        let text = |name: &str| headers.get(name).and_then(|v| v.to_str().ok());
        let request_id = text("x-request-id")
            .filter(|id| is_sane_id(id))
            .map_or_else(|| uuid::Uuid::now_v7().to_string(), str::to_owned);
        let trace_parent = text("traceparent").filter(|t| is_trace_parent(t)).map(str::to_owned);
        Self { request_id, trace_parent }
    }
}

/// Up to 128 characters that are safe in headers, logs and JSON alike.
pub(crate) fn is_sane_id(id: &str) -> bool {
    (1..=128).contains(&id.len())
        && id.bytes().all(|b| b.is_ascii_alphanumeric() || b"-_.:/+=@".contains(&b))
}

/// `00-{32 hex}-{16 hex}-{2 hex}`, not all zero.
fn is_trace_parent(text: &str) -> bool {
    let parts: Vec<&str> = text.split('-').collect();
    let [version, trace, parent, flags] = parts[..] else { return false };
    let is_hex = |s: &str, len: usize| {
        s.len() == len && s.bytes().all(|b| b.is_ascii_digit() || (b'a'..=b'f').contains(&b))
    };
    let is_zero = |s: &str| s.bytes().all(|b| b == b'0');
    is_hex(version, 2)
        && version != "ff"
        && is_hex(trace, 32)
        && !is_zero(trace)
        && is_hex(parent, 16)
        && !is_zero(parent)
        && is_hex(flags, 2)
}

/// The part of a fault that a client may see. Details of defects and of damaged data are for the
/// log only.
pub(crate) fn redact(fault: Fault, request_id: &str) -> Fault {
    match fault.category {
        Category::Internal | Category::DataLoss => {
            tracing::error!(reason = fault.reason, request_id, "{}", fault.message);
            let what = if fault.category == Category::Internal {
                "the server failed"
            } else {
                "stored data is missing or damaged"
            };
            let message = format!("{what}: report this with the request id {request_id}");
            Fault { message, ..fault }
        }
        _ => fault,
    }
}
