//! The audit: one line in the log for each change that a client requests, under the target `audit`,
//! with the caller, the request and its outcome. Both transports use the names of RPCs. Calls
//! refused for a scope are recorded, too, by the route of HTTP or the path of gRPC, and so are
//! refused tokens and keys, by the address that they came from.

use std::fmt::Display;

use bendtwin_core::Problem as _;

use crate::{access::Caller, context::Context, error::Result};

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

/// Notes a change that the server made by itself, and why.
pub(crate) fn by_server(method: &'static str, resource: impl Display, why: &str) {
    tracing::info!(
        target: "audit",
        key = "",
        owner = "",
        method,
        %resource,
        result = "OK",
        request_id = "",
        why,
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

/// Notes a sign-in, which comes from someone who is not known before it; `times` counts equal ones
/// since the last line. The new key is what was made.
pub(crate) fn signed_in<T>(
    method: &'static str,
    done: &Result<T>,
    times: u64,
    name: impl Fn(&T) -> String,
) {
    let Context { caller, request_id, network, .. } = Context::current();
    tracing::info!(
        target: "audit",
        key = caller.key.map(|key| key.to_string()).unwrap_or_default(),
        owner = &*caller.owner,
        method,
        resource = done.as_ref().map_or_else(|_| String::new(), name),
        result = done.as_ref().map_or_else(|error| error.reason(), |_| "OK"),
        times,
        client = network.map(|network| network.to_string()).unwrap_or_default(),
        request_id,
        "change"
    );
}

/// Notes a resource that was made; `name` is what it is called.
pub(crate) fn made<T>(method: &'static str, done: &Result<T>, name: impl Fn(&T) -> String) {
    changed(method, done.as_ref().map_or_else(|_| String::new(), name), done);
}

#[cfg(test)]
mod tests {
    use std::{collections::BTreeSet, path::Path};

    use bendtwin_proto::routes::RPCS;

    /// Changes by the protocol of uploads, which is none of gRPC.
    const UPLOADS: [&str; 2] = ["CreateUpload", "TerminateUpload"];

    /// The use cases write the lines, as they know what was made; the contract says which do.
    #[test]
    fn what_the_contract_has_audited_is_audited() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("src/app");
        let mut audited = BTreeSet::new();
        let mut paths = vec![folder];
        while let Some(path) = paths.pop() {
            if path.is_dir() {
                paths.extend(std::fs::read_dir(path).unwrap().map(|entry| entry.unwrap().path()));
                continue;
            }
            let source = std::fs::read_to_string(path).unwrap();
            for call in source.split("audit::").skip(1) {
                let kinds = ["changed(", "made(", "signed_in("];
                let call = kinds.iter().find_map(|kind| call.strip_prefix(kind));
                let method = call.and_then(|call| call.split('"').nth(1));
                audited.extend(method.map(str::to_owned));
            }
        }
        let stated = RPCS.iter().filter(|rpc| rpc.audited).map(|rpc| rpc.method());
        let stated: BTreeSet<_> = stated.chain(UPLOADS).map(str::to_owned).collect();
        assert_eq!(audited, stated);
    }
}
