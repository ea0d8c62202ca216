//! The one table of what each route and each RPC takes, as the contract states it. A call that it does
//! not list is refused to everyone; tests compare it with the routes that are mounted and with the
//! descriptors of gRPC.

use std::{collections::HashMap, sync::LazyLock};

use axum::http::Method;
use bendtwin_proto::{
    routes::{BY_HAND, RPCS},
    v1 as wire,
};

use super::Scope;

/// Condition of a call.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Access {
    /// Nothing: it tells nothing of what is stored.
    Open,
    /// The client token, or a key with any scope but `metrics:read` alone.
    Anyone,
    /// The token of a worker, which the service checks itself.
    Worker,
    /// The client token, or a key with this scope.
    Scope(Scope),
}

use Access::{Anyone, Open};

/// Conditions of what the contract does not have: pages, the description, and services of others.
const OTHERS: [(&str, Access); 11] = [
    ("GET /", Open),
    ("GET /assets/{file}", Open),
    ("GET /sign-in", Open),
    ("GET /docs", Open),
    ("GET /guide.html", Open),
    ("GET /guide/{file}", Open),
    ("GET /openapi.json", Open),
    ("/grpc.health.v1.Health/Check", Open),
    ("/grpc.health.v1.Health/Watch", Open),
    ("/grpc.reflection.v1.ServerReflection/ServerReflectionInfo", Anyone),
    ("/grpc.reflection.v1alpha.ServerReflection/ServerReflectionInfo", Anyone),
];

/// Pages of the console that are lists: these addresses and those below lead to them, which tells nothing.
pub(crate) const PAGES: [&str; 7] =
    ["/captures", "/fits", "/twins", "/upload", "/trash", "/workers", "/login"];

/// Condition of each route, `METHOD /path`, and of each RPC, `/package.Service/Method`.
pub static TABLE: LazyLock<Vec<(String, Access)>> = LazyLock::new(|| {
    let named = |(name, scope): &(&str, wire::Scope)| Some(((*name).to_owned(), access(*scope)?));
    let others = OTHERS.iter().map(|(name, access)| ((*name).to_owned(), *access));
    let pages = PAGES.iter().flat_map(|page| {
        [format!("GET {page}"), format!("GET {page}/{{*rest}}")].map(|name| (name, Open))
    });
    let rpcs = RPCS.iter().flat_map(|rpc| {
        let routes = rpc.routes.iter().map(|route| format!("{} {}", route.method, route.path));
        let names = routes.chain([rpc.path.to_owned()]);
        names.filter_map(|name| Some((name, access(rpc.scope)?)))
    });
    others.chain(pages).chain(BY_HAND.iter().filter_map(named)).chain(rpcs).collect()
});

/// The condition that the contract states.
fn access(scope: wire::Scope) -> Option<Access> {
    Some(match scope {
        wire::Scope::Unspecified => return None,
        wire::Scope::Open => Open,
        wire::Scope::Anyone => Anyone,
        wire::Scope::Worker => Access::Worker,
        wire::Scope::Admin => Access::Scope(Scope::Admin),
        wire::Scope::CapturesRead => Access::Scope(Scope::CapturesRead),
        wire::Scope::CapturesWrite => Access::Scope(Scope::CapturesWrite),
        wire::Scope::FitsRead => Access::Scope(Scope::FitsRead),
        wire::Scope::FitsWrite => Access::Scope(Scope::FitsWrite),
        wire::Scope::MetricsRead => Access::Scope(Scope::MetricsRead),
        wire::Scope::RolloutsRun => Access::Scope(Scope::RolloutsRun),
        wire::Scope::TwinsRead => Access::Scope(Scope::TwinsRead),
        wire::Scope::TwinsWrite => Access::Scope(Scope::TwinsWrite),
    })
}

/// The table by name.
static BY_NAME: LazyLock<HashMap<&str, Access>> =
    LazyLock::new(|| TABLE.iter().map(|(name, access)| (name.as_str(), *access)).collect());

/// Condition of a route or an RPC; none if it is not listed.
pub(crate) fn find(name: &str) -> Option<Access> {
    BY_NAME.get(name).copied()
}

/// The name of a route in the table. `HEAD` of a route without a separate `HEAD` is its `GET`.
pub(crate) fn route_name(method: &Method, pattern: &str) -> String {
    let name = format!("{method} {pattern}");
    match *method {
        Method::HEAD if find(&name).is_none() => format!("{} {pattern}", Method::GET),
        _ => name,
    }
}

/// True if a request takes nothing: its route is open, or, for a method that a path does not have, all
/// routes of the path are.
pub(crate) fn is_open(method: &Method, path: &str) -> bool {
    let routes = TABLE.iter().filter_map(|(name, access)| Some((name.split_once(' ')?, *access)));
    let here = routes.filter(|((_, pattern), _)| is_at(pattern, path));
    let (mut any, mut all) = (false, true);
    for ((own, _), access) in here {
        if own == method.as_str() {
            return access == Open;
        }
        (any, all) = (true, all && access == Open);
    }
    any && all
}

/// True if a path is this pattern, or below one whose last part is a parameter.
fn is_at(pattern: &str, path: &str) -> bool {
    match pattern.rsplit_once('/') {
        Some((folder, last)) if last.starts_with('{') => {
            path.strip_prefix(folder).is_some_and(|rest| rest.starts_with('/'))
        }
        _ => pattern == path,
    }
}

#[cfg(test)]
mod tests;
