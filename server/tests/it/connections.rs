//! Connections and bodies that only take: clients that are silent, slow, or do not read.

mod tls;

use std::{sync::Arc, time::Duration};

use tokio::{
    io::{AsyncReadExt as _, AsyncWriteExt as _},
    net::TcpStream,
    sync::Notify,
    time::timeout,
};
use tonic::Code;

use crate::{
    harness::{Server, TOKEN, read},
    simulation::rollouts::{request, twin},
    worker::{Device, Worker},
};

/// Ample time for anything that has to happen.
const SOON: Duration = Duration::from_secs(30);

async fn connect(server: &Server) -> TcpStream {
    TcpStream::connect(server.handle.local_addr()).await.unwrap()
}

/// All that the server sends until it closes the connection.
async fn to_the_end(stream: &mut TcpStream) -> Vec<u8> {
    let mut answer = Vec::new();
    let ended = timeout(SOON, stream.read_to_end(&mut answer)).await;
    ended.expect("the server keeps the connection open").ok();
    answer
}

/// A server with one slot for rollouts, whose worker sends large parts, and a twin.
async fn one_slot(stream_idle_s: f64) -> (Server, Worker, String) {
    let server = Server::start_with(|o| {
        o.limits.rollouts_per_worker = 1;
        o.limits.stream_idle_s = stream_idle_s;
    })
    .await;
    let device = Device { part_costs: 1 << 17, ..Device::default() };
    let mut worker = Worker::register_with(&server, device).await;
    let twin = twin(&server, &mut worker).await;
    (server, worker, twin)
}

#[tokio::test]
async fn an_unread_stream_frees_its_slot() {
    let (server, _worker, twin) = one_slot(0.3).await;
    let mut rollouts = server.rollouts();
    let unread = rollouts.stream_roll_out(request(&twin, 640)).await.unwrap();
    let next = rollouts.roll_out(request(&twin, 1));
    timeout(SOON, next).await.expect("the slot is held").unwrap();
    // A client that reads after all hears of it.
    let mut parts = unread.into_inner();
    let status = loop {
        match timeout(SOON, parts.message()).await.unwrap() {
            Ok(Some(_)) => {}
            Ok(None) => panic!("the stream ended as if it were whole"),
            Err(status) => break status,
        }
    };
    assert_eq!(status.code(), Code::ResourceExhausted, "{status:?}");
    assert_eq!(bendtwin_proto::fault::fault(&status).reason, "RESPONSE_UNREAD");
}

#[tokio::test]
async fn an_unread_stream_ends_at_its_deadline() {
    let (server, _worker, twin) = one_slot(3600.0).await;
    let mut rollouts = server.rollouts();
    let mut call = tonic::Request::new(request(&twin, 640));
    call.set_timeout(Duration::from_secs(2));
    let _unread = rollouts.stream_roll_out(call).await.unwrap();
    let next = rollouts.roll_out(request(&twin, 1));
    timeout(SOON, next).await.expect("the slot is held").unwrap();
}

#[tokio::test]
async fn an_unread_download_is_closed() {
    let server = Server::start_with(|o| {
        o.limits.stream_idle_s = 0.2;
        o.limits.head_timeout_s = 0.2;
    })
    .await;
    let size = 32 << 20;
    let upload = server.http.post(server.url("/v1/captures")).body(vec![7u8; size]);
    let upload = upload.header("content-type", "application/zip");
    let (_, capture) = read(upload.send().await.unwrap()).await;
    let mut stream = connect(&server).await;
    let name = capture["name"].as_str().unwrap();
    let head = format!("GET /v1/{name}/content HTTP/1.1\r\nhost: localhost\r\n\r\n");
    stream.write_all(head.as_bytes()).await.unwrap();
    let closed = async {
        let ended = r#"bendtwin_connections_ended_total{listener="public",why="idle"}"#;
        let metrics = async || reqwest::get(server.url("/metrics")).await.unwrap().text().await;
        while !metrics().await.unwrap().contains(ended) {
            tokio::time::sleep(Duration::from_millis(20)).await;
        }
    };
    timeout(SOON, closed).await.expect("the connection stays open");
    let answer = to_the_end(&mut stream).await;
    assert!(answer.starts_with(b"HTTP/1.1 200") && answer.len() < size, "{}", answer.len());
}

