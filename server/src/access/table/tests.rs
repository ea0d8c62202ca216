use std::collections::BTreeSet;

use serde_json::json;

use super::*;

/// Pages and documents that are mounted beside the routes of the API and the addresses of pages of the console.
const DOCUMENTS: [&str; 7] = [
    "GET /",
    "GET /assets/{file}",
    "GET /docs",
    "GET /guide.html",
    "GET /guide/{file}",
    "GET /openapi.json",
    "GET /sign-in",
];

/// Changes that take no scope: by them people show who they are, and their own key ends.
const OF_SIGN_INS: [&str; 4] = ["StartSignIn", "StartDeviceSignIn", "CreateSignIn", "DeleteSignIn"];

/// Routes outside of the contract.
fn outside() -> impl Iterator<Item = String> {
    let of_console =
        PAGES.iter().flat_map(|page| [format!("GET {page}"), format!("GET {page}/{{*rest}}")]);
    DOCUMENTS.map(str::to_owned).into_iter().chain(of_console)
}

fn names(is_wanted: impl Fn(&str) -> bool) -> BTreeSet<String> {
    TABLE.iter().map(|(name, _)| name.clone()).filter(|name| is_wanted(name)).collect()
}

#[test]
fn every_route_has_an_entry_and_every_entry_a_route() {
    let mut routes: BTreeSet<String> = outside().collect();
    routes.extend(crate::http::by_hand().names);
    let of_rpcs = RPCS.iter().flat_map(|rpc| rpc.routes).filter(|r| r.messages.is_some());
    routes.extend(of_rpcs.map(|route| format!("{} {}", route.method, route.path)));
    assert_eq!(names(|name| !name.starts_with('/')), routes);
}

#[test]
fn the_description_has_every_route_and_what_it_takes() {
    let document: serde_json::Value = serde_json::from_str(bendtwin_proto::OPENAPI).unwrap();
    let mut described = BTreeSet::new();
    for (path, methods) in document["paths"].as_object().unwrap() {
        for (method, operation) in methods.as_object().unwrap() {
            let name = format!("{} {path}", method.to_uppercase());
            let scopes = match find(&name) {
                Some(Open) => json!([]),
                Some(Access::Scope(scope)) => json!([{"key": [scope.as_str()]}]),
                _ => json!([{"key": []}]),
            };
            assert_eq!(operation["security"], scopes, "{name}");
            described.insert(name);
        }
    }
    described.extend(outside());
    assert_eq!(names(|name| !name.starts_with('/')), described);
}

#[test]
fn every_rpc_has_an_entry_and_every_entry_an_rpc() {
    let mut methods: BTreeSet<String> = crate::grpc::methods().unwrap().into_iter().collect();
    // The service of workers themselves does not belong to the server.
    methods.retain(|name| !name.starts_with("/bendtwin.worker.v1.WorkerRollouts/"));
    assert_eq!(names(|name| name.starts_with('/')), methods);
}

/// Scopes are options of the contract alone, so that one that is too weak shows nowhere else.
#[test]
fn what_changes_something_needs_a_scope_that_allows_it() {
    let reads = ["Get", "List", "Watch", "Export"];
    for rpc in RPCS {
        let method = rpc.path.rsplit('/').next().unwrap();
        let access = find(rpc.path).unwrap();
        let is_admin = access == Access::Scope(Scope::Admin);
        for service in [".KeyService/", ".RetentionService/"] {
            assert!(is_admin || !rpc.path.contains(service), "{}", rpc.path);
        }
        assert!(is_admin || !method.starts_with("Drain"), "{}", rpc.path);
        let weak = [Scope::CapturesRead, Scope::FitsRead, Scope::TwinsRead].map(Access::Scope);
        let is_weak = weak.contains(&access) || matches!(access, Open | Anyone);
        let is_read = reads.iter().any(|read| method.starts_with(read));
        if rpc.path.contains(".SignInService/") && OF_SIGN_INS.contains(&method) {
            continue;
        }
        assert!(is_read || !is_weak, "{}: {access:?}", rpc.path);
    }
}

#[test]
fn no_name_is_listed_twice() {
    assert_eq!(names(|_| true).len(), TABLE.len());
}

#[test]
fn heads_are_gets_unless_they_have_an_entry() {
    assert_eq!(route_name(&Method::HEAD, "/v1/twins/{id}"), "GET /v1/twins/{id}");
    assert_eq!(route_name(&Method::HEAD, "/v1/uploads/{id}"), "HEAD /v1/uploads/{id}");
    assert_eq!(find(&route_name(&Method::DELETE, "/v1/workers/{id}")), None);
}

#[test]
fn few_paths_are_open() {
    for open in ["/", "/healthz", "/readyz", "/docs", "/openapi.json", "/assets/index-1.js"] {
        // Other methods get their answer, that they do not exist, without a token, too.
        for method in [Method::GET, Method::HEAD, Method::POST] {
            assert!(is_open(&method, open), "{method} {open}");
        }
    }
    assert!(is_open(&Method::GET, "/captures") && is_open(&Method::GET, "/twins/1/play"));
    for closed in
        ["/metrics", "/capture", "/v1/captures", "/assets", "/healthz/x", "//", "", "/v1/keys"]
    {
        assert!(!is_open(&Method::GET, closed), "{closed}");
    }
}

#[test]
fn of_uploads_only_the_options_are_open() {
    assert!(is_open(&Method::OPTIONS, "/v1/uploads"));
    for method in [Method::GET, Method::HEAD, Method::POST, Method::DELETE] {
        assert!(!is_open(&method, "/v1/uploads"), "{method}");
    }
    assert!(!is_open(&Method::OPTIONS, "/v1/uploads/0199"));
}
