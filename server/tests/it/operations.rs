use bendtwin_server::Service;
use tonic_health::pb::{
    HealthCheckRequest, health_check_response::ServingStatus, health_client::HealthClient,
};

use crate::{
    harness::{Server, options},
    worker::Worker,
};

/// The mounted routes, by method.
const ROUTES: [(&str, &str); 22] = [
    ("get", "/v1/captures"),
    ("post", "/v1/captures"),
    ("get", "/v1/captures/{id}"),
    ("delete", "/v1/captures/{id}"),
    ("get", "/v1/captures/{id}/content"),
    ("get", "/v1/fits"),
    ("post", "/v1/fits"),
    ("get", "/v1/fits/{id}"),
    ("delete", "/v1/fits/{id}"),
    ("post", "/v1/fits/{id}/cancel"),
    ("get", "/v1/fits/{id}/events"),
    ("get", "/v1/twins"),
    ("post", "/v1/twins"),
    ("get", "/v1/twins/{id}"),
    ("get", "/v1/twins/{id}/content"),
    ("post", "/v1/twins/{id}/rollouts"),
    ("get", "/v1/workers"),
    ("get", "/v1/uploads"),
    ("delete", "/v1/uploads/{id}"),
    ("get", "/healthz"),
    ("get", "/readyz"),
    ("get", "/metrics"),
];

#[tokio::test]
async fn the_document_describes_every_route_and_every_route_is_there() {
    let server = Server::start().await;
    let (status, document) = server.get("/openapi.json").await;
    assert_eq!(status, 200);
    for (method, path) in ROUTES {
        assert!(document["paths"][path][method].is_object(), "{method} {path}");
    }
    // What is described is mounted: never the fallback's answer.
    for (path, methods) in document["paths"].as_object().unwrap() {
        for method in methods.as_object().unwrap().keys() {
            let method = method.to_uppercase().parse().unwrap();
            let url = server.url(&path.replace("{id}", "x"));
            let response = server.http.request(method, url).send().await.unwrap();
            assert_ne!(response.status(), 405, "{path}");
            assert!(!response.text().await.unwrap().contains("NO_SUCH_ROUTE"), "{path}");
        }
    }
    // References lead somewhere.
    let text = document.to_string();
    for name in text.split("#/components/schemas/").skip(1) {
        let name = name.split('"').next().unwrap();
        assert!(document["components"]["schemas"][name].is_object(), "{name}");
    }
    let page = server.http.get(server.url("/docs")).send().await.unwrap().text().await.unwrap();
    assert!(page.contains("openapi.json") && !page.contains("//cdn") && !page.contains("https://"));
}

#[tokio::test]
async fn health_readiness_metrics_and_reflection() {
    let server = Server::start().await;
    assert_eq!(server.get("/healthz").await.0, 200);
    server.fit().await;
    let text = server.http.get(server.url("/metrics")).send().await.unwrap().text().await.unwrap();
    for line in [
        r#"bendtwin_fits{state="queued"} 1"#,
        r#"bendtwin_requests_total{transport="http",route="/v1/fits",code="202"} 1"#,
        "bendtwin_workers 0",
        "bendtwin_request_seconds_bucket",
        "bendtwin_oldest_queued_fit_seconds",
        "bendtwin_store_up 1",
        r#"bendtwin_store_seconds_count{store="database",operation="commit"}"#,
        r#"bendtwin_store_seconds_count{store="content",operation="write"}"#,
        "process_resident_memory_bytes",
    ] {
        assert!(text.contains(line), "{line} is not in\n{text}");
    }
    let mut health = HealthClient::new(server.channel.clone());
    let mut check = async |service: &str| {
        let request = HealthCheckRequest { service: service.to_owned() };
        health.check(request).await.map(|reply| reply.into_inner().status())
    };
    let services = ["", "bendtwin.v1.FitService", "bendtwin.v1.RolloutService"];
    for service in services {
        assert_eq!(check(service).await.unwrap(), ServingStatus::NotServing, "without a worker");
    }
    let _worker = Worker::register(&server).await;
    for service in services {
        assert_eq!(check(service).await.unwrap(), ServingStatus::Serving);
    }
    assert_eq!(check("bendtwin.v1.NoService").await.unwrap_err().code(), tonic::Code::NotFound);
}