#[tokio::test]
async fn a_download_that_is_read_comes_whole() {
    let server = Server::start_with(|o| o.limits.stream_idle_s = 5.0).await;
    let content: Vec<u8> = (0..3 << 20).map(|i: u32| i.to_le_bytes()[1]).collect();
    let upload = server.http.post(server.url("/v1/captures")).body(content.clone());
    let upload = upload.header("content-type", "application/zip");
    let (_, capture) = read(upload.send().await.unwrap()).await;
    let url = server.url(&format!("/v1/{}/content", capture["name"].as_str().unwrap()));
    let response = server.http.get(url).send().await.unwrap();
    assert_eq!(response.content_length(), Some(content.len() as u64));
    assert_eq!(response.bytes().await.unwrap(), content);
}

#[tokio::test]
async fn connections_without_a_request_are_closed() {
    let server = Server::start_with(|o| o.limits.head_timeout_s = 0.2).await;
    for start in [
        &b""[..],
        b"PRI * HTTP/2.0\r\n",
        b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n",
        // The settings of HTTP/2, but no request.
        b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n\0\0\0\x04\0\0\0\0\0",
        b"GET /healthz HTTP/1.1\r\nhost: loc",
    ] {
        let mut stream = connect(&server).await;
        stream.write_all(start).await.unwrap();
        let answer = to_the_end(&mut stream).await;
        assert!(!answer.starts_with(b"HTTP/1.1 2"), "{start:?}");
    }
}

