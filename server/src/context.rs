//! The context of a request: its id, its trace, its client and its caller. The middleware sets it once; errors
//! and jobs take it over.

use std::{
    net::{IpAddr, Ipv6Addr, SocketAddr},
    sync::Arc,
};

use axum::http::HeaderMap;
use bendtwin_core::{Category, Fault};

use crate::access::Caller;

tokio::task_local! {
    static CURRENT: Context;
}

/// The context of the request under way.
#[derive(Clone, Debug)]
pub(crate) struct Context {
    /// Taken from `x-request-id`, or made here.
    pub(crate) request_id: String,
    /// W3C `traceparent`, if the client sent a sound one.
    pub(crate) client_trace_parent: Option<String>,
    /// The client, as far as shares of the workers are concerned: `x-client-id` of its address if
    /// it sends one, else its address. Many clients have this machine's, so there each connection
    /// counts as a client.
    pub(crate) client: Arc<str>,
    /// The network that it comes from; none outside of requests.
    pub(crate) network: Option<IpAddr>,
    /// The caller, as far as it has shown who it is.
    pub(crate) caller: Caller,
    /// True where HTTP has a service of gRPC answer in this process: what it says crosses no wire, whose
    /// metadata is bounded.
    pub(crate) is_in_process: bool,
}

impl Context {
    /// The context of the request that this task answers; empty outside of requests.
    pub(crate) fn current() -> Self {
        CURRENT.try_with(Clone::clone).unwrap_or_default()
    }

    /// The `traceparent` for what is done elsewhere on behalf of the request: that of the current
    /// span if spans are exported, else the client's.
    pub(crate) fn trace_parent(&self) -> Option<String> {
        bendtwin_telemetry::trace_parent(&tracing::Span::current())
            .or_else(|| self.client_trace_parent.clone())
    }

    /// Runs the future with this context.
    pub(crate) fn scope<F: Future>(self, future: F) -> impl Future<Output = F::Output> {
        CURRENT.scope(self, future)
    }

    /// Reads the headers of a request; `peer` is the other end of its connection.
    pub(crate) fn of(headers: &HeaderMap, peer: Option<SocketAddr>) -> Self {
        let text = |name: &str| headers.get(name).and_then(|v| v.to_str().ok());
        let request_id = text("x-request-id")
            .filter(|id| is_sane_id(id))
            .map_or_else(|| uuid::Uuid::now_v7().to_string(), str::to_owned);
        let trace_parent = text("traceparent").filter(|t| is_trace_parent(t));
        let client_trace_parent = trace_parent.map(str::to_owned);
        let client = client(peer, text("x-client-id").filter(|id| is_sane_id(id)));
        let network = peer.map(|peer| network_of(peer.ip()));
        let caller = Caller::default();
        Self { request_id, client_trace_parent, client, network, caller, is_in_process: false }
    }
}

impl Default for Context {
    fn default() -> Self {
        Self {
            request_id: String::new(),
            client_trace_parent: None,
            client: client(None, None),
            network: None,
            caller: Caller::default(),
            is_in_process: false,
        }
    }
}

fn client(peer: Option<SocketAddr>, id: Option<&str>) -> Arc<str> {
    let address = peer.map(|p| p.ip().to_canonical());
    match (peer, address, id) {
        (_, Some(address), Some(id)) => format!("{address} {id}").into(),
        (Some(peer), Some(address), None) if address.is_loopback() => peer.to_string().into(),
        (_, Some(address), None) => address.to_string().into(),
        (_, None, id) => id.unwrap_or_default().into(),
    }
}

/// The network that counts as one client: an address of IPv4, or a network of 64 bits of IPv6, of
/// which a client has many addresses.
pub(crate) fn network_of(peer: IpAddr) -> IpAddr {
    match peer.to_canonical() {
        IpAddr::V6(v6) => IpAddr::V6(Ipv6Addr::from_bits(v6.to_bits() & !u128::from(u64::MAX))),
        v4 => v4,
    }
}

/// True for up to 128 characters that are safe in headers, logs and JSON.
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
            let what = if fault.category == Category::Internal {
                "the server failed"
            } else {
                "stored data is missing or damaged"
            };
            let message = format!("{what}: report this with the request id {request_id}");
            // An error that passes both transports is logged once.
            if fault.message != message {
                tracing::error!(reason = fault.reason, request_id, "{}", fault.message);
            }
            Fault { message, ..fault }
        }
        _ => fault,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn clients_are_distinguished() {
        let peer = |text: &str| Some(text.parse().unwrap());
        // On this machine by connection.
        assert_ne!(client(peer("127.0.0.1:1"), None), client(peer("127.0.0.1:2"), None));
        assert_ne!(client(peer("[::ffff:127.0.0.1]:1"), None), client(peer("[::1]:2"), None));
        // Elsewhere by address, however many connections it opens.
        assert_eq!(client(peer("10.0.0.1:1"), None), client(peer("10.0.0.1:2"), None));
        assert_eq!(client(peer("10.0.0.1:1"), None), client(peer("[::ffff:10.0.0.1]:2"), None));
        // Ids count beside the address: no client can use up the share of another machine's.
        assert_ne!(client(peer("10.0.0.1:1"), Some("a")), client(peer("10.0.0.2:1"), Some("a")));
        assert_eq!(client(peer("127.0.0.1:1"), Some("a")), client(peer("127.0.0.1:2"), Some("a")));
    }
}