/// Lists the services by one version of reflection.
macro_rules! services {
    ($version:ident, $server:expr) => {{
        use tonic_reflection::pb::$version::{
            ServerReflectionRequest, server_reflection_client::ServerReflectionClient,
            server_reflection_request::MessageRequest, server_reflection_response::MessageResponse,
        };
        let list = ServerReflectionRequest {
            host: String::new(),
            message_request: Some(MessageRequest::ListServices(String::new())),
        };
        let mut reflection = ServerReflectionClient::new($server.channel.clone());
        let answers = reflection.server_reflection_info(futures::stream::iter([list])).await;
        let answer = answers.unwrap().into_inner().message().await.unwrap().unwrap();
        let Some(MessageResponse::ListServicesResponse(services)) = answer.message_response else {
            panic!("no list of services");
        };
        services.service.into_iter().map(|s| s.name).collect::<Vec<_>>()
    }};
}

#[tokio::test]
async fn reflection_answers_in_both_versions() {
    let server = Server::start().await;
    for services in [services!(v1, server), services!(v1alpha, server)] {
        assert!(services.iter().any(|s| s == "bendtwin.v1.CaptureService"), "{services:?}");
    }
}

#[tokio::test]
async fn request_ids_come_back() {
    let server = Server::start().await;
    let get = |id: &'static str| {
        server.http.get(server.url("/v1/captures/x")).header("x-request-id", id).send()
    };
    let response = get("my-id-1").await.unwrap();
    assert_eq!(response.headers()["x-request-id"], "my-id-1");
    assert_eq!(response.headers()["content-type"], "application/problem+json");
    let problem: serde_json::Value = response.json().await.unwrap();
    assert_eq!(problem["request_id"], "my-id-1");
    assert_eq!(problem["type"], "urn:bendtwin:error:INVALID_NAME");
    assert_eq!(problem["status"], 400);
    // One that is no id is replaced.
    let response = get("<script>").await.unwrap();
    assert_eq!(response.headers()["x-request-id"].len(), 36);
    let status = server
        .fits()
        .get_fit(bendtwin_proto::v1::GetFitRequest { name: "x".into() })
        .await
        .unwrap_err();
    use tonic_types::StatusExt;
    let details = status.get_error_details();
    assert_eq!(details.error_info().unwrap().reason, "INVALID_NAME");
    assert_eq!(details.request_info().unwrap().request_id.len(), 36);
}

#[tokio::test]
async fn pages_of_other_sites_are_kept_out() {
    let server = Server::start().await;
    let own = format!("http://{}", server.handle.local_addr());
    for (origin, status) in [(own.as_str(), 200), ("http://evil.example", 403), ("null", 403)] {
        let request = server.http.get(server.url("/v1/fits")).header("origin", origin);
        assert_eq!(request.send().await.unwrap().status(), status, "{origin}");
    }
}

#[tokio::test]
async fn what_cannot_start_says_why() {
    let dir = tempfile::tempdir().unwrap();
    let server = Service::start(options(&dir)).await.unwrap();
    let second = Service::start(options(&dir)).await.unwrap_err();
    assert!(second.to_string().contains("in use by another server"), "{second}");
    let other = tempfile::tempdir().unwrap();
    let mut taken = options(&other);
    taken.listen = server.local_addr();
    assert!(Service::start(taken).await.unwrap_err().to_string().contains("cannot listen"));
    let mut invalid = options(&other);
    invalid.lease_s = -1.0;
    assert!(Service::start(invalid).await.unwrap_err().to_string().contains("lease_s"));
    server.shutdown().await;
    Service::start(options(&dir)).await.unwrap().shutdown().await;
}