#[tokio::test]
async fn silent_connections_make_room_for_new_ones() {
    let server = Server::start_with(|o| {
        o.limits.connections = 8;
        o.limits.connections_per_peer = 6;
        o.limits.head_timeout_s = 3600.0;
    })
    .await;
    let mut silent = Vec::new();
    for _ in 0..40 {
        let mut stream = connect(&server).await;
        stream.write_all(b"PRI * HTTP/2.0").await.unwrap();
        silent.push(stream);
        let asked = timeout(SOON, server.http.get(server.url("/healthz")).send()).await;
        assert_eq!(asked.expect("no answer").unwrap().status(), 200);
    }
    let metrics = server.http.get(server.url("/metrics")).send().await.unwrap();
    let metrics = metrics.text().await.unwrap();
    let evicted = r#"bendtwin_connections_ended_total{listener="public",why="evicted"}"#;
    assert!(metrics.contains(evicted), "{metrics}");
    assert!(metrics.contains(r#"bendtwin_connections{listener="public"}"#), "{metrics}");
}

#[tokio::test]
async fn bodies_that_do_not_come_make_room_and_end() {
    let server = Server::start_with(|o| {
        o.limits.connections = 4;
        o.limits.connections_per_peer = 4;
        o.limits.upload_idle_s = 0.1;
    })
    .await;
    let head = b"POST /v1/fits HTTP/1.1\r\nhost: localhost\r\ncontent-type: application/json\r\n\
                 content-length: 100\r\n\r\n";
    let mut waiting = Vec::new();
    for _ in 0..20 {
        let mut stream = connect(&server).await;
        stream.write_all(head).await.unwrap();
        waiting.push(stream);
        let asked = timeout(SOON, server.http.get(server.url("/healthz")).send()).await;
        assert_eq!(asked.expect("no answer").unwrap().status(), 200);
    }
    let mut last = waiting.pop().unwrap();
    let answer = String::from_utf8(to_the_end(&mut last).await).unwrap();
    assert!(answer.starts_with("HTTP/1.1 400") && answer.contains("BODY_TOO_SLOW"), "{answer}");
}

#[tokio::test]
async fn workers_have_a_separate_port() {
    let server = Server::start_with(|o| {
        o.limits.connections = 1;
        o.limits.connections_per_peer = 1;
    })
    .await;
    // A watcher takes the only place at the public door and is at work.
    let fit = server.fit().await;
    let watch = server.http.get(server.url(&format!("/v1/{fit}/events"))).send().await.unwrap();
    let refused = reqwest::Client::new().get(server.url("/healthz")).send().await;
    assert!(refused.is_err(), "{refused:?}");
    let door = format!("http://{}", server.handle.worker_addr());
    // No worker has come so far, so it is not ready.
    for (path, status) in
        [("/healthz", 200), ("/readyz", 503), ("/metrics", 200), ("/v1/captures", 404)]
    {
        let response = reqwest::get(format!("{door}{path}")).await.unwrap();
        assert_eq!(response.status(), status, "{path}");
    }
    use bendtwin_proto::worker::v1::{HeartbeatRequest, worker_link_client::WorkerLinkClient};
    let mut link = WorkerLinkClient::connect(door.clone()).await.unwrap();
    let worker = bendtwin_core::ids::WorkerId::generate().to_string();
    let beat = || HeartbeatRequest { worker: worker.clone(), ..HeartbeatRequest::default() };
    let without = link.heartbeat(beat()).await.unwrap_err();
    assert_eq!(without.code(), Code::Unauthenticated);
    let mut with = tonic::Request::new(beat());
    let value = format!("Bearer {TOKEN}").parse().unwrap();
    with.metadata_mut().insert("authorization", value);
    // The token is good; the worker is one that has not registered.
    assert_ne!(link.heartbeat(with).await.unwrap_err().code(), Code::Unauthenticated);
    // The public API is not there.
    let channel = tonic::transport::Endpoint::from_shared(door).unwrap().connect_lazy();
    let mut fits = bendtwin_proto::v1::fit_service_client::FitServiceClient::new(channel);
    let listed = fits.list_fits(bendtwin_proto::v1::ListFitsRequest::default()).await;
    assert_eq!(listed.unwrap_err().code(), Code::Unimplemented);
    drop(watch);
}

#[tokio::test]
async fn a_refusal_reaches_clients_that_send_everything_before_they_read() {
    let server = Server::start().await;
    let body = vec![b' '; 6 << 20];
    for (path, media, status) in
        [("/v1/fits", "application/json", "413"), ("/v1/captures", "text/html", "415")]
    {
        let mut stream = connect(&server).await;
        let head = format!(
            "POST {path} HTTP/1.1\r\nhost: localhost\r\ncontent-type: {media}\r\n\
             content-length: {}\r\nconnection: close\r\n\r\n",
            body.len()
        );
        stream.write_all(head.as_bytes()).await.unwrap();
        timeout(SOON, stream.write_all(&body)).await.unwrap().expect("the pipe broke");
        let answer = String::from_utf8(to_the_end(&mut stream).await).unwrap();
        assert!(answer.starts_with(&format!("HTTP/1.1 {status}")), "{answer}");
    }
}

#[tokio::test]
async fn a_shutdown_does_not_wait_for_silent_connections() {
    let server = Server::start_with(|o| o.shutdown_grace_s = 600.0).await;
    let silent = connect(&server).await;
    let mut half = connect(&server).await;
    half.write_all(b"GET / HTTP/1.1\r\n").await.unwrap();
    let mut asked = connect(&server).await;
    asked.write_all(b"GET /healthz HTTP/1.1\r\nhost: localhost\r\n\r\n").await.unwrap();
    asked.read_exact(&mut [0; 12]).await.unwrap();
    // HTTP/2, also idle.
    server
        .captures()
        .list_captures(bendtwin_proto::v1::ListCapturesRequest::default())
        .await
        .unwrap();
    let Server { handle, .. } = server;
    timeout(SOON, handle.shutdown()).await.expect("the shutdown waits");
    drop((silent, half, asked));
}

#[tokio::test]
async fn a_shutdown_lets_requests_under_way_finish() {
    let server = Server::start_with(|o| o.shutdown_grace_s = 600.0).await;
    let hold = Arc::new(Notify::new());
    let device = Device { hold: Some(hold.clone()), ..Device::default() };
    let mut worker = Worker::register_with(&server, device.clone()).await;
    let twin = twin(&server, &mut worker).await;
    let mut rollouts = server.rollouts();
    let running = tokio::spawn(async move { rollouts.roll_out(request(&twin, 1)).await });
    timeout(SOON, device.begun.notified()).await.unwrap();
    let Server { handle, .. } = server;
    let stopping = tokio::spawn(handle.shutdown());
    tokio::time::sleep(Duration::from_millis(50)).await;
    hold.notify_one();
    timeout(SOON, running).await.unwrap().unwrap().unwrap();
    timeout(SOON, stopping).await.unwrap().unwrap();
}
