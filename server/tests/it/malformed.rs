//! Malformed requests: each is refused, and the server survives.

use bendtwin_proto::v1::{
    self, ControlTrajectories, CreateCaptureRequest, CreateFitRequest, RollOutRequest, Tensor,
    create_capture_request, roll_out_request::Actions,
};
use bytes::Bytes;
use reqwest::Method;
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tonic::Code;

use crate::{harness::Server, worker::Worker};

const NONE: &str = "00000000-0000-7000-8000-000000000000";

/// Method, path, content type, body.
fn http_requests(capture: &str, twin: &str) -> Vec<(Method, String, &'static str, Vec<u8>)> {
    let mut all = Vec::new();
    let mut add = |method: &Method, path: String, media: &'static str, body: &str| {
        all.push((method.clone(), path, media, body.as_bytes().to_vec()));
    };
    let (get, post, delete, put) = (Method::GET, Method::POST, Method::DELETE, Method::PUT);
    let json = "application/json";
    for path in [
        "/index.html",
        "/v1",
        "/v1/",
        "/v2/captures",
        "/v1/captures/",
        "/v1/captures/a/b",
        "/V1/fits",
        "/v1//fits",
        "/%00",
        "/..%2f..%2fetc%2fpasswd",
    ] {
        add(&get, path.to_owned(), json, "");
    }
    for collection in ["captures", "fits", "twins", "workers"] {
        for id in ["x", NONE, "%ff", "%00", "..", "-1", "''--", "fits%2Fx", &"9".repeat(3000)] {
            add(&get, format!("/v1/{collection}/{id}"), json, "");
        }
        for query in [
            "page_size=-1",
            "page_size=x",
            "page_size=99999999999",
            "page_token=x",
            "page_token=%00",
            "unknown=1",
        ] {
            add(&get, format!("/v1/{collection}?{query}"), json, "");
        }
        add(&put, format!("/v1/{collection}"), json, "{}");
        add(&delete, format!("/v1/{collection}"), json, "");
    }
    for collection in ["captures", "fits", "twins"] {
        add(&delete, format!("/v1/{collection}/{NONE}"), json, "");
        add(&delete, format!("/v1/{collection}/x"), json, "");
    }
    let deep = format!("{}{}", "[".repeat(5000), "]".repeat(5000));
    for body in [
        "",
        "{",
        "[]",
        "null",
        "3",
        "\"x\"",
        "{}",
        r#"{"capture": 3}"#,
        r#"{"capture": "x"}"#,
        "\u{0}",
        &deep,
        &" ".repeat(2 << 20),
    ] {
        add(&post, "/v1/fits".to_owned(), json, body);
    }
    for rest in [
        r#""priority": 101"#,
        r#""priority": 1e99"#,
        r#""priority": "x""#,
        r#""settings": 3"#,
        r#""settings": {"unknown": 1}"#,
        r#""settings": {"graph": {"radius_m": -1}}"#,
        r#""settings": {"graph": {"max_nodes": 0}}"#,
        r#""settings": []"#,
        r#""other": 1"#,
        r#""settings": {"substeps": {"fixed": 0}}"#,
        r#""settings": {"seed": -1}"#,
    ] {
        add(&post, "/v1/fits".to_owned(), json, &format!(r#"{{"capture": "{capture}", {rest}}}"#));
    }
    add(&post, "/v1/fits".to_owned(), "text/plain", &format!(r#"{{"capture": "{capture}"}}"#));
    add(&post, format!("/v1/fits/{NONE}/cancel"), json, "");
    add(&get, format!("/v1/fits/{NONE}/events"), json, "");
    let long = "n".repeat(201);
    add(&post, format!("/v1/captures?display_name={long}"), "application/zip", "x");
    add(&post, "/v1/captures?display_name=a%0Ab".to_owned(), "application/zip", "x");
    add(&post, "/v1/captures?digest=xyz".to_owned(), "application/zip", "x");
    add(&post, "/v1/captures".to_owned(), "text/html", "x");
    add(&post, "/v1/captures".to_owned(), "application/zip", "");
    add(&post, "/v1/twins".to_owned(), "application/octet-stream", "no twin");
    let rollouts = format!("/v1/{twin}/rollouts");
    for body in [
        "",
        "{}",
        "[]",
        r#"{"trajectories": {}}"#,
        r#"{"trajectories": {"positions": 3}}"#,
        r#"{"trajectories": {"positions": []}}"#,
        r#"{"trajectories": {"positions": [[[[1,2,3]]]]}}"#,
        r#"{"trajectories": {"positions": [[[[1,2]],[[1,2]]]]}}"#,
        r#"{"trajectories": {"positions": [[[[1,2,3],[1,2,3]],[[1,2,3],[1,2,3]]]]}}"#,
        r#"{"trajectories": {"positions": [[[[1,2,null]],[[1,2,3]]]]}}"#,
        r#"{"trajectories": {"positions": {"dtype": "FLOAT32", "shape": [18446744073709551615, 2, 1, 3], "data": ""}}}"#,
        r#"{"trajectories": {"positions": {"dtype": "FLOAT32", "shape": [1, 2, 1, 3], "data": "AAAA"}}}"#,
        r#"{"poses": {"poses": [[[[0,0,0]],[[0,0,0]]]]}}"#,
        r#"{"trajectories": {"positions": [[[[1,2,3]],[[1,2,3]]]]}, "frames": 4294967295}"#,
        r#"{"trajectories": {"positions": [[[[1,2,3]],[[1,2,3]]]]}, "frames": -1}"#,
        r#"{"trajectories": {"positions": [[[[1,2,3]],[[1,2,3]]]]}, "costs": [{"weight": 1}]}"#,
        r#"{"trajectories": {"positions": [[[[1,2,3]],[[1,2,3]]]]}, "initial": {"given": {"positions": [[0,0,0]]}}}"#,
        r#"{"trajectories": {"positions": [[[[1,2,3]],[[1,2,3]]]]}, "initial": {"nowhere": {}}}"#,
        r#"{"trajectories": {"positions": [[[[1,2,3]],[[1,2,3]]]]}, "poses": {"poses": []}}"#,
    ] {
        add(&post, rollouts.clone(), json, body);
    }
    add(&post, rollouts.clone(), "application/x-protobuf", "\u{7f}\u{7f}\u{7f}");
    add(&post, format!("{rollouts}?timeout_s=-1"), json, "{}");
    add(&post, format!("{rollouts}?tensors=x"), json, "{}");
    add(
        &post,
        format!("/v1/twins/{NONE}/rollouts"),
        json,
        r#"{"trajectories": {"positions": [[[[1,2,3]],[[1,2,3]]]]}}"#,
    );
    all
}

#[tokio::test]
async fn http_requests_get_4xx() {
    let server = Server::start().await;
    let mut worker = Worker::register(&server).await;
    let capture = server.capture().await;
    server.fit().await;
    let lease = worker.lease(std::time::Duration::ZERO).await.unwrap();
    let twin = worker.complete(&lease, b"a twin").await.unwrap();
    let requests = http_requests(&capture, &twin);
    assert!(requests.len() >= 120, "{}", requests.len());
    for (method, path, media, body) in requests {
        let request = server.http.request(method.clone(), server.url(&path));
        let response =
            request.header("content-type", media).body(body.clone()).send().await.unwrap();
        let status = response.status();
        let text = response.text().await.unwrap();
        let shown = String::from_utf8_lossy(&body[..body.len().min(100)]).into_owned();
        assert!(status.is_client_error(), "{method} {path} {shown}: {status} {text}");
        let problem: serde_json::Value = serde_json::from_str(&text)
            .unwrap_or_else(|_| panic!("{method} {path} {shown}: {text}"));
        assert_eq!(problem["status"], status.as_u16());
        assert!(problem["detail"].as_str().unwrap().len() < 2000);
    }
    assert_eq!(server.get("/healthz").await.0, 200);
    let (_, fits) = server.get("/v1/fits").await;
    assert_eq!(fits["fits"].as_array().unwrap().len(), 1);
}

#[tokio::test]
async fn bytes_that_are_no_http_do_no_harm() {
    let server = Server::start().await;
    for bytes in [
        &b"\x00\x01\x02\x03"[..],
        b"GET",
        b"GET / HTTP/9.9\r\n\r\n",
        b"GET / HTTP/1.1\r\nhost: localhost\r\ncontent-length: x\r\n\r\n",
        b"POST /v1/fits HTTP/1.1\r\nhost: localhost\r\ntransfer-encoding: chunked\r\n\r\nZZZ\r\n",
        b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n\xff\xff\xff\xff\xff\xff\xff\xff\xff",
        b"\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03",
        b"GET / HTTP/1.1\r\nno colon\r\n\r\n",
    ] {
        let mut stream = tokio::net::TcpStream::connect(server.handle.local_addr()).await.unwrap();
        let _ = stream.write_all(bytes).await;
        let _ = stream.shutdown().await;
        let mut answer = Vec::new();
        let _ = stream.read_to_end(&mut answer).await;
        assert!(!answer.starts_with(b"HTTP/1.1 2") && !answer.starts_with(b"HTTP/1.1 5"));
    }
    assert_eq!(server.get("/healthz").await.0, 200);
}

#[tokio::test]
async fn grpc_requests_get_their_codes() {
    let server = Server::start().await;
    let capture = server.capture().await;
    let mut count = 0;
    let mut is = |status: tonic::Status, code: Code, what: &str| {
        count += 1;
        assert_eq!(status.code(), code, "{what}: {status:?}");
        assert!(!bendtwin_proto::fault::fault(&status).reason.is_empty());
    };
    let none = |collection: &str| format!("{collection}/{NONE}");
    for (name, code) in
        [("", Code::InvalidArgument), ("x", Code::InvalidArgument), (NONE, Code::NotFound)]
    {
        let name = || name.to_owned();
        let (mut captures, mut fits, mut twins) =
            (server.captures(), server.fits(), server.twins());
        is(
            captures.get_capture(v1::GetCaptureRequest { name: name() }).await.unwrap_err(),
            code,
            "capture",
        );
        is(
            captures
                .delete_capture(v1::DeleteCaptureRequest { name: name(), purge: false })
                .await
                .unwrap_err(),
            code,
            "capture",
        );
        is(fits.get_fit(v1::GetFitRequest { name: name() }).await.unwrap_err(), code, "fit");
        is(
            fits.cancel_fit(v1::CancelFitRequest { name: name() }).await.unwrap_err(),
            code,
            "cancel",
        );
        is(
            fits.delete_fit(v1::DeleteFitRequest { name: name(), purge: false }).await.unwrap_err(),
            code,
            "fit",
        );
        let watch = v1::WatchFitRequest { name: name(), after_revision: 0 };
        is(fits.watch_fit(watch).await.unwrap_err(), code, "watch");
        is(twins.get_twin(v1::GetTwinRequest { name: name() }).await.unwrap_err(), code, "twin");
        is(
            twins
                .delete_twin(v1::DeleteTwinRequest { name: name(), purge: false })
                .await
                .unwrap_err(),
            code,
            "twin",
        );
        is(
            twins.export_twin(v1::ExportTwinRequest { name: name() }).await.unwrap_err(),
            code,
            "twin",
        );
        let create = CreateFitRequest { capture: name(), ..CreateFitRequest::default() };
        is(fits.create_fit(create).await.unwrap_err(), code, "create");
        let positions = Some(Tensor::pack(&[1, 2, 1, 3], &[0.0f32; 6]));
        let actions = Actions::Trajectories(ControlTrajectories { positions, interpolation: 0 });
        let request =
            RollOutRequest { twin: name(), actions: Some(actions), ..RollOutRequest::default() };
        is(server.rollouts().roll_out(request).await.unwrap_err(), code, "rollout");
    }
    // Names of another collection do not belong to this one.
    let name = none("twins");
    is(
        server.fits().get_fit(v1::GetFitRequest { name }).await.unwrap_err(),
        Code::InvalidArgument,
        "other",
    );
    for (settings_json, priority, request_id) in [
        ("{", 0, ""),
        ("3", 0, ""),
        (r#"{"x": 1}"#, 0, ""),
        ("", 101, ""),
        ("", i32::MIN, ""),
        ("", 0, "a\nb"),
        ("", 0, &"x".repeat(129)),
        (&"[".repeat(100_000), 0, ""),
    ] {
        let request = CreateFitRequest {
            capture: capture.clone(),
            settings_json: settings_json.into(),
            priority,
            request_id: request_id.into(),
            ..CreateFitRequest::default()
        };
        is(server.fits().create_fit(request).await.unwrap_err(), Code::InvalidArgument, "settings");
    }
    for page_token in ["x", "-", &format!("{NONE}-00000000")] {
        let page_token = page_token.to_owned();
        let request = v1::ListFitsRequest {
            page_token: page_token.clone(),
            ..v1::ListFitsRequest::default()
        };
        is(server.fits().list_fits(request).await.unwrap_err(), Code::InvalidArgument, "token");
        let request = v1::ListTwinsRequest { page_token, ..v1::ListTwinsRequest::default() };
        is(server.twins().list_twins(request).await.unwrap_err(), Code::InvalidArgument, "token");
    }
    // Uploads that begin or continue wrongly.
    use create_capture_request::Part;
    let chunk = || Part::Chunk(Bytes::from_static(b"x"));
    let metadata = || Part::Metadata(v1::CaptureMetadata::default());
    let named = |n: &str| {
        Part::Metadata(v1::CaptureMetadata { display_name: n.into(), ..Default::default() })
    };
    let uploads = [
        vec![],
        vec![None],
        vec![Some(chunk())],
        vec![Some(metadata())],
        vec![Some(metadata()), Some(metadata())],
        vec![Some(metadata()), None],
        vec![Some(named(&"n".repeat(201))), Some(chunk())],
        vec![Some(named("\u{7}")), Some(chunk())],
    ];
    for parts in uploads {
        let parts: Vec<_> = parts.into_iter().map(|part| CreateCaptureRequest { part }).collect();
        let status =
            server.captures().create_capture(futures::stream::iter(parts)).await.unwrap_err();
        is(status, Code::InvalidArgument, "upload");
    }
    assert!(count >= 50, "{count}");
    assert_eq!(server.get("/healthz").await.0, 200);
    assert_eq!(server.get("/v1/captures").await.1["captures"].as_array().unwrap().len(), 1);
}

/// Calls that no generated client would make.
#[tokio::test]
async fn raw_grpc_calls_get_a_status() {
    let server = Server::start().await;
    let client = &server.http;
    for (path, body) in [
        ("/bendtwin.v1.Nothing/Nothing", &b"\0\0\0\0\0"[..]),
        ("/bendtwin.v1.FitService/Nothing", b"\0\0\0\0\0"),
        ("/bendtwin.v1.FitService/GetFit", b""),
        ("/bendtwin.v1.FitService/GetFit", b"\0\0\0"),
        ("/bendtwin.v1.FitService/GetFit", b"\0\xff\xff\xff\xff"),
        ("/bendtwin.v1.FitService/GetFit", b"\x01\0\0\0\x01x"),
        ("/bendtwin.v1.FitService/GetFit", b"\0\0\0\0\x03\xff\xff\xff"),
        ("/bendtwin.v1.FitService/GetFit", b"\x09\0\0\0\0"),
        ("/", b"\0\0\0\0\0"),
    ] {
        let request = client.post(server.url(path)).header("content-type", "application/grpc");
        let response = request.header("te", "trailers").body(body).send().await.unwrap();
        let status = response.headers().get("grpc-status").map(|v| v.to_str().unwrap().to_owned());
        assert!(status.is_some_and(|s| s != "0"), "{path} {body:?}");
    }
    assert_eq!(server.get("/healthz").await.0, 200);
}
