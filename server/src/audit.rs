//! The audit: one line in the log for each change that a client requests, under the target `audit`,
//! with the caller, the request and its outcome. Both transports use the names of RPCs. Calls
//! refused for a scope are recorded, too, by the route of HTTP or the path of gRPC, and so are
//! refused tokens and keys, by the address that they came from.

use std::fmt::Display;

use bendtwin_core::Problem as _;

use crate::{access::Caller, context::Context, failure::Result};

/// Notes a change of a resource.
pub(crate) fn changed<T>(method: &'static str, resource: impl Display, done: &Result<T>) {
    let Context { caller, request_id, .. } = Context::current();
    let key = caller.key.map(|key| key.to_string()).unwrap_or_default();
    let result = done.as_ref().map_or_else(|error| error.reason(), |_| "OK");
    tracing::info!(
        target: "audit",
        key,
        owner = &*caller.owner,
        method,
        %resource,
        result,
        request_id,
        "change"
    );
}

/// Records a refused call, and the number of refusals since the last record.
pub(crate) fn refused(caller: &Caller, call: &str, reason: &str, times: u64) {
    tracing::info!(
        target: "audit",
        key = caller.key.map(|key| key.to_string()).unwrap_or_default(),
        owner = &*caller.owner,
        method = call,
        resource = "",
        result = reason,
        times,
        request_id = Context::current().request_id,
        "refused"
    );
}

/// Records a refused token or key, and the number of refusals since the last record. The caller has
/// the key, if it was one of this server's, and nothing else.
pub(crate) fn not_admitted(caller: &Caller, reason: &str, times: u64) {
    let Context { request_id, network, .. } = Context::current();
    tracing::info!(
        target: "audit",
        key = caller.key.map(|key| key.to_string()).unwrap_or_default(),
        owner = &*caller.owner,
        method = "",
        resource = "",
        result = reason,
        times,
        client = network.map(|network| network.to_string()).unwrap_or_default(),
        request_id,
        "not admitted"
    );
}

/// Notes a resource that was made; `name` is what it is called.
pub(crate) fn made<T>(method: &'static str, done: &Result<T>, name: impl Fn(&T) -> String) {
    changed(method, done.as_ref().map_or_else(|_| String::new(), name), done);
}
