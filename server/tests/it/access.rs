//! Callers that are let in: the token, the host, and what metrics reveal to strangers.

mod audit;
pub(super) mod keys;
mod own;
mod projects;
mod requests;
mod shares;
mod sign_in;
mod usage;

use bendtwin_proto::worker::v1::{HeartbeatRequest, worker_link_client::WorkerLinkClient};
use bendtwin_server::ClientTokenPolicy;
use serde_json::json;
use tonic::Code;
use tonic_health::pb::{HealthCheckRequest, health_client::HealthClient};

use crate::{
    harness::{Server, read},
    worker::Worker,
};

#[tokio::test]
async fn without_the_token_only_health_and_the_description_are_served() {
    let server = Server::start_with(|o| o.client_token = ClientTokenPolicy::Required).await;
    let token = server.handle.client_token().unwrap().to_owned();
    let file = server.dir.path().join("data/client-token");
    assert_eq!(std::fs::read_to_string(file).unwrap().trim(), token);
    let _worker = crate::worker::Worker::register(&server).await;
    for path in ["/healthz", "/readyz", "/docs", "/openapi.json"] {
        assert_eq!(server.get(path).await.0, 200, "{path}");
    }
    for path in ["/v1/captures", "/v1/fits", "/v1/workers", "/metrics", "/nothing"] {
        let refused = server.http.get(server.url(path)).send().await.unwrap();
        let challenges = refused.headers().get_all("www-authenticate").iter();
        let challenges: Vec<_> = challenges.map(|v| v.to_str().unwrap().to_owned()).collect();
        assert!(challenges.iter().any(|c| c.starts_with("Bearer")), "{challenges:?}");
        assert!(challenges.iter().any(|c| c.starts_with("Basic")), "{challenges:?}");
        let (status, problem) = read(refused).await;
        assert_eq!((status, &problem["reason"]), (401, &json!("BAD_CLIENT_TOKEN")), "{path}");
    }
    let with = |token: &str| server.http.get(server.url("/v1/captures")).bearer_auth(token).send();
    assert_eq!(with(&token).await.unwrap().status(), 200);
    assert_eq!(with("another").await.unwrap().status(), 401);
    let basic = server.http.get(server.url("/v1/captures")).basic_auth("any", Some(&token));
    assert_eq!(basic.send().await.unwrap().status(), 200);
}

#[tokio::test]
async fn grpc_needs_the_token_and_workers_have_their_own() {
    let server = Server::start_with(|o| o.client_token = ClientTokenPolicy::Required).await;
    let list = |authorization: Option<&str>| {
        let mut request = tonic::Request::new(bendtwin_proto::v1::ListFitsRequest::default());
        if let Some(value) = authorization {
            request.metadata_mut().insert("authorization", value.parse().unwrap());
        }
        let mut fits = server.fits();
        async move { fits.list_fits(request).await }
    };
    let refused = list(None).await.unwrap_err();
    assert_eq!(refused.code(), Code::Unauthenticated);
    assert_eq!(bendtwin_proto::fault::fault(&refused).reason, "BAD_CLIENT_TOKEN");
    let token = server.handle.client_token().unwrap();
    list(Some(&format!("Bearer {token}"))).await.unwrap();
    // Health is for everyone, the link for workers.
    let health = HealthCheckRequest::default();
    HealthClient::new(server.channel.clone()).check(health).await.unwrap();
    let mut worker = Worker::register(&server).await;
    worker.heartbeat().await.unwrap();
    // By any name by which a worker on another machine calls the server.
    let url = format!("http://{}", server.handle.local_addr());
    let named = tonic::transport::Endpoint::from_shared(url).unwrap();
    let named = named.origin("http://twin-server:7070".parse().unwrap()).connect_lazy();
    let mut link = WorkerLinkClient::new(named.clone());
    let status = link.heartbeat(HeartbeatRequest::default()).await.unwrap_err();
    assert_eq!(bendtwin_proto::fault::fault(&status).reason, "BAD_WORKER_TOKEN");
    let status = HealthClient::new(named).check(HealthCheckRequest::default()).await.unwrap_err();
    assert_eq!(bendtwin_proto::fault::fault(&status).reason, "HOST_NOT_ALLOWED");
    let worker_token = crate::harness::TOKEN;
    assert!(list(Some(&format!("Bearer {worker_token}"))).await.is_err());
}

