use std::collections::BTreeSet;

use super::*;

/// Pages and documents that are not part of the described API.
const NOT_DESCRIBED: [&str; 4] = ["GET /", "GET /assets/{file}", "GET /docs", "GET /openapi.json"];

fn names(is_wanted: impl Fn(&str) -> bool) -> BTreeSet<String> {
    TABLE.iter().map(|(name, _)| (*name).to_owned()).filter(|name| is_wanted(name)).collect()
}

#[test]
fn every_route_has_an_entry_and_every_entry_a_route() {
    let (_, description) = crate::http::described().split_for_parts();
    let document = serde_json::to_value(&description).unwrap();
    let mut routes: BTreeSet<String> = NOT_DESCRIBED.map(str::to_owned).into();
    for (path, methods) in document["paths"].as_object().unwrap() {
        let methods = methods.as_object().unwrap().keys();
        routes.extend(methods.map(|method| format!("{} {path}", method.to_uppercase())));
    }
    assert_eq!(names(|name| !name.starts_with('/')), routes);
}

#[test]
fn every_rpc_has_an_entry_and_every_entry_an_rpc() {
    let mut methods: BTreeSet<String> = crate::grpc::methods().unwrap().into_iter().collect();
    // The service of workers themselves is none of the server's.
    methods.retain(|name| !name.starts_with("/bendtwin.worker.v1.WorkerRollouts/"));
    assert_eq!(names(|name| name.starts_with('/')), methods);
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
    for closed in ["/metrics", "/v1/captures", "/assets", "/healthz/x", "//", "", "/v1/keys"] {
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