#[tokio::test]
async fn the_token_is_the_same_after_a_restart() {
    let required = |o: &mut bendtwin_server::Options| o.client_token = ClientTokenPolicy::Required;
    let server = Server::start_with(required).await;
    let token = server.handle.client_token().unwrap().to_owned();
    let Server { dir, handle, .. } = server;
    handle.shutdown().await;
    let again = Server::start_in(dir, required).await;
    assert_eq!(again.handle.client_token(), Some(token.as_str()));
}

/// The server of a container listens on all addresses.
#[tokio::test]
async fn other_hosts_are_refused_on_every_address() {
    let server = Server::start_with(|o| {
        o.listen = ([0, 0, 0, 0], 0).into();
        o.insecure = true;
        o.allowed_hosts = vec!["twin.example".to_owned()];
    })
    .await;
    let url = format!("http://127.0.0.1:{}/v1/captures", server.handle.local_addr().port());
    for (host, expected) in [
        ("evil.example", 403),
        ("evil.example:7070", 403),
        ("twin.example:7070", 200),
        ("localhost", 200),
        ("192.168.1.7:7070", 200),
    ] {
        let request = server.http.get(&url).header("host", host);
        let (status, problem) = read(request.send().await.unwrap()).await;
        assert_eq!(status, expected, "{host}: {problem}");
        if expected == 403 {
            assert_eq!(problem["reason"], "HOST_NOT_ALLOWED");
            assert!(problem["detail"].as_str().unwrap().contains("--allowed-host evil.example"));
        }
    }
}

#[tokio::test]
async fn two_hosts_are_refused() {
    use tokio::io::{AsyncReadExt as _, AsyncWriteExt as _};
    let server = Server::start().await;
    for head in [
        "GET /healthz HTTP/1.1\r\nhost: localhost\r\nhost: localhost\r\n\r\n",
        "GET http://localhost/healthz HTTP/1.1\r\nhost: 127.0.0.1\r\n\r\n",
        "GET /healthz HTTP/1.1\r\nhost: a b\r\n\r\n",
    ] {
        let address = server.handle.local_addr();
        let mut stream = tokio::net::TcpStream::connect(address).await.unwrap();
        stream.write_all(head.as_bytes()).await.unwrap();
        let mut answer = [0; 12];
        stream.read_exact(&mut answer).await.unwrap();
        assert_eq!(&answer, b"HTTP/1.1 400", "{head}");
    }
}

/// A stranger must not fill the metrics with made-up names.
#[tokio::test]
async fn metrics_have_the_names_of_methods_that_exist() {
    let server = Server::start().await;
    for origin in [None, Some("http://evil.example")] {
        for path in ["/bendtwin.v1.FitService/GetFit", "/made.up.Service/Name", "/made/up"] {
            let call = server.http.post(server.url(path)).body("\0\0\0\0\0");
            let call = call.header("content-type", "application/grpc").header("te", "trailers");
            let call = origin.into_iter().fold(call, |c, o| c.header("origin", o));
            let status = call.send().await.unwrap().headers().get("grpc-status").cloned();
            assert!(status.is_some_and(|s| s != "0"), "{path} {origin:?}");
        }
    }
    let metrics = server.http.get(server.url("/metrics")).send().await.unwrap();
    let metrics = metrics.text().await.unwrap();
    assert!(!metrics.contains("made"), "{metrics}");
    let own = r#"transport="grpc",route="/bendtwin.v1.FitService/GetFit""#;
    assert!(metrics.contains(own) && metrics.contains(r#"transport="grpc",route="none""#));
}
